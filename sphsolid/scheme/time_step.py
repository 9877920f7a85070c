"""Stable time step, and the check that there still is a solution to advance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import determinant
from sphsolid.continuum.wave_speed import THINNEST, smallest_stretch, step_share
from sphsolid.errors import Diverged, InputError, require
from sphsolid.fields import LANES, components
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.state import State
from sphsolid.scheme.tile import STRIDE, U, load_lane

Array = NDArray[np.float64]
#: Name of the field of a form whose ``F`` is not of the end of a step: what ``_stretch_limits``
#: found at the last evaluation.
STRETCH = "smallest_stretch"
#: No body bears a step of more: a larger number is a mistake, and is told before any step.
LARGEST_CFL = 100.0
ADVICE = (
    "a smaller cfl or load, more dissipation (tau_F, xi_F; tau_p near incompressibility), "
    "the Consistent operator everywhere, or a finer spacing"
)


@kernel
def _stretch_limits(p, F, J, limit, scratch):  # type: ignore[no-untyped-def]
    # The share of the undeformed step of a valid particle; -1 for J <= 0; -2 where not finite.
    has_J = J.size > 0
    tiles, workers = len(limit) // LANES, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch_tensor(F, at, S, 0)
            if has_J:
                on_tile.fetch(J, 1, at, S, 9)
            for lane in range(U(LANES)):
                F_a = load_lane(S, 0, lane)
                detF = determinant(F_a)
                J_a = S[U(9 * STRIDE) + lane] if has_J else detF
                stretch = smallest_stretch(F_a)
                # The sum is not finite where one of its terms is not.
                total = stretch + J_a + (p[0, at + lane] + p[1, at + lane] + p[2, at + lane])
                valid = step_share(stretch, detF) if min(J_a, detF) > 0.0 else -1.0
                limit[at + lane] = valid if total - total == 0.0 else -2.0


def take_stretches(state: State, scratch: Array) -> None:
    """The smallest stretches of ``state.F``, less where it grew, into the field of that name."""
    p, F, _, J = state.rows()
    limit = components(state[STRETCH])[0]
    _stretch_limits(p, F, J, limit[: -(-len(state.x) // LANES) * LANES], scratch)


def _reason(limit: float) -> str:
    if limit < -1.5:
        return "non-finite state"
    if limit < 0.0:
        return "negative Jacobian"
    return f"compressed to {100.0 * limit:.2g} % of its length (least allowed {THINNEST:.1%})"


def check_cfl(cfl: object) -> None:
    """Raise ``InputError`` unless the CFL number is positive and at most :data:`LARGEST_CFL`."""
    require(
        isinstance(cfl, int | float) and 0.0 < cfl <= LARGEST_CFL,
        f"cfl = {cfl!r} is outside (0, {LARGEST_CFL:g}] and is not 'auto': no explicit step is "
        "stable there; leave it out for the integrator's own, 0.3 is the paper's value",
    )


class TimeStep:
    """``dt = alpha_CFL h_min / max_a c_p,a`` with ``c_p,a = c_p / (smallest stretch of F_a)``,
    times ``J / GROWN`` where the volume grew by more than :data:`GROWN`.

    ``h_min`` [m] is the smallest particle spacing of the reference body and ``c_p`` [m/s] the
    p-wave speed of the undeformed solid.
    """

    def __init__(self, *, cfl: float, h_min: float, wave_speed: float, size: int) -> None:
        check_cfl(cfl)
        if not (h_min > 0.0 and math.isfinite(wave_speed)):
            raise InputError(f"h_min = {h_min} m and c_p = {wave_speed} m/s must be positive")
        self.cfl = cfl
        #: ``h / c_p`` [s], what intrinsic times of the mesh are multiples of.
        self.crossing = h_min / wave_speed
        self.reference = cfl * h_min / wave_speed
        self._size = size
        self._scratch = on_tile.make_scratch()
        self._limit = np.empty(-(-size // LANES) * LANES)

    def stable(self, state: State, X: Array, time: float, step: int) -> float:
        """``dt`` [s] now; raises ``Diverged`` naming the first invalid particle.

        Invalid: a field that is not finite, ``J <= 0``, a stretch below ``THINNEST``.
        """
        if STRETCH in state:
            limit = state[STRETCH]
        else:
            p, F, _, J = state.rows()
            _stretch_limits(p, F, J, self._limit, self._scratch)
            limit = self._limit[: self._size]
        least = float(np.min(limit))
        if least < THINNEST:
            a = int(np.argmax(limit < THINNEST))
            reason = _reason(float(limit[a]))
            x, y, z = (float(c) for c in X[a])
            raise Diverged(reason, time, step, a, (x, y, z), ADVICE)
        return self.reference * least
