"""Area vectors that integrate quadratics over the boundary exactly, one a boundary particle.

A pair that sums by parts, ``C + C^T = B``, with first-order exact rows ``C 1 = 0`` and
``C^d X_e = delta_de V`` exists only if for all polynomials ``p, q`` of degree one

    p^T B^d q = int_boundary p q n_d dA:

``B`` must integrate *quadratics* exactly.  The consistent mass ``int N_a N_b n dA`` does, but it
averages over neighbours on the boundary while nothing averages normal to it, and this difference is
an error ``O(dx)`` of the normal derivative: on a lattice it doubles the errors of momentum and
stress.  Lumped to ``B = diag(A_a N_a)`` there is no such average and quadratics are integrated
with an error of ``O(dx^2)``, which the smallest relative change of the areas removes:

    A_a N_a  <-  A_a N_a + |A_a N_a| lambda . q(X_a),    q the ten quadratics,

30 numbers in all.  On a lattice box the change is zero; elsewhere it is ``O(dx^2)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.integrals import area_vectors, boundary_mass
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
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


def quadratically_exact_areas(mesh: Mesh) -> Array:
    """``A_a N_a (N, 3)`` [m^2] with ``sum_a A_a N_a q(X_a) = int q n dA`` for all quadratics."""
    areas = area_vectors(mesh, mesh.boundary)
    values, exact = quadratic_moments(mesh)
    on = np.unique(mesh.boundary)
    size = np.linalg.norm(areas[on], axis=1)[:, None]
    normal_equations = (size * values[on]).T @ values[on]
    # Quadratics may depend on each other on the boundary, as on a sphere: hence least squares.
    change = np.linalg.lstsq(normal_equations, exact - values.T @ areas, rcond=1.0e-12)[0]
    areas[on] += size * (values[on] @ change)
    return areas
