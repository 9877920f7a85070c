"""Consistent nodal integration: the least change of a gradient that makes the force exact.

The corrected gradient satisfies C0 (``sum_a G_a(X_b) = 0``) and C1 (``sum_a G_a(X_b) (x) X_a = I``)
but not the discrete divergence theorem that the weak form needs for constant stress,

    D0:   sum_b V_b G_a(X_b) = A_a N_a.

Without D0 a uniform stress ``P`` accelerates the layers near the boundary by ``O(P / h)``, however
fine the cloud.  We add to ``G`` the smallest ``D`` on the same pairs,

    minimise  sum_ab |D_a(X_b)|^2 / w_ab   subject to  C0, C1 and D0 of  G + D,

``w_ab`` a symmetric weight.  Stationarity gives, per component of the
gradient and with ``phi_ab = (1, (X_a - X_b) / h)``,

    D_a(X_b) = w_ab [ V_b mu_a - phi_ab . eta_b ],   eta_b = m_b^-1 sum_a w_ab phi_ab V_b mu_a,
    m_b = sum_a w_ab phi_ab phi_ab^T,

which satisfies C0 and C1 whatever ``mu`` is, so momentum is conserved to round-off regardless of
how well D0 is solved.  D0 itself is one symmetric positive semidefinite system ``S mu = r``,
``r_a = A_a N_a - sum_b V_b G_a(X_b)``, the same for the three components (``divergence_system``).
Its null space holds the constants and the linears, to which ``r`` is orthogonal because the volumes
and areas come from one mesh.  It is solved by conjugate gradients.

``w_ab = (W_ab / W_0)^(1/2)`` by default: between the smoothing function itself, which leaves the
change to the nearest neighbours, and equal weights.  ``python -m studies.operators`` compares the
exponents; ``docs/operators.md`` says why this one.

On a lattice only particles within two cells of the boundary have ``r != 0``, so the change is
confined to pairs among them (``w = 0`` elsewhere); the interior keeps one stencil.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sphsolid.cloud.divergence_system import DivergenceSystem
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.errors import InputError

Array = NDArray[np.float64]
#: Iterations without progress after which a solution that is good enough is taken.
PATIENCE = 500


@dataclass(frozen=True)
class Change:
    """The solved correction: ``D (P, 3)`` per pair, CG iterations, share of D0 left over."""

    D: Array
    iterations: int
    remainder: float


def divergence_defect(G: Array, pairs: PairList, volumes: Array, areas: Array) -> Array:
    """``r_a = A_a N_a - sum_b V_b G_a(X_b)  (N, 3)`` [m^2]; zero when D0 holds."""
    weight = volumes[pairs.row_of_pair]
    defect = areas.copy()
    for d in range(3):
        defect[:, d] -= np.bincount(
            pairs.indices, weights=weight * G[:, d], minlength=len(volumes)
        )
    return defect


def least_change(
    G: Array,
    pairs: PairList,
    particles: Array,
    volumes: Array,
    areas: Array,
    weights: Array,
    *,
    tolerance: float = 1.0e-13,
    most_iterations: int = 20_000,
    coarse: bool = False,
) -> Change:
    """``D`` that makes ``G + D`` satisfy D0 with C0 and C1 kept.

    ``G (P, 3)`` [1/m]; ``weights (P,)`` symmetric, non-negative, zero where nothing may change;
    ``tolerance`` of the largest remaining defect relative to the largest area;
    ``coarse`` adds a coarse solution to the preconditioner, for clouds on which every pair may
    change: far fewer iterations on large ones.  Raises ``InputError`` when no such change exists on
    the given pairs.
    """
    h = float(np.cbrt(np.mean(volumes)))
    defect = divergence_defect(G, pairs, volumes, areas)
    scale = float(np.max(np.linalg.norm(areas, axis=1)))
    # Only pairs that may change enter the system: on a lattice those near the boundary.
    band, changing, place = _band(pairs, weights)
    # One thread, as in ``skew_change``: the bits of BLAS depend on their number.
    with threadpool_limits(limits=1, user_api="blas"):
        system = DivergenceSystem(
            changing, particles[band], volumes[band], weights[place], h, coarse=coarse
        )
        mu, iterations = _conjugate_gradients(
            system, defect[band], tolerance * scale, most_iterations
        )
    D = np.zeros_like(G)
    D[place] = system.change(mu)
    left = float(np.max(np.abs(divergence_defect(G + D, pairs, volumes, areas)))) / scale
    if left > 1.0e3 * tolerance:
        raise InputError(
            f"no consistent gradient was found: the divergence theorem is violated by {left:.2g} "
            f"of the largest boundary area after {iterations} iterations; the body is too thin "
            "for its support, or the support too small: change h_over_dx or refine the spacing"
        )
    return Change(D, iterations, left)


def _band(
    pairs: PairList, weights: Array
) -> tuple[NDArray[np.int64], PairList, NDArray[np.int64]]:
    """Particles with changing pairs, the list of those pairs renumbered, and where they stand."""
    place = np.flatnonzero(weights > 0.0)
    row, column = pairs.row_of_pair[place], pairs.indices[place]
    band = np.unique(row)
    number = np.zeros(pairs.rows, dtype=np.uint32)
    number[band] = np.arange(len(band), dtype=np.uint32)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=pairs.rows)[band])])
    return band, PairList(indptr.astype(np.int64), number[column]), place


def _conjugate_gradients(
    system: DivergenceSystem, right: Array, stop: float, most: int
) -> tuple[Array, int]:
    """Preconditioned CG on the three components at once; returns ``mu`` and the count.

    Round-off may hold the residual just above ``stop``: what is good enough and has not halved
    in ``PATIENCE`` iterations is taken.
    Totals are plain numpy sums, whose order does not depend on the number of threads.
    """
    mu = np.zeros_like(right)
    residual = right.copy()
    z = system.precondition(residual)
    direction = z.copy()
    rz = np.sum(residual * z, axis=0)
    best, best_size = mu.copy(), np.inf
    mark, marked = np.inf, 0
    for iteration in range(most):
        size = float(np.max(np.abs(residual)))
        if size < best_size:
            best, best_size = mu.copy(), size
        if size <= stop:
            return mu, iteration
        if size < 0.5 * mark:
            mark, marked = size, iteration
        elif best_size <= 100.0 * stop and iteration - marked > PATIENCE:
            return best, iteration
        applied = system.apply(direction)
        curvature = np.sum(direction * applied, axis=0)
        step = np.divide(rz, curvature, out=np.zeros(3), where=curvature > 0.0)
        mu += step * direction
        residual -= step * applied
        z = system.precondition(residual)
        fresh = np.sum(residual * z, axis=0)
        direction = z + np.divide(fresh, rz, out=np.zeros(3), where=rz > 0.0) * direction
        rz = fresh
    return best, most
