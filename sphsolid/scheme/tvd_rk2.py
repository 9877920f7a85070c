"""Two-stage total-variation-diminishing Runge-Kutta, [Lee2017] Algorithm 1 after [Shu1988].

    U*      = U^n + dt R(U^n, t^n)
    U**     = U*  + dt R(U*,  t^n + dt)
    U^{n+1} = (U^n + U**) / 2,        x^{n+1} = x^n + dt (p^n + p*) / (2 rho0)

``x^{n+1}`` is known before stage two, which projects with it: that is what makes angular momentum
exact.  Formulations that take ``F`` from the geometry use ``x* = x^n + dt p^n / rho0`` in stage
two, so that they are algebraically the scheme that evolves ``F``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sphsolid.compiled import kernel, prange
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.power import Account, NoAccount
from sphsolid.scheme.right_hand_side import RightHandSide, State


@kernel
def _first_stage(dt, U, rate, saved):  # type: ignore[no-untyped-def]
    for i in prange(len(U)):
        saved[i] = U[i]
        U[i] = U[i] + dt * rate[i]


@kernel
def _second_stage(dt, saved, rate, U):  # type: ignore[no-untyped-def]
    for i in prange(len(U)):
        U[i] = 0.5 * (saved[i] + (U[i] + dt * rate[i]))


@kernel
def _move(factor, p_a, p_b, x):  # type: ignore[no-untyped-def]
    for i in prange(len(x)):
        x[i] = x[i] + factor * (p_a[i] + p_b[i])


@dataclass(frozen=True)
class TVDRK2:
    """The paper's integrator; two evaluations a step."""

    name: str = "TVD-RK2"
    stages: int = 2

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> TVDRK2Stepper:
        """A stepper with its own work arrays."""
        return TVDRK2Stepper(rhs, state, essential)


class TVDRK2Stepper:
    """Advances one state in place; ``account`` is told of every stage."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        self.rhs = rhs
        self.state = state
        self.essential = essential
        self.account: Account | NoAccount = NoAccount()
        fields = state.evolved(rhs.formulation)
        rates = rhs.rates.evolved(rhs.formulation)
        # Flat views: the stage formulas are the same for every field.
        self._fields = [field.reshape(-1) for field in fields]
        self._rates = [rate.reshape(-1) for rate in rates]
        self._saved = [np.empty_like(field) for field in self._fields]
        self._x_star = np.empty_like(state.x if not rhs.formulation.evolves_F else state.x[:0])

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``; ``rhs.F_x`` belongs to ``state.x`` before and after."""
        rhs, state, rho = self.rhs, self.state, self.rhs.material.density
        flat_x = state.x.reshape(-1)

        rhs.evaluate(state, state.x, dt, t)
        self.account.stage(state, state.x, 0.5 * dt, t)
        for field, rate, saved in zip(self._fields, self._rates, self._saved, strict=True):
            _first_stage(dt, field, rate, saved)
        # Half of a jump made here is averaged away: p^{n+1} = (p^n + p**) / 2.
        self.account.impose(self.essential, state, t + dt, 0.5)

        if not rhs.formulation.evolves_F:
            x_star = self._x_star
            x_star[:] = state.x
            p_old = self._saved[0]
            _move(0.5 * dt / rho, p_old, p_old, x_star.reshape(-1))
            rhs.kinematic_gradient(x_star, 1.0, state.F)
        _move(0.5 * dt / rho, self._saved[0], self._fields[0], flat_x)
        rhs.set_geometry(state.x)

        rhs.evaluate(state, state.x, dt, t + dt)
        self.account.stage(state, state.x, 0.5 * dt, t + dt)
        for field, rate, saved in zip(self._fields, self._rates, self._saved, strict=True):
            _second_stage(dt, saved, rate, field)
        self.account.impose(self.essential, state, t + dt, 1.0)
        if not rhs.formulation.evolves_F:
            rhs.kinematic_gradient(state.x, 1.0, state.F)
