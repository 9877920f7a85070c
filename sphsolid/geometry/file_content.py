"""What a mesh file says, before anything is made of it: the same for every format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.cell_shape import HEXAHEDRON, TETRAHEDRON, CellShape

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Cells that a body can be made of, by their name in meshio; of a second-order cell the corners
#: come first, in the order of the first-order one.
BODY_CELLS: dict[str, CellShape] = {
    "tetra": TETRAHEDRON,
    "tetra10": TETRAHEDRON,
    "hexahedron": HEXAHEDRON,
    "hexahedron20": HEXAHEDRON,
    "hexahedron27": HEXAHEDRON,
}
#: Corners of the cells of a surface, by their name in meshio.
SURFACE_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
#: Cells of lines and points, by their name in meshio: no part of a body or its boundary.
LINES_AND_POINTS = ("vertex", "line", "line3", "line4")


@dataclass(frozen=True)
class Block:
    """Cells of one kind: ``nodes (n, k)`` count the points of the file from zero."""

    kind: str
    nodes: Indices

    @property
    def corners(self) -> Indices:
        """The corner vertices of surface cells ``(n, 3)`` or ``(n, 4)``."""
        return self.nodes[:, : SURFACE_CORNERS[self.kind]]


@dataclass(frozen=True)
class NamedSet:
    """Facets, or ``points (k,)`` that stand for some, under a name that is not theirs alone.

    Sets of a file may overlap and share a name.  ``kind``: what the format calls it, for
    messages; ``facets``: blocks of surface cells; ``internal``: a program made it for itself.
    """

    name: str
    kind: str
    facets: tuple[Block, ...] = ()
    points: Indices | None = None
    internal: bool = False


@dataclass(frozen=True)
class FileContent:
    """Points ``(n, 3)`` in units of the file, all cells, and what the file gives a name.

    ``tags``: name -> blocks of surface cells, no block at all for a name that is declared and
    not used, where the names of a format may not overlap; ``sets``: where they may; ``notes``:
    what of the file is not read and a user should hear of; ``way_out``: what to do about a file
    that has no cells of a volume.
    """

    points: Array
    cells: tuple[Block, ...]
    tags: Mapping[str, tuple[Block, ...]]
    sets: tuple[NamedSet, ...] = ()
    notes: tuple[str, ...] = ()
    way_out: str = "mesh the body in 3D and save its cells"

    def kinds(self) -> str:
        """The cells that there are, for a message: ``12 tetra, 8 triangle``."""
        count: dict[str, int] = {}
        for block in self.cells:
            count[block.kind] = count.get(block.kind, 0) + len(block.nodes)
        return ", ".join(f"{n} {kind}" for kind, n in count.items() if n) or "no cells"
