"""Motion of neighbours against each other that no gradient of the positions sees.

A gradient at vertices is a difference across a vertex, so positions that alternate from one vertex
to the next have none: whatever is computed from it - stress, energy, Jacobians - is blind to them.
What it leaves out of a pair of neighbours is

    e_ab = (x_b - x_a) - 1/2 (F_a + F_b) (X_b - X_a),    r_ab = |e_ab| / |X_b - X_a|,

zero for every affine motion, small of second order for smooth ones, and on a lattice the third
difference along an axis.  ``F_a = sum_b (x_b - x_a) (x) g_ab`` is the least-squares gradient of the
positions over the vertices that share an edge of a cell with ``a``,

    g_ab = w_ab M_a^-1 (X_b - X_a),   M_a = sum_b w_ab (X_b - X_a) (x) (X_b - X_a),
    w_ab = 1 / |X_b - X_a|^2.

It is nobody's method, so that bodies of all methods are judged by one measure.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from sphsolid.geometry.edges import edges_of
from sphsolid.geometry.mesh import Mesh
from sphsolid.record.per_mesh import PerMesh
from sphsolid.record.placement import Placed

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Neighbours in fewer directions than three have a gradient in theirs alone: determinant of ``M_a``
#: over the cube of its mean eigenvalue, and ratio of eigenvalues, that count as none.
_NO_DIRECTION = 1.0e-9
_TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True)
class UnseenMotion:
    """``rms`` over all pairs, by the volume around them, and ``largest`` of ``r_ab`` [-]."""

    rms: float
    largest: float


def unseen_motion(snapshot: Placed) -> UnseenMotion:
    """Root mean square and largest ``r_ab = |e_ab| / |X_b - X_a|`` over the edges of the cells.

    Neither depends on units, nor on a rotation or translation of the body.  A saw tooth in the
    positions counts with its full size; at a face, where the gradient is one-sided, with half.
    """
    return _PAIRS(snapshot.mesh).unseen_motion(snapshot.x)


@dataclass(frozen=True)
class _Pairs:
    """``e / |X_b - X_a|`` of every edge as a matrix ``(E, N)``; ``weight (E,)`` adds up to one."""

    unseen: csr_array
    weight: Array

    def unseen_motion(self, x: Array) -> UnseenMotion:
        if len(self.weight) == 0:
            return UnseenMotion(0.0, 0.0)
        square = np.sum((self.unseen @ x) ** 2, axis=1)
        return UnseenMotion(
            float(np.sqrt(np.sum(self.weight * square))), float(np.sqrt(np.max(square)))
        )


def _pairs(mesh: Mesh) -> _Pairs:
    edges = edges_of(mesh)
    a, b = edges.a, edges.b
    weight = edges.around / max(float(np.sum(edges.around)), _TINY)
    X, n, m = mesh.vertices, len(mesh.vertices), len(a)
    length = np.linalg.norm(X[b] - X[a], axis=1)
    unit = (X[b] - X[a]) / length[:, None]
    edge, one = np.arange(m), np.ones(m)
    at_a, at_b = (csr_array((one, (edge, end)), shape=(m, n)) for end in (a, b))
    unseen = csr_array((1.0 / length, (edge, edge)), shape=(m, m)) @ (at_b - at_a)
    mean = 0.5 * (at_a + at_b)
    for k, G in enumerate(_gradient(a, b, length, unit, n)):
        unseen = unseen - csr_array((unit[:, k], (edge, edge)), shape=(m, m)) @ (mean @ G)
    return _Pairs(csr_array(unseen), weight)


def _gradient(
    a: Indices, b: Indices, length: Array, unit: Array, n: int
) -> tuple[csr_array, ...]:
    """``x -> sum_b (x_b - x_a) g_ab``, one matrix ``(N, N)`` [1/m] a component of ``g``."""
    # Both ways round: every vertex sees all of its neighbours.
    row, column = np.concatenate([a, b]), np.concatenate([b, a])
    unit, length = np.concatenate([unit, -unit]), np.concatenate([length, length])
    M = np.zeros((n, 3, 3))
    for i, j in itertools.product(range(3), repeat=2):
        M[:, i, j] = np.bincount(row, weights=unit[:, i] * unit[:, j], minlength=n)
    g = np.einsum("eij,ej->ei", _inverse(M)[row], unit) / length[:, None]
    vertices = np.arange(n)
    rows, columns = np.concatenate([row, vertices]), np.concatenate([column, vertices])
    own = [np.bincount(row, weights=g[:, k], minlength=n) for k in range(3)]
    return tuple(
        csr_array((np.concatenate([g[:, k], -own[k]]), (rows, columns)), shape=(n, n))
        for k in range(3)
    )


def _inverse(M: Array) -> Array:
    """Of ``M (N, 3, 3)``; where neighbours lie in a plane or on a line, in their directions."""
    inverse = np.zeros_like(M)
    size = np.trace(M, axis1=1, axis2=2) / 3.0
    regular = np.linalg.det(M) > _NO_DIRECTION * size**3
    inverse[regular] = np.linalg.inv(M[regular])
    inverse[~regular] = np.linalg.pinv(M[~regular], rcond=_NO_DIRECTION, hermitian=True)
    return inverse


_PAIRS = PerMesh(_pairs)
