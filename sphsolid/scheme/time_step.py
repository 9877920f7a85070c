"""Stable time step, and the check that there still is a solution to advance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import determinant, load
from sphsolid.continuum.wave_speed import THINNEST, smallest_stretch
from sphsolid.errors import Diverged, InputError, require

Array = NDArray[np.float64]
ADVICE = (
    "a smaller cfl, more dissipation (tau_F, xi_F; tau_p near incompressibility), "
    "the Consistent operator everywhere, or a finer spacing"
)


@kernel
def _stretch_limits(has_J, p, F, J, limit):  # type: ignore[no-untyped-def]
    # The smallest stretch of a valid particle; -1 for J <= 0; -2 for a non-finite state.
    for a in prange(len(F)):
        F_a = load(F, a)
        detF = determinant(F_a)
        J_a = J[a] if has_J else detF
        stretch = smallest_stretch(F_a)
        if not (
            math.isfinite(stretch)
            and math.isfinite(J_a)
            and math.isfinite(p[a, 0] + p[a, 1] + p[a, 2])
        ):
            limit[a] = -2.0
        elif J_a <= 0.0 or detF <= 0.0:
            limit[a] = -1.0
        else:
            limit[a] = stretch


def _reason(limit: float) -> str:
    if limit < -1.5:
        return "non-finite state"
    if limit < 0.0:
        return "negative Jacobian"
    return f"compressed to {100.0 * limit:.2g} % of its length (least allowed {THINNEST:.1%})"


def check_cfl(cfl: float) -> None:
    """Raise ``InputError`` unless the CFL number is positive and finite."""
    require(
        math.isfinite(cfl) and cfl > 0.0,
        f"cfl = {cfl} must be positive and finite; 0.3 is the paper's value",
    )


class TimeStep:
    """``dt = alpha_CFL h_min / max_a c_p,a`` with ``c_p,a = c_p / (smallest stretch of F_a)``.

    ``h_min`` [m] is the smallest particle spacing of the reference body and ``c_p`` [m/s] the
    p-wave speed of the undeformed solid.
    """

    def __init__(self, *, cfl: float, h_min: float, wave_speed: float, size: int) -> None:
        check_cfl(cfl)
        if not (h_min > 0.0 and math.isfinite(wave_speed)):
            raise InputError(f"h_min = {h_min} m and c_p = {wave_speed} m/s must be positive")
        self.cfl = cfl
        self.reference = cfl * h_min / wave_speed
        self._limit = np.empty(size)

    def stable(
        self, has_J: bool, p: Array, F: Array, J: Array, X: Array, time: float, step: int
    ) -> float:
        """``dt`` [s] now; raises ``Diverged`` naming the first invalid particle.

        Invalid: a field that is not finite, ``J <= 0``, a stretch below ``THINNEST``.
        """
        _stretch_limits(has_J, p, F, J, self._limit)
        least = float(np.min(self._limit))
        if least < THINNEST:
            a = int(np.argmax(self._limit < THINNEST))
            reason = _reason(float(self._limit[a]))
            x, y, z = (float(c) for c in X[a])
            raise Diverged(reason, time, step, a, (x, y, z), ADVICE)
        return self.reference * least
