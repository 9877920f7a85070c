"""Position Verlet ([Tuckerman1992]): one evaluation a step, symplectic, exact angular momentum.

    drift by dt/2   x, F, H, J with p^n
    kick by dt      p^{n+1} = p^n + dt f at t + dt/2, and J + dt D(J)
    drift by dt/2   x, F, H, J with p^{n+1}

Without stabilisation all formulations are one and the same method, because the drift is exact
(``scheme.drift_kick``), and for an adjoint operator it is symplectic: the energy error does not
pile up.

**Angular momentum.**  Let ``y`` be the positions of the kick.  From ``x^n = y - dt/(2 rho0) p^n``
and ``x^{n+1} = y + dt/(2 rho0) p^{n+1}``,

    sum V (x^{n+1} x p^{n+1} - x^n x p^n) = sum V y x (p^{n+1} - p^n) = dt sum V y x f

for any ``f``: projecting with ``F_x(y)`` makes it exact.

**Stability.**  A mode of frequency ``w``, damped at the rate ``d`` by the velocities ``p^n``, is
multiplied by ``|g| = sqrt(1 - d dt)`` a step while ``(w dt)^2 + 2 d dt < 4``: damping that lags by
half a step damps still.  A ``D(p)`` that makes energy (``docs/stability.md``) makes it here too.
Undamped modes neither grow nor decay up to ``w dt = 2``; the three evaluations of SSP-RK3 reach
1.73.

**Order.**  Two without damping.  The lag displaces a solution by ``dt D(p) / 2``, once and not
step after step, because a damping step between kicks and drifts that are symmetric is conjugate to
one that is symmetric itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.drift_kick import DriftKick
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State


@dataclass(frozen=True)
class PositionVerlet:
    """One evaluation a step, second order, stable on the imaginary axis up to ``w dt = 2``."""

    name: str = "position Verlet"
    stages: int = 1
    usual_cfl: ClassVar[float] = 0.7
    #: ``w dt`` up to which an undamped oscillation does not grow.
    largest_phase: ClassVar[float] = 2.0
    #: The evaluation takes an ``F`` that is not evolved.
    derives_F: ClassVar[bool] = True

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> PositionVerletStepper:
        """A stepper with its own work arrays."""
        return PositionVerletStepper(rhs, state, essential)


class PositionVerletStepper(DriftKick):
    """Advances one state in place."""

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        self.drift_and_kick(0.5 * dt, dt, t + 0.5 * dt, t + dt)
        self.drift(0.5 * dt)
