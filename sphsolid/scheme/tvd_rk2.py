"""Two-stage total-variation-diminishing Runge-Kutta, [Lee2017] Algorithm 1 after [Shu1988].

    U*      = U^n + dt R(U^n, t^n)
    U**     = U*  + dt R(U*,  t^n + dt)
    U^{n+1} = (U^n + U**) / 2,        x^{n+1} = x^n + dt (p^n + p*) / (2 rho0)

``x^{n+1}`` is known before stage two, which projects with it: that is what makes angular momentum
exact.  Formulations that take ``F`` from the geometry use ``x* = x^n + dt p^n / rho0`` in stage
two, so that they are algebraically the scheme that evolves ``F``.

Undamped modes grow, by ``(w dt)^4 / 8`` a step: see ``ssp_rk3``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sphsolid.fields import vector_field
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.stages import RungeKuttaStepper, moved
from sphsolid.scheme.state import State


@dataclass(frozen=True)
class TVDRK2:
    """The paper's integrator; two evaluations a step."""

    name: str = "TVD-RK2"
    stages: int = 2
    usual_cfl: ClassVar[float] = 0.3
    #: ``w dt`` up to which an undamped oscillation does not grow.
    largest_phase: ClassVar[float] = 0.0

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> TVDRK2Stepper:
        """A stepper with its own work arrays."""
        return TVDRK2Stepper(rhs, state, essential)


class TVDRK2Stepper(RungeKuttaStepper):
    """Advances one state in place."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        super().__init__(rhs, state, essential)
        self._x_star = vector_field(0 if rhs.formulation.evolves_F else len(state.x))

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        rhs, state, stages = self.rhs, self.state, self.work
        step, p_start = dt / rhs.material.density, self.work.p_start

        rhs.evaluate(state, state.x, t)
        self.budget.stage(state, state.x, 0.5 * dt, t)
        stages.first(dt)
        # Half of a jump made here is averaged away: p^{n+1} = (p^n + p**) / 2.
        self.budget.impose(self.essential, state, t + dt, 0.5)

        if not rhs.formulation.evolves_F:
            moved(state.x, step, (0.5, 0.5), p_start, p_start, self._x_star)
            rhs.deformation_gradient(self._x_star, state.F)
        moved(state.x, step, (0.5, 0.5), p_start, state.p, state.x)

        rhs.evaluate(state, state.x, t + dt)
        self.budget.stage(state, state.x, 0.5 * dt, t + dt)
        stages.convex(0.5, dt)
        self.budget.impose(self.essential, state, t + dt, 1.0)
        self.budget.accelerate(p_start, state, dt)
        if not rhs.formulation.evolves_F:
            rhs.deformation_gradient(state.x, state.F)
