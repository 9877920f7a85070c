"""Drift and kick, of which the symplectic integrators are composed.

**Drift** by a time ``a``: ``x + a p/rho0``.  While ``L = grad v`` stays what it is, (31b)-(31d) of
[Lee2017] have the solution

    F + a L,    H + a F x L + a^2/2 L x L,    J + a H : L + a^2/2 (F x L) : L + a^3/6 (L x L) : L

and that is the drift of the strains, for ``a`` of either sign.  So ``H = cof F`` and ``J = det F``
remain what they are, to round-off, where nothing damps them.

**Kick** by a time ``b``: ``p + b f`` with ``f`` at the positions of the kick, and ``J + b D(J)``.

**Angular momentum.**  A drift moves ``x`` along ``p`` and a kick has ``sum V y x f = 0``, or the
moment of the loads, at its own positions ``y``: projecting with ``F_x(y)`` makes every step that
is composed of drifts and kicks keep angular momentum exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum.tensor import axpy, cofactor, contract, cross
from sphsolid.fields import LANES, components, vector_field
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.energy_budget import NoBudget, StageBudget
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.stages import pushed_by
from sphsolid.scheme.state import State
from sphsolid.scheme.tile import STRIDE, U, load_lane, make_scratch, store_lane

Array = NDArray[np.float64]
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


class DriftKick:
    """Moves one state in place; ``budget`` is told of every kick.

    ``rhs.rates.F`` is kept from drift to drift, so a drift that follows one takes no gradient.
    """

    def __init__(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> None:
        self.rhs = rhs
        self.state = state
        self.essential = essential
        self.budget: StageBudget | NoBudget = NoBudget()
        # Of the start of a kick nothing but p is needed later on, and that by a budget alone.
        self._p_start = vector_field(0)
        self._scratch = make_scratch()
        self._x, self._p, self._force = (
            components(field).reshape(-1) for field in (state.x, state.p, rhs.rates.p)
        )
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

    def drift_and_kick(self, a: float, b: float, at: float, imposed_at: float) -> None:
        """A drift by ``a`` [s], then a kick by ``b`` [s]; in one launch where there is one."""
        rhs, state = self.rhs, self.state
        if not self.budget.looks and rhs.drift_and_kick(a, b, state, at):
            self.essential.prescribe(state.p, imposed_at)
            return
        self.drift(a)
        self.kick(b, at, imposed_at)

    def kick(self, b: float, at: float, imposed_at: float) -> None:
        """By ``b`` [s], with the loads of time ``at`` and the conditions of ``imposed_at``."""
        rhs, state, essential = self.rhs, self.state, self.essential
        rhs.evaluate(
            state, state.x, at, knows_L=self._drifts, derives_F=not rhs.formulation.evolves_F
        )
        p_start = self._kept(state.p)
        pushed_by(b, self._force, self._p)
        # What the conditions do is of interest to a budget alone.
        pushed = state.p[essential.particles] if self.budget.looks else p_start
        essential.impose(state.p, imposed_at)
        self.budget.kick(state, p_start, pushed, b, at)
        for field, rate in self._pushed:
            pushed_by(b, rate, field)
        if self._kicks_J:
            _, F, H, J = state.rows()
            _kick_J(
                b, components(rhs.rates.F), F, H, components(rhs.rates.J), J, self._scratch
            )

    def _kept(self, p: Array) -> Array:
        """A copy of ``p``, or itself where nobody will ask what it was."""
        if not self.budget.looks:
            return p
        if not self._p_start.size:
            self._p_start = vector_field(len(p))
        self._p_start[:] = p
        return self._p_start

    def drift(self, a: float) -> None:
        """By ``a`` [s] with the velocities that there are."""
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
        pushed_by(a / density, self._p, self._x)
        # The drift of J needs the F it starts from.
        if self._drifts and not f.evolves_F:
            rhs.deformation_gradient(state.x, state.F)
