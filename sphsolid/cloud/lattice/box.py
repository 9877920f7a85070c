"""Is a mesh a full box of equidistant points, and which particle sits at each of them?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
#: Share of the spacing within which coordinates are the same.
_SAME = 1.0e-6


@dataclass(frozen=True, eq=False)
class BoxLattice:
    """``counts = (nx, ny, nz)`` points along X, Y, Z, ``dx (3,)`` [m] apart.

    ``number (nx, ny, nz)`` is the particle at each point, whatever the numbering of the mesh is.
    """

    counts: tuple[int, int, int]
    dx: Array
    number: NDArray[np.int64]

    @property
    def is_ordered(self) -> bool:
        """True where particle ``(i, j, k)`` has the number ``(i ny + j) nz + k``."""
        return bool(np.array_equal(self.number.ravel(), np.arange(self.number.size)))


@dataclass(frozen=True)
class NoBox:
    """The vertices are no full box of equidistant points."""


def box_of(mesh: Mesh) -> BoxLattice | NoBox:
    """The box that the vertices of ``mesh`` fill, if it is one and its cells fill it."""
    if not mesh.is_lattice:
        return NoBox()
    X, same = mesh.vertices, _SAME * mesh.spacing
    place = np.stack([_plane_of(X[:, axis], same) for axis in range(3)])
    nx, ny, nz = (int(n) + 1 for n in place.max(axis=1))
    if min(nx, ny, nz) < 2 or nx * ny * nz != len(X):
        return NoBox()
    number = np.full((nx, ny, nz), -1)
    number[tuple(place)] = np.arange(len(X))
    if np.any(number < 0):
        return NoBox()
    lower, sides = X.min(axis=0), np.ptp(X, axis=0)
    dx = sides / (np.array([nx, ny, nz]) - 1)
    # Two parts whose gap is one cell wide have all points of a box too.
    filled = float(np.sum(vertex_volumes(mesh)))
    equidistant = np.abs(X - lower - place.T * dx) <= same
    if not np.all(equidistant) or abs(filled / float(np.prod(sides)) - 1.0) > _SAME:
        return NoBox()
    return BoxLattice((nx, ny, nz), dx, number)


def _plane_of(coordinate: Array, same: float) -> NDArray[np.int64]:
    """Ordinal number of the plane on which each vertex lies ``(N,)``."""
    order = np.argsort(coordinate, kind="stable")
    ordinal = np.empty(len(order), dtype=np.int64)
    ordinal[order] = np.concatenate([[0], np.cumsum(np.diff(coordinate[order]) > same)])
    return ordinal
