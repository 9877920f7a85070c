"""A hexahedral mesh as plain arrays: what both solvers discretise a body with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError

#: Corner ``c`` of a cell sits at reference coordinates ``CORNERS[c]`` in {0, 1}^3.
CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


@dataclass(frozen=True)
class HexMesh:
    """Vertices, eight-node cells and tagged outward boundary quadrilaterals.

    ``vertices (N, 3)`` [m]; ``cells (C, 8)`` corner order of :data:`CORNERS`;
    ``faces`` name -> ``(f, 4)`` vertex loops, counter-clockwise seen from outside;
    ``spacing`` [m] the nominal edge length; ``is_lattice`` True when the vertices sit on a
    regular axis-aligned grid of that spacing (per axis up to rounding to whole cells).
    """

    vertices: NDArray[np.float64]
    cells: NDArray[np.int64]
    faces: dict[str, NDArray[np.int64]]
    spacing: float
    is_lattice: bool

    def face(self, name: str) -> NDArray[np.int64]:
        """Quadrilaterals of a tag; raises ``InputError`` naming the tags there are."""
        if name not in self.faces or len(self.faces[name]) == 0:
            raise InputError(
                f"boundary tag {name!r} is unknown or empty; the body has {sorted(self.faces)}"
            )
        return self.faces[name]

    def face_particles(self, name: str) -> NDArray[np.int64]:
        """Sorted vertices of a tag."""
        return np.unique(self.face(name))

    @property
    def boundary(self) -> NDArray[np.int64]:
        """All boundary quadrilaterals ``(f, 4)``."""
        return np.concatenate([self.faces[name] for name in sorted(self.faces)])
