"""Bodies with slots, notches and gaps, and what can be said of their pairs without a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.secondary import KUHN
from sphsolid.geometry import Blocks, HexMesh, TetMesh
from sphsolid.geometry.cell_shape import TETRAHEDRON
from sphsolid.geometry.facets import cell_facets, same_vertices

Array = NDArray[np.float64]

#: A slot one spacing wide, one twice as wide, a notch from below, a square hole of one spacing, the
#: empty quadrant of an L, two parts a tenth of a spacing apart, and two that share an edge; all
#: for a spacing of 1/2.
BLOCKS = {
    "slot": Blocks((((0, 0, 0), (1, 1, 2.5)), ((1, 0, 0), (3, 1, 1)), ((1, 0, 1.5), (3, 1, 2.5)))),
    "wide slot": Blocks((((0, 0, 0), (1, 1, 3)), ((1, 0, 0), (3, 1, 1)), ((1, 0, 2), (3, 1, 3)))),
    "notch": Blocks((((0, 0, 1), (3, 1, 2)), ((0, 0, 0), (1, 1, 1)), ((1.5, 0, 0), (3, 1, 1)))),
    "hole": Blocks(
        (
            ((0, 0, 0), (1, 1, 2.5)), ((1.5, 0, 0), (2.5, 1, 2.5)),
            ((1, 0, 0), (1.5, 1, 1)), ((1, 0, 1.5), (1.5, 1, 2.5)),
        )
    ),
    "L": Blocks((((0, 0, 0), (1, 2, 3)), ((1, 0, 0), (3, 2, 1)))),
    "parts": Blocks((((0, 0, 0), (1, 1, 1)), ((0, 0, 1.05), (1, 1, 2.05)))),
    "hinge": Blocks((((0, 0, 0), (1, 1, 1)), ((1, 0, 1), (2, 1, 2)))),
}  # fmt: skip


def leaves_blocks(blocks: Blocks, start: Array, end: Array) -> NDArray[np.bool_]:
    """Whether segments ``(n, 3)`` have a point outside of all blocks, seen at 199 points."""
    out = np.zeros(len(start), dtype=bool)
    for share in np.linspace(0.0, 1.0, 201)[1:-1]:
        X = start + share * (end - start)
        inside = np.zeros(len(X), dtype=bool)
        for low, high in blocks.blocks:
            inside |= np.all((np.array(low) - 1e-9 <= X) & (np.array(high) + 1e-9 >= X), axis=1)
        out |= ~inside
    return out


def both(pairs: PairList) -> set[tuple[int, int]]:
    """The pairs as a set of ``(row, column)``."""
    return set(zip(pairs.row_of_pair.tolist(), pairs.indices.tolist(), strict=True))


def tetrahedra(mesh: HexMesh) -> TetMesh:
    """Six tetrahedra for every hexahedron, the boundary as it comes."""
    cells = mesh.cells[:, KUHN].reshape(-1, 4)
    facets = cell_facets(cells, TETRAHEDRON)
    number = same_vertices(facets)
    outer = facets[np.bincount(number)[number] == 1]
    return TetMesh(mesh.vertices, cells, {"boundary": outer}, mesh.spacing, is_lattice=False)


def with_slit(mesh: HexMesh, axis: int, plane: float, until: float) -> HexMesh:
    """The mesh cut open in the plane ``X_axis = plane`` where ``X_0 > until``; no width."""
    X, cells = mesh.vertices, mesh.cells.copy()
    on = np.flatnonzero((np.abs(X[:, axis] - plane) < 1e-9) & (X[:, 0] > until + 1e-9))
    twin = np.arange(len(X))
    twin[on] = len(X) + np.arange(len(on))
    above = X[cells].mean(axis=1)[:, axis] > plane
    cells[above] = twin[cells[above]]
    X = np.concatenate([X, X[on]])
    facets = cell_facets(cells, mesh.shape)
    number = same_vertices(facets)
    outer = facets[np.bincount(number)[number] == 1]
    return HexMesh(X, cells, {"boundary": outer}, mesh.spacing, is_lattice=False)
