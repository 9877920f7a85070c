"""Three-stage strong-stability-preserving Runge-Kutta ([Shu1988]) that keeps angular momentum.

    U1      = U^n + dt R(U^n, t)
    U2      = 3/4 U^n + 1/4 [U1 + dt R(U1, t + dt)]
    U^{n+1} = 1/3 U^n + 2/3 [U2 + dt R(U2, t + dt/2)]

so ``p^{n+1} = p^n + dt sum_s b_s f_s`` with ``b = (1/6, 1/6, 2/3)`` at times ``tau = (0, 1, 1/2)``.

**Where to project.**  Ask that, for all ``f_s``,

    sum V (x^{n+1} x p^{n+1} - x^n x p^n) = dt sum_s b_s sum V y_s x f_s:

then projecting stage ``s`` with ``F_x(y_s)`` makes angular momentum exact.  With

    x^{n+1} = x^n + dt/rho0 (p^n + dt sum_s c_s f_s),
    y_s     = x^n + dt/rho0 (tau_s p^n + dt sum_{r<s} beta_sr f_r)

the two sides agree if and only if ``c_s = b_s (1 - tau_s)`` and ``beta_sr = b_r (tau_s - tau_r)``.
Both are known when stage ``s`` begins, and ``sum c = 1/2``, ``sum c tau = 1/6`` make ``x`` third
order (they are the conditions of a symplectic Runge-Kutta-Nystroem method, [Okunbor1992]).  The
positions that the same Runge-Kutta formulas would give do not have the property.  In terms of the
stage momenta, which hold the essential conditions,

    y_1 = x^n + dt/rho0 (5/6 p^n + 1/6 p1),    y_2 = x^n + dt/rho0 (2/3 p^n + 1/6 p1 - 1/3 p2),
    x^{n+1} = y_2 + dt/(2 rho0) p^{n+1}.

Formulations that take ``F`` from the geometry take it from ``y_s`` too: without damping they are
the symplectic method itself, need no projection, and are second order (``sum b beta = 1/36``).

**Why.**  An undamped mode of frequency ``w`` is damped by ``(w dt)^4 / 24`` a step and stable to
``w dt = 1.73``; the paper's two stages let it grow at any step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sphsolid.fields import vector_field
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.stages import RungeKuttaStepper, moved
from sphsolid.scheme.state import State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SSPRK3:
    """Three evaluations a step, third order (see above), stable on the imaginary axis."""

    name: str = "SSP-RK3"
    stages: int = 3
    usual_cfl: ClassVar[float] = 0.5
    #: ``w dt`` up to which an undamped oscillation does not grow.
    largest_phase: ClassVar[float] = math.sqrt(3.0)

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> SSPRK3Stepper:
        """A stepper with its own work arrays."""
        return SSPRK3Stepper(rhs, state, essential)


class SSPRK3Stepper(RungeKuttaStepper):
    """Advances one state in place."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        super().__init__(rhs, state, essential)
        self._y = vector_field(len(state.x))

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        rhs, state, stages, y = self.rhs, self.state, self.work, self._y
        step, p_start = dt / rhs.material.density, self.work.p_start

        rhs.evaluate(state, state.x, t)
        self.budget.stage(state, state.x, dt / 6.0, t)
        stages.first(dt)
        # Weights: the share of a jump of p made here that is still in p^{n+1}.
        self.budget.impose(self.essential, state, t + dt, 1.0 / 6.0)

        moved(state.x, step, (5.0 / 6.0, 1.0 / 6.0), p_start, state.p, y)
        self._take_geometry(y)
        rhs.evaluate(state, y, t + dt)
        self.budget.stage(state, y, dt / 6.0, t + dt)
        moved(state.x, step, (2.0 / 3.0, 1.0 / 6.0), p_start, state.p, y)
        stages.convex(0.75, dt)
        self.budget.impose(self.essential, state, t + 0.5 * dt, 2.0 / 3.0)

        moved(y, -step / 3.0, (0.5, 0.5), state.p, state.p, y)
        self._take_geometry(y)
        rhs.evaluate(state, y, t + 0.5 * dt)
        self.budget.stage(state, y, 2.0 * dt / 3.0, t + 0.5 * dt)
        stages.convex(1.0 / 3.0, dt)
        self.budget.impose(self.essential, state, t + dt, 1.0)
        self.budget.accelerate(p_start, state, dt)

        moved(y, step, (0.25, 0.25), state.p, state.p, state.x)
        self._take_geometry(state.x)

    def _take_geometry(self, x: Array) -> None:
        if not self.rhs.formulation.evolves_F:
            self.rhs.deformation_gradient(x, self.state.F)
