"""A hexahedral mesh as plain arrays: what both solvers discretise a body with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require

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


def box_mesh(
    lower: tuple[float, float, float],
    upper: tuple[float, float, float],
    spacing: float,
    jitter: float = 0.0,
    seed: int = 0,
) -> HexMesh:
    """Hexahedra filling a box; tags ``X- X+ Y- Y+ Z- Z+``.

    Each edge is cut into ``round(length / spacing)`` equal cells (at least one).  ``jitter``
    moves interior vertices, and boundary vertices within their face or edge, by a uniform random
    offset of at most ``jitter * spacing / 2`` per component, so the body and its volume stay
    exact.  Raises ``InputError`` for a non-positive spacing or a jitter outside [0, 0.9].
    """
    require(np.isfinite(spacing) and spacing > 0.0, f"spacing = {spacing} m must be positive")
    require(0.0 <= jitter <= 0.9, f"jitter = {jitter} is outside [0, 0.9] of the spacing")
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    require(bool(np.all(high > low)), f"box upper {upper} must exceed lower {lower} in every axis")
    counts = np.maximum(1, np.rint((high - low) / spacing).astype(int))
    axes = [np.linspace(low[d], high[d], counts[d] + 1) for d in range(3)]
    vertices = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    shape = counts + 1
    number = np.arange(len(vertices)).reshape(shape)
    nx, ny, nz = counts
    corner = [
        number[i : i + nx, j : j + ny, k : k + nz].ravel() for i, j, k in CORNERS
    ]
    cells = np.stack(corner, axis=1)

    def quads(a: NDArray[np.int64], flip: bool) -> NDArray[np.int64]:
        loop = [a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]]
        quad = np.stack([part.ravel() for part in loop], axis=1)
        return quad[:, ::-1].copy() if flip else quad

    faces = {
        "X-": quads(number[0], flip=True),
        "X+": quads(number[-1], flip=False),
        "Y-": quads(number[:, 0], flip=False),
        "Y+": quads(number[:, -1], flip=True),
        "Z-": quads(number[:, :, 0], flip=True),
        "Z+": quads(number[:, :, -1], flip=False),
    }
    if jitter > 0.0:
        step = (high - low) / counts
        offset = np.random.default_rng(seed).uniform(-0.5, 0.5, vertices.shape) * jitter * step
        on_face = np.isclose(vertices, low) | np.isclose(vertices, high)
        vertices = vertices + np.where(on_face, 0.0, offset)
    # Every axis has its own whole number of cells; the smallest edge is what limits the step.
    edge = float(np.min((high - low) / counts))
    return HexMesh(vertices, cells, faces, edge, is_lattice=jitter == 0.0)
