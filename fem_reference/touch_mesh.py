"""Cells and faces of a mesh of hexahedra, and what the finite volume method takes from them.

All reconstructions are linear and depend on the undeformed body alone, so each of them is one
sparse matrix: values of cells to both sides of the faces, values of faces and cells to the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags

from fem_reference.cell_tables import CellTables
from sphsolid.geometry.cell_shape import HEXAHEDRON

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Faces:
    """``loops (f, 4)``; ``left (f,)`` the cell that sees the loop from inside, ``right (f,)``.

    ``right`` is ``left`` on the boundary, whose faces are the last ones, from ``inner`` on.
    ``area (f, 3)`` [m^2] area vectors out of the left cell; ``shares (f, 4)`` of the corners in the
    centroid ``X (f, 3)`` [m]: means would give a uniform stress a moment on a disordered mesh.
    """

    loops: Indices
    left: Indices
    right: Indices
    inner: int
    area: Array
    shares: Array
    X: Array

    def centroids(self, x: Array) -> Array:
        """The centroids ``(f, 3)`` [m] when the nodes are at ``x (N, 3)``."""
        return np.asarray(np.einsum("fn,fni->fi", self.shares, x[self.loops]))

    @property
    def size(self) -> Array:
        """Areas ``(f,)`` [m^2]."""
        return np.asarray(np.linalg.norm(self.area, axis=1))

    def numbers(self, loops: Indices) -> Indices:
        """The boundary faces with the corners of ``loops (n, 4)``, counted from the first one."""
        known = {tuple(sorted(loop)): k for k, loop in enumerate(self.loops[self.inner :].tolist())}
        return np.array([known[tuple(sorted(loop))] for loop in loops.tolist()], dtype=np.int64)


def faces_of(cells: Indices, vertices: Array) -> Faces:
    """All faces of ``cells (E, 8)``, each once."""
    loops = cells[:, HEXAHEDRON.facets].reshape(-1, 4)
    owner = np.repeat(np.arange(len(cells)), 6)
    _, first, name, times = np.unique(
        np.sort(loops, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    right = owner[first].copy()
    second = np.ones(len(loops), dtype=bool)
    second[first] = False
    right[name.ravel()[second]] = owner[second]
    order = np.argsort(times == 1, kind="stable")
    first, right = first[order], right[order]
    loop = loops[first]
    corner = vertices[loop]
    area = 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    shares = np.zeros((len(loop), 4))
    for point in HEXAHEDRON.facet_rule:
        along = np.einsum("fni,nk->kfi", corner, point.slopes)
        weight = point.weight * np.linalg.norm(np.cross(along[0], along[1]), axis=1)
        shares += weight[:, None] * point.N
    shares /= shares.sum(axis=1, keepdims=True)
    X = np.einsum("fn,fni->fi", shares, corner)
    return Faces(loop, owner[first], right, int(np.sum(times == 2)), area, shares, X)


@dataclass(frozen=True)
class TouchMesh:
    """Sparse maps of a body; ``V (E,)`` [m^3] and centroids ``X (E, 3)`` [m] of the cells.

    ``to_left, to_right (f, E)`` reconstruct a field of cells at both sides of the faces;
    ``from_faces (N, f)`` and ``from_cells (N, E)`` carry velocities to the nodes;
    ``balance (E, f)`` sums fluxes out of the left cells; ``gradients (E, 8, 3)`` [1/m] are the
    means of ``dN_a/dX`` over the cells.
    """

    faces: Faces
    V: Array
    X: Array
    to_left: csr_matrix
    to_right: csr_matrix
    from_faces: csr_matrix
    from_cells: csr_matrix
    balance: csr_matrix
    gradients: Array


def touch_mesh(cells: CellTables, *, linear: bool) -> TouchMesh:
    """The maps of ``cells``; values are constant in each cell unless ``linear``."""
    nodes, N, G, w = cells.tables
    vertices, count = cells.mesh.vertices, cells.count
    w = np.broadcast_to(w, (count, w.shape[1]))
    G = np.broadcast_to(G, (count, *G.shape[1:]))
    V = w.sum(axis=1)
    X = np.einsum("eq,qn,eni->ei", w, N, vertices[nodes]) / V[:, None]
    gradients = np.einsum("eq,eqnk->enk", w, G) / V[:, None, None]
    faces = faces_of(cells.mesh.cells, vertices)
    slopes = _least_squares(faces, X)
    f, inner = len(faces.left), faces.inner
    sides = []
    for side in (faces.left, faces.right):
        pick = _picked(side, count)
        arm = faces.X - X[side]
        if linear:
            pick = pick + sum(diags(arm[:, k]) @ pick @ slopes[k] for k in range(3))
        sides.append(csr_matrix(pick))
    # The mean over the faces around a node, each carried to it along the slope of its two cells.
    node, face = faces.loops.ravel(), np.repeat(np.arange(f), 4)
    share = 1.0 / np.bincount(node, minlength=len(vertices))[node]
    from_faces = csr_matrix((share, (node, face)), shape=(len(vertices), f))
    middle = 0.5 * (_picked(faces.left, count) + _picked(faces.right, count))
    arm = (vertices[node] - faces.X[face]) * share[:, None]
    from_cells = sum(
        csr_matrix((arm[:, k], (node, face)), shape=(len(vertices), f)) @ middle @ slopes[k]
        for k in range(3)
    )
    every, seen = np.arange(f), np.arange(inner)
    balance = csr_matrix(
        (
            np.concatenate([np.ones(f), -np.ones(inner)]),
            (np.concatenate([faces.left, faces.right[:inner]]), np.concatenate([every, seen])),
        ),
        shape=(count, f),
    )
    return TouchMesh(
        faces, V, X, sides[0], sides[1], from_faces, csr_matrix(from_cells), balance, gradients
    )


def _picked(cell: Indices, count: int) -> csr_matrix:
    rows = np.arange(len(cell))
    return csr_matrix((np.ones(len(cell)), (rows, cell)), shape=(len(cell), count))


def _least_squares(faces: Faces, X: Array) -> list[csr_matrix]:
    """Slopes along the three axes from the cells across the faces, exact for linear fields.

    A direction in which a cell has no neighbour has no slope.
    """
    left, right = faces.left[: faces.inner], faces.right[: faces.inner]
    one, other = np.concatenate([left, right]), np.concatenate([right, left])
    d = X[other] - X[one]
    weight = 1.0 / np.sum(d * d, axis=1)
    M = np.zeros((len(X), 3, 3))
    np.add.at(M, one, weight[:, None, None] * d[:, :, None] * d[:, None, :])
    inverse = np.linalg.pinv(M, rcond=1.0e-8, hermitian=True)
    c = weight[:, None] * np.einsum("nij,nj->ni", inverse[one], d)
    shape = (len(X), len(X))
    slopes = []
    for k in range(3):
        ahead = csr_matrix((c[:, k], (one, other)), shape=shape)
        here = csr_matrix((c[:, k], (one, one)), shape=shape)
        slopes.append(csr_matrix(ahead - here))
    return slopes
