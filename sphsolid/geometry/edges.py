"""The edges of the cells of a mesh: nearest pairs of its vertices, joined by material."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh, Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Local corners at the ends of the edges of a hexahedron and of a tetrahedron.
_HEX = [
    (a, b)
    for a, b in itertools.combinations(range(8), 2)
    if np.sum(np.abs(CORNERS[a] - CORNERS[b])) == 1
]
_TET = list(itertools.combinations(range(4), 2))


@dataclass(frozen=True)
class Edges:
    """Edges ``a < b (E,)``, once each, with the volume ``around (E,)`` [m^3]: that of its cells.

    ``per_cell`` is the number of edges of a cell.
    """

    a: Indices
    b: Indices
    around: Array
    per_cell: int

    @property
    def volume(self) -> Array:
        """Shares ``(E,)`` [m^3] of three times the body: a pair along each of three directions.

        Inside a lattice that is the volume of a vertex.
        """
        return (3.0 / self.per_cell) * self.around

    def lengths(self, X: Array) -> Array:
        """``|X_b - X_a| (E,)`` [m] of the vertices ``X (N, 3)``."""
        return np.sqrt(np.sum((X[self.b] - X[self.a]) ** 2, axis=1))


def edges_of(mesh: Mesh) -> Edges:
    """All edges of the cells of ``mesh``."""
    n = len(mesh.vertices)
    ends = np.array(_HEX if isinstance(mesh, HexMesh) else _TET)
    pair = np.sort(mesh.cells[:, ends], axis=2)
    key, place = np.unique(pair[..., 0].ravel() * n + pair[..., 1].ravel(), return_inverse=True)
    volume = np.zeros(len(mesh.cells))
    for point in mesh.shape.cell_rule:
        map_ = np.einsum("ecd,ck->edk", mesh.vertices[mesh.cells], point.slopes)
        volume += point.weight * np.abs(np.linalg.det(map_))
    around = np.bincount(
        place.ravel(), weights=np.repeat(mesh.filling * volume, len(ends)), minlength=len(key)
    )
    return Edges(key // n, key % n, np.asarray(around), len(ends))
