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
``r_a = A_a N_a - sum_b V_b G_a(X_b)``, the same for the three components.  Its null space holds
the constants and the linears, to which ``r`` is orthogonal because the volumes and areas come from
one mesh.  ``S`` is applied pair by pair, never assembled, and solved by conjugate gradients.

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

from sphsolid.cloud.neighbours import PairList
from sphsolid.compiled import kernel, prange
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
) -> Change:
    """``D`` that makes ``G + D`` satisfy D0 with C0 and C1 kept.

    ``G (P, 3)`` [1/m]; ``weights (P,)`` symmetric, non-negative, zero where nothing may change;
    ``tolerance`` of the largest remaining defect relative to the largest area.  Raises
    ``InputError`` when no such change exists on the given pairs.
    """
    h = float(np.cbrt(np.mean(volumes)))
    defect = divergence_defect(G, pairs, volumes, areas)
    scale = float(np.max(np.linalg.norm(areas, axis=1)))
    # Only pairs that may change enter the system: on a lattice those near the boundary.
    band, changing, place = _band(pairs, weights)
    inverse = _inverse_moments(changing, particles[band], weights[place], h)
    system = _System(changing, particles[band], volumes[band], weights[place], inverse, h)
    mu, iterations = _conjugate_gradients(
        system, defect[band], tolerance * scale, most_iterations
    )
    D = np.zeros_like(G)
    change = np.empty((len(place), 3))
    _change(*system.arrays, mu, system.eta(mu), change)
    D[place] = change
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


class _System:
    """``S`` as an operator on ``(N, 3)``."""

    def __init__(
        self,
        pairs: PairList,
        particles: Array,
        volumes: Array,
        weights: Array,
        inverse: Array,
        h: float,
    ) -> None:
        self.arrays = (pairs.indptr, pairs.indices, particles, volumes, weights, h)
        self._inverse = inverse
        self._size = len(volumes)

    def eta(self, mu: Array) -> Array:
        """``eta_b (N, 4, 3)``."""
        eta = np.empty((self._size, 4, 3))
        _local_unknowns(*self.arrays, self._inverse, mu, eta)
        return eta

    def apply(self, mu: Array) -> Array:
        """``S mu (N, 3)``."""
        out = np.empty_like(mu)
        _apply(*self.arrays, mu, self.eta(mu), out)
        return out

    def diagonal(self) -> Array:
        """Diagonal of ``S (N,)``."""
        out = np.empty(self._size)
        _diagonal(*self.arrays, self._inverse, out)
        return out


def _inverse_moments(pairs: PairList, particles: Array, weights: Array, h: float) -> Array:
    """Pseudo-inverses of ``m_b (N, 4, 4)``: points with few active pairs are rank deficient."""
    moment = np.empty((pairs.rows, 4, 4))
    _moments(pairs.indptr, pairs.indices, particles, weights, h, moment)
    peak = float(np.max(moment[:, 0, 0]))
    value, vector = np.linalg.eigh(moment)
    kept = value > 1.0e-10 * peak
    reciprocal = np.where(kept, 1.0 / np.where(kept, value, 1.0), 0.0)
    return np.einsum("bik,bk,bjk->bij", vector, reciprocal, vector)


def _conjugate_gradients(
    system: _System, right: Array, stop: float, most: int
) -> tuple[Array, int]:
    """Jacobi-preconditioned CG on the three components at once; returns ``mu`` and the count.

    Round-off may hold the residual just above ``stop``: what is good enough and has not halved
    in ``PATIENCE`` iterations is taken.
    Totals are plain numpy sums, whose order does not depend on the number of threads.
    """
    diagonal = system.diagonal()
    # A particle whose pairs are all fixed by C0 and C1 has a zero row: nothing to solve there.
    solvable = diagonal > 1.0e-12 * float(np.max(diagonal))
    inverse_diagonal = np.where(solvable, 1.0 / np.where(solvable, diagonal, 1.0), 0.0)
    mu = np.zeros_like(right)
    residual = right.copy()
    z = residual * inverse_diagonal[:, None]
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
        z = residual * inverse_diagonal[:, None]
        fresh = np.sum(residual * z, axis=0)
        direction = z + np.divide(fresh, rz, out=np.zeros(3), where=rz > 0.0) * direction
        rz = fresh
    return best, most


@kernel
def _moments(indptr, indices, X, w, h, moment):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        for i in range(4):
            for j in range(4):
                moment[b, i, j] = 0.0
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            phi = (1.0, p1, p2, p3)
            for i in range(4):
                for j in range(4):
                    moment[b, i, j] += w[k] * phi[i] * phi[j]


@kernel
def _local_unknowns(indptr, indices, X, V, w, h, inverse, mu, eta):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        s = np.zeros((4, 3))
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            for d in range(3):
                m = w[k] * V[b] * mu[a, d]
                s[0, d] += m
                s[1, d] += p1 * m
                s[2, d] += p2 * m
                s[3, d] += p3 * m
        for i in range(4):
            for d in range(3):
                total = 0.0
                for j in range(4):
                    total += inverse[b, i, j] * s[j, d]
                eta[b, i, d] = total


@kernel
def _apply(indptr, indices, X, V, w, h, mu, eta, out):  # type: ignore[no-untyped-def]
    # (S mu)_a = sum_b V_b D_a(X_b); the pattern and w are symmetric, so a gathers over its row.
    for a in prange(len(indptr) - 1):
        s0 = 0.0
        s1 = 0.0
        s2 = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            e = eta[b]
            c = V[b] * w[k]
            s0 += c * (V[b] * mu[a, 0] - e[0, 0] - p1 * e[1, 0] - p2 * e[2, 0] - p3 * e[3, 0])
            s1 += c * (V[b] * mu[a, 1] - e[0, 1] - p1 * e[1, 1] - p2 * e[2, 1] - p3 * e[3, 1])
            s2 += c * (V[b] * mu[a, 2] - e[0, 2] - p1 * e[1, 2] - p2 * e[2, 2] - p3 * e[3, 2])
        out[a, 0] = s0
        out[a, 1] = s1
        out[a, 2] = s2


@kernel
def _diagonal(indptr, indices, X, V, w, h, inverse, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        s = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            phi = (1.0, p1, p2, p3)
            quadratic = 0.0
            for i in range(4):
                for j in range(4):
                    quadratic += phi[i] * inverse[b, i, j] * phi[j]
            s += V[b] * V[b] * w[k] * (1.0 - w[k] * quadratic)
        out[a] = s


@kernel
def _change(indptr, indices, X, V, w, h, mu, eta, D):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            for d in range(3):
                e = eta[b, 0, d] + p1 * eta[b, 1, d] + p2 * eta[b, 2, d] + p3 * eta[b, 3, d]
                D[k, d] = w[k] * (V[b] * mu[a, d] - e)
