"""``D(J)``: the SUPG term that removes spurious pressures, [Lee2017] eq. (35)."""

from __future__ import annotations

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import apply, cofactor, transpose
from sphsolid.fields import LANES
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.fine_scale import WEIGHT
from sphsolid.scheme.tile import STRIDE, U, load_lane

# Scratch rows.
_R, _INERTIA, _F_X = 0, 3, 6


@kernel
def momentum_residual(  # type: ignore[no-untyped-def]
    sample, factor, P, inertia, F_x, flux, scratch
):
    """``flux_q = factor * H^T R_p (3, .)`` with ``R_p = sum P_a G_a - sum V_a W~_a (pdot - f0)_a``.

    ``inertia (3, .)`` is ``pdot - f0`` of the Galerkin rate (31a), constrained components of
    ``pdot`` zeroed.  The body force is interpolated from the particles like the rate it balances,
    so the two cancel exactly at rest.  ``H = cof F_x`` at ``q``.
    """
    tiles, workers = len(sample.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.divergence(sample, tile, at, P, S, _R)
            on_tile.interpolate_vector(sample, WEIGHT, tile, at, inertia, S, _INERTIA)
            on_tile.fetch_tensor(F_x, at, S, _F_X)
            for lane in range(U(LANES)):
                r, w = U(_R * STRIDE) + lane, U(_INERTIA * STRIDE) + lane
                residual = (
                    S[r] - S[w],
                    S[r + U(STRIDE)] - S[w + U(STRIDE)],
                    S[r + U(2 * STRIDE)] - S[w + U(2 * STRIDE)],
                )
                pulled = apply(transpose(cofactor(load_lane(S, _F_X, lane))), residual)
                S[r] = factor * pulled[0]
                S[r + U(STRIDE)] = factor * pulled[1]
                S[r + U(2 * STRIDE)] = factor * pulled[2]
            on_tile.put(S, _R, 3, at, flux)


@kernel
def volume_dissipation(spread, flux, Jdot, scratch):  # type: ignore[no-untyped-def]
    """Add ``D(J_a) = -sum_q (V_q / V_a) flux_q . G_a(X_q)`` (35) to ``Jdot (1, .)``."""
    tiles, workers = len(spread.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.flux_divergence(spread, tile, at, flux, S, 0)
            on_tile.subtract(S, 0, 1, at, Jdot)
