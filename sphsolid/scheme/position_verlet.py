"""Position Verlet ([Tuckerman1992]): one evaluation a step, symplectic, exact angular momentum.

    drift by dt/2   x, F, H, J with p^n
    kick by dt      p^{n+1} = p^n + dt f at t + dt/2, and J + dt D(J)
    drift by dt/2   x, F, H, J with p^{n+1}

**Drift.**  While ``L = grad v`` stays what it is, (31b)-(31d) of [Lee2017] have the solution

    F + a L,    H + a F x L + a^2/2 L x L,    J + a H : L + a^2/2 (F x L) : L + a^3/6 (L x L) : L

after a time ``a``, and that is the drift.  So ``H = cof F`` and ``J = det F`` remain what they are,
to round-off, where nothing damps them: without stabilisation all formulations are one and the same
method, and for an adjoint operator it is symplectic, so the energy error does not pile up.

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

from dataclasses import dataclass, replace

import numpy as np

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.tensor import axpy, cofactor, contract, cross, load, store
from sphsolid.fields import tensor_field, vector_field
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.power import Account, NoAccount
from sphsolid.scheme.right_hand_side import RightHandSide, State
from sphsolid.scheme.stabilisation import SUPG
from sphsolid.scheme.stages import Stages, Stepper, moved


@kernel
def _drift(a, has_F, has_H, has_J, L, F, H, J):  # type: ignore[no-untyped-def]
    for i in prange(len(L)):
        L_i, F_i = load(L, i), load(F, i)
        FxL, LxL = cross(F_i, L_i), cross(L_i, L_i)
        H_i = load(H, i) if has_H else cofactor(F_i)
        if has_J:
            curved = 0.5 * contract(FxL, L_i) + a / 6.0 * contract(LxL, L_i)
            J[i] += a * (contract(H_i, L_i) + a * curved)
        if has_H:
            store(axpy(a, axpy(0.5 * a, LxL, FxL), H_i), H, i)
        if has_F:
            store(axpy(a, L_i, F_i), F, i)


@kernel
def _kick_J(dt, has_H, L, F, H, Jdot, J):  # type: ignore[no-untyped-def]
    # The drift has what the velocities do to J; what is left of its rate is D(J).
    for i in prange(len(J)):
        H_i = load(H, i) if has_H else cofactor(load(F, i))
        J[i] += dt * (Jdot[i] - contract(H_i, load(L, i)))


@kernel
def _differing(one, other):  # type: ignore[no-untyped-def]
    count = 0
    for i in prange(len(one)):
        if one[i, 0] != other[i, 0] or one[i, 1] != other[i, 1] or one[i, 2] != other[i, 2]:
            count += 1
    return count


@dataclass(frozen=True)
class PositionVerlet:
    """One evaluation a step, second order, stable on the imaginary axis up to ``w dt = 2``."""

    name: str = "position Verlet"
    stages: int = 1

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> PositionVerletStepper:
        """A stepper with its own work arrays."""
        return PositionVerletStepper(rhs, state, essential)


class PositionVerletStepper(Stepper):
    """Advances one state in place."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        self.rhs = rhs
        self.state = state
        self.essential = essential
        self.account: Account | NoAccount = NoAccount()
        # Of the start of a step nothing but p is needed later on.
        self.work = Stages([], [], [], vector_field(len(state.p)))
        f, supg = rhs.formulation, rhs.stabilisation
        self._damps_J = isinstance(supg, SUPG) and supg.tau_p > 0.0
        self._drifts = f.evolves_F or f.evolves_H or f.evolves_J
        self._L = tensor_field(
            len(state.p) if self._drifts else 0, particle_major=rhs.cloud.particle_major
        )
        self._p_of_L = vector_field(len(self._L))
        self._p_of_L[:] = np.nan

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        rhs, state, essential = self.rhs, self.state, self.essential
        p_start, half = self.work.p_start, t + 0.5 * dt
        self._drift(0.5 * dt)
        rates = rhs.evaluate(state, state.x, dt, half)
        p_start[:] = state.p
        moved(p_start, dt, (0.5, 0.5), rates.p, rates.p, state.p)
        held = essential.particles
        pushed = state.p[held]
        essential.impose(state.p, t + dt)
        if isinstance(self.account, Account):
            # What the conditions add to p is the constraint's doing, and every force works with
            # the mean velocity of the step, so that the kinetic energy is accounted for exactly.
            rhs.reaction += (state.p[held] - pushed) / dt
            mean = replace(state, p=0.5 * (p_start + state.p))
            rhs.kinematic_gradient(mean.p, 1.0 / rhs.material.density, rates.F)
            self.account.stage(mean, state.x, dt, half)
        if self._damps_J:
            _kick_J(dt, rhs.formulation.evolves_H, self._L, state.F, state.H, rates.J, state.J)
        self._drift(0.5 * dt)

    def _drift(self, a: float) -> None:
        rhs, state, f = self.rhs, self.state, self.rhs.formulation
        density = rhs.material.density
        if self._drifts:
            # The velocities at the end of a step are those at the start of the next, unless
            # somebody changed the state in between.
            if _differing(state.p, self._p_of_L):
                rhs.kinematic_gradient(state.p, 1.0 / density, self._L)
                self._p_of_L[:] = state.p
            _drift(a, f.evolves_F, f.evolves_H, f.evolves_J, self._L, state.F, state.H, state.J)
        moved(state.x, a / density, (0.5, 0.5), state.p, state.p, state.x)
        if not f.evolves_F:
            rhs.kinematic_gradient(state.x, 1.0, state.F)
