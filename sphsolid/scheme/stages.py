"""Array formulas of the Runge-Kutta stages, on flat views: the same for every field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.fields import components
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.energy_budget import NoBudget, StageBudget
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State

Array = NDArray[np.float64]


@kernel
def _first(dt, U, rate, saved):  # type: ignore[no-untyped-def]
    for i in prange(len(U)):
        saved[i] = U[i]
        U[i] = U[i] + dt * rate[i]


@kernel
def pushed_by(dt, rate, U):  # type: ignore[no-untyped-def]
    """``U += dt R`` for flat ``U`` and ``R``."""
    for i in prange(len(U)):
        U[i] += dt * rate[i]


@kernel
def _convex(share, dt, saved, rate, U):  # type: ignore[no-untyped-def]
    # As an increment: share and 1 - share do not add up to one in floating point when share is a
    # third, and a momentum that nothing changes would drift by their sum, one way, every step.
    other = 1.0 - share
    for i in prange(len(U)):
        U[i] = saved[i] + other * ((U[i] - saved[i]) + dt * rate[i])


@kernel
def _combine(x, factor, weights, p_0, p_1, out):  # type: ignore[no-untyped-def]
    w_0, w_1 = factor * weights[0], factor * weights[1]
    for i in prange(len(x)):
        out[i] = x[i] + (w_0 * p_0[i] + w_1 * p_1[i])


def moved(
    x: Array, factor: float, weights: tuple[float, float], p_0: Array, p_1: Array, out: Array
) -> None:
    """``out = x + factor (w_0 p_0 + w_1 p_1)  (N, 3)``; ``out`` may be ``x``."""
    flat = (components(array).reshape(-1) for array in (p_0, p_1, out))
    _combine(components(x).reshape(-1), factor, weights, *flat)


@dataclass(frozen=True)
class Stages:
    """All evolved fields but ``x``, their rates, and their values at the start of the step."""

    fields: list[Array]
    rates: list[Array]
    saved: list[Array]
    p_start: Array

    @classmethod
    def of(cls, rhs: RightHandSide, state: State) -> Stages:
        """Views of ``state`` and of the rates, and room for the start of a step."""
        start = rhs.zeros()
        fields, rates, saved = (
            [components(fields[name]).reshape(-1) for name in rhs.evolved]
            for fields in (state, rhs.rates, start)
        )
        return cls(fields, rates, saved, start.p)

    def first(self, dt: float) -> None:
        """``U = U^n + dt R``, keeping ``U^n``."""
        for field, rate, saved in zip(self.fields, self.rates, self.saved, strict=True):
            _first(dt, field, rate, saved)

    def convex(self, share: float, dt: float) -> None:
        """``U = share U^n + (1 - share) (U + dt R)``, exactly ``U^n`` where nothing changes."""
        for field, rate, saved in zip(self.fields, self.rates, self.saved, strict=True):
            _convex(share, dt, saved, rate, field)


class RungeKuttaStepper:
    """What the steppers of several stages share; ``budget`` is told of every stage."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        self.rhs = rhs
        self.state = state
        self.essential = essential
        self.budget: StageBudget | NoBudget = NoBudget()
        self.work = Stages.of(rhs, state)
