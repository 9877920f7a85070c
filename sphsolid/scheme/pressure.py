"""``D(J)``: the SUPG term that removes spurious pressures, [Lee2017] eq. (35)."""

from __future__ import annotations

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import apply, cofactor, load, transpose


@kernel
def momentum_residual(  # type: ignore[no-untyped-def]
    indptr, indices, sample, factor, P, inertia, F_x, flux
):
    """``flux_q = factor * H^T R_p (M, 3)`` with ``R_p = sum P_a G_a - sum V_a W~_a (pdot - f0)_a``.

    ``inertia (N, 3)`` is ``pdot - f0`` of the Galerkin rate (31a), constrained components of
    ``pdot`` zeroed.  The body force is interpolated from the particles like the rate it balances,
    so the two cancel exactly at rest.  ``H = cof F_x`` at ``q``.
    """
    for q in prange(len(indptr) - 1):
        r0 = r1 = r2 = 0.0
        for k in range(indptr[q], indptr[q + 1]):
            a = indices[k]
            g0, g1, g2, w = sample[k, 0], sample[k, 1], sample[k, 2], sample[k, 3]
            r0 += P[a, 0, 0] * g0 + P[a, 0, 1] * g1 + P[a, 0, 2] * g2 - w * inertia[a, 0]
            r1 += P[a, 1, 0] * g0 + P[a, 1, 1] * g1 + P[a, 1, 2] * g2 - w * inertia[a, 1]
            r2 += P[a, 2, 0] * g0 + P[a, 2, 1] * g1 + P[a, 2, 2] * g2 - w * inertia[a, 2]
        flux_q = apply(transpose(cofactor(load(F_x, q))), (r0, r1, r2))
        flux[q, 0] = factor * flux_q[0]
        flux[q, 1] = factor * flux_q[1]
        flux[q, 2] = factor * flux_q[2]


@kernel
def volume_dissipation(indptr, indices, spread, flux, Jdot):  # type: ignore[no-untyped-def]
    """Add ``D(J_a) = -sum_q (V_q / V_a) flux_q . G_a(X_q)`` (35) to ``Jdot (N,)``."""
    for a in prange(len(indptr) - 1):
        s = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            q = indices[k]
            s += flux[q, 0] * spread[k, 0] + flux[q, 1] * spread[k, 1] + flux[q, 2] * spread[k, 2]
        Jdot[a] -= s
