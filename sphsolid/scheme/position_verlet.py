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

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum.tensor import axpy, cofactor, contract, cross
from sphsolid.fields import LANES, components, vector_field
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.energy_budget import NoBudget, StageBudget
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.stages import moved, pushed_by
from sphsolid.scheme.state import State
from sphsolid.scheme.tile import STRIDE, U, load_lane, make_scratch, store_lane

# Scratch rows.
_L, _F, _H, _J = 0, 9, 18, 27


@inlined
def _rate_of_J(S, lane, has_H, a):  # type: ignore[no-untyped-def]
    """``[J(a) - J(0)] / a`` of the drift; ``H : L`` for ``a = 0``."""
    L, F = load_lane(S, _L, lane), load_lane(S, _F, lane)
    H = load_lane(S, _H, lane) if has_H else cofactor(F)
    curved = 0.5 * contract(cross(F, L), L) + a / 6.0 * contract(cross(L, L), L)
    return contract(H, L) + a * curved


@kernel
def _drift(a, has_F, L, F, H, J, scratch):  # type: ignore[no-untyped-def]
    has_H, has_J = H.size > 0, J.size > 0
    tiles, workers = L.size // (9 * LANES), len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch_tensor(L, at, S, _L)
            on_tile.fetch_tensor(F, at, S, _F)
            if has_H:
                on_tile.fetch_tensor(H, at, S, _H)
            if has_J:
                on_tile.fetch(J, 1, at, S, _J)
                for lane in range(U(LANES)):
                    S[U(_J * STRIDE) + lane] += a * _rate_of_J(S, lane, has_H, a)
                on_tile.put(S, _J, 1, at, J)
            if has_H:
                for lane in range(U(LANES)):
                    L_a = load_lane(S, _L, lane)
                    rate = axpy(0.5 * a, cross(L_a, L_a), cross(load_lane(S, _F, lane), L_a))
                    store_lane(axpy(a, rate, load_lane(S, _H, lane)), S, _H, lane)
                on_tile.put_tensor(S, _H, at, H)
            if has_F:
                for lane in range(U(LANES)):
                    moved_F = axpy(a, load_lane(S, _L, lane), load_lane(S, _F, lane))
                    store_lane(moved_F, S, _F, lane)
                on_tile.put_tensor(S, _F, at, F)


@kernel
def _kick_J(dt, L, F, H, Jdot, J, scratch):  # type: ignore[no-untyped-def]
    # The drift has what the velocities do to J; what is left of its rate is D(J).
    has_H = H.size > 0
    tiles, workers = L.size // (9 * LANES), len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch_tensor(L, at, S, _L)
            on_tile.fetch_tensor(F, at, S, _F)
            if has_H:
                on_tile.fetch_tensor(H, at, S, _H)
            on_tile.fetch(J, 1, at, S, _J)
            for lane in range(U(LANES)):
                left = Jdot[0, at + lane] - _rate_of_J(S, lane, has_H, 0.0)
                S[U(_J * STRIDE) + lane] += dt * left
            on_tile.put(S, _J, 1, at, J)


@kernel
def _differing(one, other, size):  # type: ignore[no-untyped-def]
    # Only particles count: the padding of a row may hold anything.
    count = 0
    for i in prange(size):
        if one[0, i] != other[0, i] or one[1, i] != other[1, i] or one[2, i] != other[2, i]:
            count += 1
    return count


@dataclass(frozen=True)
class PositionVerlet:
    """One evaluation a step, second order, stable on the imaginary axis up to ``w dt = 2``."""

    name: str = "position Verlet"
    stages: int = 1
    usual_cfl: ClassVar[float] = 0.7
    #: The evaluation takes an ``F`` that is not evolved.
    derives_F: ClassVar[bool] = True

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> PositionVerletStepper:
        """A stepper with its own work arrays."""
        return PositionVerletStepper(rhs, state, essential)


class PositionVerletStepper:
    """Advances one state in place."""

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        self.rhs = rhs
        self.state = state
        self.essential = essential
        self.budget: StageBudget | NoBudget = NoBudget()
        # Of the start of a step nothing but p is needed later on.
        self._p_start = vector_field(len(state.p))
        self._scratch = make_scratch()
        self._kicks_J = any("J" in term.changes for term in rhs.terms)
        self._drifts = any(name in rhs.evolved for name in "FHJ")
        #: Fields that no drift moves, with their rates.
        self._pushed = [
            tuple(components(fields[name]).reshape(-1) for fields in (state, rhs.rates))
            for name in rhs.evolved
            if name not in "pFHJ"
        ]
        # Which velocities rhs.rates.F is the gradient of.
        self._p_of_L = vector_field(len(state.p) if self._drifts else 0)
        self._p_of_L[:] = np.nan

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt``."""
        rhs, state, essential = self.rhs, self.state, self.essential
        p_start, half = self._p_start, t + 0.5 * dt
        self._drift(0.5 * dt)
        rates = rhs.evaluate(
            state, state.x, half, knows_L=self._drifts, derives_F=not rhs.formulation.evolves_F
        )
        p_start[:] = state.p
        moved(p_start, dt, (0.5, 0.5), rates.p, rates.p, state.p)
        held = essential.particles
        pushed = state.p[held]
        essential.impose(state.p, t + dt)
        self.budget.kick(state, p_start, pushed, dt, half)
        for field, rate in self._pushed:
            pushed_by(dt, rate, field)
        if self._kicks_J:
            _, F, H, J = state.rows()
            _kick_J(
                dt, components(rhs.rates.F), F, H, components(rhs.rates.J), J, self._scratch
            )
        self._drift(0.5 * dt)

    def _drift(self, a: float) -> None:
        rhs, state, f = self.rhs, self.state, self.rhs.formulation
        density = rhs.material.density
        if self._drifts:
            # The velocities at the end of a step are those at the start of the next, unless
            # somebody changed the state in between.
            if _differing(components(state.p), components(self._p_of_L), len(state.p)):
                rhs.kinematic_gradient(state.p, 1.0 / density, rhs.rates.F)
                self._p_of_L[:] = state.p
            _, F, H, J = state.rows()
            _drift(a, f.evolves_F, components(rhs.rates.F), F, H, J, self._scratch)
        moved(state.x, a / density, (0.5, 0.5), state.p, state.p, state.x)
        # The drift of J needs the F it starts from.
        if self._drifts and not f.evolves_F:
            rhs.deformation_gradient(state.x, state.F)
