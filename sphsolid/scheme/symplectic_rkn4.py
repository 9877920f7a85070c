"""Fourth-order symplectic Runge-Kutta-Nystroem step: five kicks between drifts, exact momenta.

    drift a1, kick b1, drift a2, kick b2, drift a3, kick b3, drift a3, kick b2, drift a2, kick b1,
    drift a1

as shares of ``dt``, the same read backwards.  Each kick takes one evaluation.  With ``c_i`` the
sum of the drifts and ``B_i`` the sum of the kicks so far, kick ``i`` takes loads of the time
``t + c_i dt`` and ends with the essential conditions of the time ``t + B_i dt``.

**Order.**  Four, for forces that depend on ``x`` and ``t``, if

    sum b = 1,    sum b_i c_i^2 = 1/3,    sum_(i>j) b_i b_j (c_i - c_j) = 1/6

because a symmetric step has an even order ([Okunbor1992]).  Time is one more position for loads
and one more momentum for conditions, so neither costs an order.

**Stability.**  For a mode of frequency ``w`` the step is a matrix ``M(w dt)`` of determinant one,
and half its trace approximates ``cos(w dt)``.  In most schemes it overshoots -1 where the cosine
turns, near ``w dt = pi``, and there the mode grows: 0.63 an evaluation at most, for five.  Here
``M = -1`` exactly at ``w dt = 3.1528``, so the trace touches -1 and turns ([McLachlan1997]): modes
neither grow nor decay up to ``w dt = 7.46``, or 1.49 an evaluation, where Verlet has 2.  These two
equations, the two of the order and ``b2 = -1/20`` fix all coefficients.  A more negative ``b2``
has a smaller error and bears less damping.

**What was compared.**  The error is that of the fifth order, in the norm of the six conditions of
[Okunbor1992] over their symmetries, times the fourth power of the evaluations a step:

    [Yoshida1990] 3         w dt 0.52 an evaluation    error 9.8
    [Suzuki1990] 5               0.54                        4.2
    [Omelyan2002] 4              0.75                        0.71
    [Blanes2002] S6, 6           0.52                        0.30
    here 5                       1.49                        0.49

Force-gradient steps ([Chin1997]: 1.15 for three evaluations of which one is a gradient) need the
derivative of the force along the force.  A force at shifted positions in its place loses angular
momentum at order four, and the exact one would ask a linearisation of every law and term.

**Damping.**  Order four needs a negative kick ([Sheng1989]).  It is a twentieth of the step, and
the whole of a step damps each mode at least as fast as it should while the damping is small.  A
rate ``d`` of damping alone is stable to ``d dt = 5.0``, which is 1.0 an evaluation where Verlet
has 2; oscillations are stable to ``w dt = 5.3`` up to ``d dt = 2``.  The lag of ``D(p)`` in a kick
is an error of first order in ``dt D``.

**Large motion.**  At ``M = -1`` modes are in resonance with the step.  A nonlinear force couples
them, and undamped noise beyond ``w dt = pi`` may grow slowly; a little damping holds it.  The usual
CFL number of 1.5 stays below, at half the limit (noise on a free block at rest is kept at 3.0).
``SUPG`` with times of the step damps five times as much as with Verlet, and diverges at 1.8; with
times of the mesh, and in the displacement form, 1.8 to 2 can be asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.drift_kick import DriftKick
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State

_A1, _A2 = 0.1078369871546283667, -0.1713863368986584614
_B1, _B2 = 0.3741815196159513980, -0.05
_A3, _B3 = 0.5 - (_A1 + _A2), 1.0 - 2.0 * (_B1 + _B2)

#: Shares of the step, in order.
DRIFTS = (_A1, _A2, _A3, _A3, _A2, _A1)
KICKS = (_B1, _B2, _B3, _B2, _B1)
#: When the kicks happen, for loads: the drifts so far.
AT = (_A1, _A1 + _A2, 0.5, 1.0 - (_A1 + _A2), 1.0 - _A1)
#: Which momenta they lead to, for essential conditions: the kicks so far.
LEADS_TO = (_B1, _B1 + _B2, 1.0 - (_B1 + _B2), 1.0 - _B1, 1.0)


@dataclass(frozen=True)
class SymplecticRKN4:
    """Five evaluations a step, order four, stable on the imaginary axis up to ``w dt = 7.46``."""

    name: str = "symplectic RKN4"
    stages: int = 5
    usual_cfl: ClassVar[float] = 1.5
    #: ``w dt`` up to which an undamped oscillation does not grow.
    largest_phase: ClassVar[float] = 7.46
    #: The evaluation takes an ``F`` that is not evolved.
    derives_F: ClassVar[bool] = True

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> SymplecticRKN4Stepper:
        """A stepper with its own work arrays."""
        return SymplecticRKN4Stepper(rhs, state, essential)


class SymplecticRKN4Stepper(DriftKick):
    """Advances one state in place."""

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        for a, b, at, leads_to in zip(DRIFTS[:-1], KICKS, AT, LEADS_TO, strict=True):
            self.drift_and_kick(a * dt, b * dt, t + at * dt, t + leads_to * dt)
        self.drift(DRIFTS[-1] * dt)
