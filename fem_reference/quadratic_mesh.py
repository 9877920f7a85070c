"""Nodes of the 27-node hexahedra on a mesh: its vertices, and the middles of edges, faces, cells.

Seen another way, each hexahedron is cut into eight with the 27 nodes as corners.  That finer
``HexMesh`` is what the rest of the program sees: initial states, constraints, probes and files need
to know nothing of quadratic shapes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementHex2, MeshHex

from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]
#: Local node ``n = i + 3 j + 9 k`` sits at ``NODES[n]`` in {0, 1/2, 1}^3.
NODES = 0.5 * np.array([[i, j, k] for k in range(3) for j in range(3) for i in range(3)])
#: Corner ``c`` of the cell is local node ``CORNER_NODES[c]``.
CORNER_NODES = (2 * CORNERS) @ [1, 3, 9]
#: Corners ``(8, 8)`` of the eight parts; part ``a + 2 b + 4 c`` is at ``(a, b, c)``.
PARTS = np.array(
    [np.add(CORNERS, [a, b, c]) @ [1, 3, 9] for c in (0, 1) for b in (0, 1) for a in (0, 1)]
)


def trilinear(points: Array) -> Array:
    """Shape functions ``(p, 8)`` of the corners at ``points (p, 3)`` of the unit cube."""
    factors = np.where(CORNERS == 1, points[:, None, :], 1.0 - points[:, None, :])
    return np.asarray(np.prod(factors, axis=2))


@dataclass(frozen=True)
class QuadraticMesh:
    """``parts`` the mesh of eighths whose vertices are the nodes; ``cells (E, 27)`` their numbers.

    ``node_of_dof (N,)`` is the node of a degree of freedom of scikit-fem's ``ElementHex2``.
    """

    parts: HexMesh
    cells: NDArray[np.uint32]
    node_of_dof: NDArray[np.int64]


def quadratic_mesh(mesh: HexMesh, sk: MeshHex) -> QuadraticMesh:
    """Number the nodes of ``mesh`` (``sk`` is the same mesh) as the elements meet them."""
    dofs = Basis(sk, ElementHex2(), intorder=1).element_dofs
    place = np.rint(2.0 * np.asarray(ElementHex2.doflocs)).astype(int) @ [1, 3, 9]
    by_place = dofs[np.argsort(place)].T
    _, first, of_entry = np.unique(by_place.ravel(), return_index=True, return_inverse=True)
    number = np.empty(len(first), dtype=np.int64)
    number[np.argsort(first, kind="stable")] = np.arange(len(first))
    # Degrees of freedom are numbered without gaps, so their sorted values are 0, 1, 2, ...
    cells = number[of_entry].reshape(by_place.shape)
    X = np.empty((len(first), 3))
    X[cells] = np.einsum("pc,eci->epi", trilinear(NODES), mesh.vertices[mesh.cells])
    parts = HexMesh(
        vertices=X,
        cells=cells[:, PARTS].reshape(-1, 8),
        faces={name: _parts_of(quads, mesh, cells) for name, quads in mesh.faces.items()},
        spacing=0.5 * mesh.spacing,
        is_lattice=mesh.is_lattice,
    )
    return QuadraticMesh(parts, cells.astype(np.uint32), number)


def _parts_of(
    quads: NDArray[np.int64], mesh: HexMesh, cells: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The four parts of every quadrilateral ``(f, 4)``, with the same sense of rotation."""
    vertices = _Middles(mesh, cells, 1)
    edges = _Middles(mesh, cells, 2)
    middle = _Middles(mesh, cells, 4).of(quads)
    corner = [vertices.of(quads[:, [s]]) for s in range(4)]
    edge = [edges.of(quads[:, [s, (s + 1) % 4]]) for s in range(4)]
    four = [np.stack([corner[s], edge[s], middle, edge[s - 1]], axis=1) for s in range(4)]
    return np.concatenate(four)


class _Middles:
    """Finds the node in the middle of ``corners`` (1, 2 or 4) vertices."""

    def __init__(self, mesh: HexMesh, cells: NDArray[np.int64], corners: int) -> None:
        shapes = trilinear(NODES) > 0.0
        local = np.flatnonzero(shapes.sum(axis=1) == corners)
        around = np.stack([np.flatnonzero(shapes[n]) for n in local])
        self._base = len(mesh.vertices)
        keys = self._key(mesh.cells[:, around].reshape(-1, corners))
        self._keys, first = np.unique(keys, return_index=True)
        self._nodes = cells[:, local].ravel()[first]

    def _key(self, vertices: NDArray[Any]) -> NDArray[np.int64]:
        ordered = np.sort(vertices, axis=1).astype(np.int64)
        key = ordered[:, 0]
        # The three smallest of four vertices name a face.
        for column in ordered[:, 1:3].T:
            key = key * self._base + column
        return key

    def of(self, vertices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Node numbers ``(f,)`` of ``vertices (f, corners)``."""
        return np.asarray(self._nodes[np.searchsorted(self._keys, self._key(vertices))])
