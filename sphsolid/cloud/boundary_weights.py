"""Area vectors that integrate quadratics over the boundary exactly, one a boundary particle.

A pair that sums by parts, ``C + C^T = B``, with first-order exact rows ``C 1 = 0`` and
``C^d X_e = delta_de V`` exists only if for all polynomials ``p, q`` of degree one

    p^T B^d q = int_boundary p q n_d dA:

``B`` must integrate *quadratics* exactly.  The consistent mass ``int N_a N_b n dA`` does, but it
averages over neighbours on the boundary while nothing averages normal to it, and this difference is
an error ``O(dx)`` of the normal derivative: on a lattice it doubles the errors of momentum and
stress.  Lumped to ``B = diag(A_a N_a)`` there is no such average and quadratics are integrated
with an error of ``O(dx^2)``, which the smallest relative change of the areas removes:

    A_a N_a  <-  A_a N_a [1 + N_a . lambda q(X_a)],    q the ten quadratics,

30 numbers in all.  On a lattice box the errors of opposite faces cancel and the change is zero;
elsewhere it is ``O(dx^2)``.  (Exactness face by face is too much to ask: it changes the areas near
edges, and costs as much accuracy as the consistent mass.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.integrals import area_vectors, boundary_mass
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
_PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]


def _linears(X: Array) -> Array:
    """``1, x, y, z`` in coordinates that run from -1 to 1 over the body ``(N, 4)``."""
    low, high = X.min(axis=0), X.max(axis=0)
    size = np.maximum(high - low, 1.0e-12 * np.max(high - low))
    x = (2.0 * X - low - high) / size
    return np.concatenate([np.ones((len(x), 1)), x], axis=1)


def quadratic_moments(mesh: Mesh) -> tuple[Array, Array]:
    """Quadratics ``q (N, 10)`` at the vertices and ``int_boundary q n dA (10, 3)``, exact."""
    linear = _linears(mesh.vertices)
    values = np.stack([linear[:, i] * linear[:, j] for i, j in _PAIRS], axis=1)
    exact = np.empty((len(_PAIRS), 3))
    for d, mass in enumerate(boundary_mass(mesh, mesh.boundary)):
        table = linear.T @ (mass @ linear)
        exact[:, d] = [table[i, j] for i, j in _PAIRS]
    return values, exact


def quadratically_exact_areas(mesh: Mesh) -> dict[str, Array]:
    """``A_a N_a (N, 3)`` [m^2] of every tag: together exact for all quadratics on the boundary.

    ``sum_a A_a N_a`` and ``sum_a A_a N_a (x) X_a`` of each tag are those of its facets, so that
    force and moment of a constant traction do not change.
    """
    values, exact = quadratic_moments(mesh)
    linear = _linears(mesh.vertices)
    areas = {name: area_vectors(mesh, facets) for name, facets in mesh.faces.items()}
    whole = np.sum(list(areas.values()), axis=0)
    # The change A f, f = n . (lambda q + mu_tag linears): lambda for the conditions on the whole
    # boundary, mu for those that each tag keeps; along A, so that a plane keeps its normal.
    width = 3 * (len(_PAIRS) + 4 * len(areas))
    matrix, bases = np.zeros((width, width)), {}
    for k, (name, area) in enumerate(areas.items()):
        basis = np.zeros((len(area), width // 3))
        basis[:, : len(_PAIRS)] = values
        basis[:, len(_PAIRS) + 4 * k : len(_PAIRS) + 4 * (k + 1)] = linear
        size = np.linalg.norm(area, axis=1)[:, None]
        normal = np.divide(area, size, out=np.zeros_like(area), where=size > 0.0)
        bases[name] = (basis[:, :, None] * normal[:, None, :]).reshape(len(area), width)
        matrix += bases[name].T @ (size * bases[name])
    right = np.zeros((width // 3, 3))
    right[: len(_PAIRS)] = exact - values.T @ whole
    # On planes and in small tags the conditions depend on each other: hence least squares.
    solution = np.linalg.lstsq(matrix, right.ravel(), rcond=1.0e-12)[0]
    return {name: area * (1.0 + (bases[name] @ solution))[:, None] for name, area in areas.items()}
