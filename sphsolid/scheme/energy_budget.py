"""Powers and impulses of every term of the semi-discrete system: where energy and momentum go.

With ``T`` the internal force (32), the rate of the energy ``E = sum V [|p|^2/(2 rho0) + W]`` is

    dE/dt = sum V v.t_B A/V                  tractions
          + sum V v.f0                       body force
          + sum V v.r                        constraints, r = what ``release`` does to the rate
          + sum V v.D(p)                     dissipation, eq. (34)
          + sum V Sigma_J D(J)               dissipation, eq. (35)
          - sum V (P^C - P) : grad_f v       projection, eq. (40)
          + sum V P : (grad_k v - grad_f v)  force and rate of ``F`` not adjoint

where ``grad_k`` is the gradient in ``dF/dt`` and ``grad_f`` the one whose adjoint is ``T``: the
last line is zero for an adjoint operator.  The right-hand side follows from the scheme's own rates
by the chain rule alone, so what is left over a run is the error of the time integrator.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant, load
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import powers_of

Array = NDArray[np.float64]
#: Works that every run has; those of its terms follow them in :attr:`StageBudget.works`.
TERMS = ("traction", "body_force", "constraint", "projection", "adjoint_defect")


@kernel
def _stress_powers(material, V, L_k, L_f, P_C, given, out):  # type: ignore[no-untyped-def]
    """Columns of ``out (N, 2)`` [W]: projection, adjoint defect."""
    F, H, J = given
    for a in prange(len(V)):
        F_a = load(F, a)
        H_a = load(H, a) if len(H) > 0 else cofactor(F_a)
        J_a = J[a] if len(J) > 0 else determinant(F_a)
        P_a = law.first_piola(material, F_a, H_a, J_a)
        L_f_a = load(L_f, a)
        out[a, 0] = -V[a] * contract(axpy(-1.0, P_a, load(P_C, a)), L_f_a)
        out[a, 1] = V[a] * contract(P_a, axpy(-1.0, L_f_a, load(L_k, a)))


def _moments(impulse: Array, x: Array) -> Array:
    return np.stack([impulse.sum(axis=0), np.cross(x, impulse).sum(axis=0)])


@dataclass(frozen=True)
class NoBudget:
    """Nobody asked where energy and momentum go: the stages are not looked at."""

    looks = False

    def stage(self, state: State, geometry: Array, dt: float, t: float) -> None:
        """Nothing."""

    def kick(
        self, state: State, p_start: Array, pushed: Array, dt: float, t: float
    ) -> None:
        """Nothing."""

    def impose(
        self, essential: EssentialConditions, state: State, t: float, weight: float
    ) -> None:
        """Impose the essential conditions, nothing else."""
        essential.impose(state.p, t)

    def accelerate(self, p_start: Array, state: State, dt: float) -> None:
        """Nothing."""


class StageBudget:
    """Work [J] of every term and impulses, integrated with the integrator's own stages.

    ``works (k,)`` in the order of ``names``, which are :data:`TERMS` and those of the terms of
    the run; ``traction, body_force, constraint (2, 3)`` hold the linear [N s] and the angular
    impulse [N m s] about the origin; ``reaction (n, 3)`` [N s] the impulse on each constrained
    particle.
    """

    looks = True

    def __init__(self, rhs: RightHandSide) -> None:
        self._rhs = rhs
        set_up, operator = rhs.set_up, rhs.operator
        self._V = set_up.cloud.V
        self.names = TERMS + tuple(name for term in rhs.terms for name in term.works)
        self.works = np.zeros(len(self.names))
        self.traction = np.zeros((2, 3))
        self.body_force = np.zeros((2, 3))
        self.constraint = np.zeros((2, 3))
        self.reaction = np.zeros((len(rhs.essential.particles), 3))
        self._powers = np.zeros((operator.size, 2))
        rhs.always_keeps_rates = True
        rhs.keep_galerkin_stress()
        for term in rhs.terms:
            term.keep_for_powers()
        self._L_f = (
            rhs.rates.F if operator.is_adjoint else operator.zeros(Field("L_f", "tensor"))
        )

    @property
    def by_name(self) -> dict[str, float]:
        """Works [J] by name; those of two terms that share one are added up."""
        works = dict.fromkeys(self.names, 0.0)
        for name, work in zip(self.names, self.works.tolist(), strict=True):
            works[name] += work
        return works

    @property
    def traction_impulse(self) -> Array:
        """``(2, 3)`` that of the tractions alone."""
        return self.traction

    @property
    def impulse(self) -> Array:
        """``(2, 3)`` linear and angular impulse of everything from outside."""
        return self.traction + self.body_force + self.constraint

    def arrays(self) -> dict[str, Array]:
        """The running totals, for a checkpoint."""
        names = ("works", "traction", "body_force", "constraint", "reaction")
        return {name: getattr(self, name) for name in names}

    def stage(self, state: State, geometry: Array, dt: float, t: float) -> None:
        """Add ``dt`` [s] times the powers of the evaluation that ``rhs`` has just made.

        ``geometry (N, 3)`` [m] are the positions the stage projected with: moments about them add
        up to the change of angular momentum exactly.
        """
        rhs = self._rhs
        state = rhs.with_strains(state)
        v = state.p / rhs.material.density
        stage = replace(
            rhs.stage, state=state, x=geometry, arms=rhs.operator.arms(geometry), t=t
        )
        powers = [power for term in rhs.terms for power in powers_of(term, stage)]
        self.works[len(TERMS) :] += dt * np.array(powers)
        if not rhs.operator.is_adjoint:
            rhs.operator.force_gradient(v, 1.0, self._L_f)
        _stress_powers(
            rhs.material, self._V, rhs.rates.F, self._L_f, rhs.P_galerkin,
            (state.F, state.H, state.J), self._powers,
        )  # fmt: skip
        self.works[3:5] += dt * np.sum(self._powers, axis=0)
        if rhs.loads.any:
            total, body = rhs.loads.at(t)
            for k, (load_, impulse) in enumerate(
                ((total - body, self.traction), (body, self.body_force))
            ):
                force = dt * self._V[:, None] * load_
                self.works[k] += np.sum(v * force)
                impulse += _moments(force, geometry)
        held = rhs.essential.particles
        if len(held):
            self._react(dt * self._V[held, None] * rhs.reaction, v[held], geometry[held])

    def kick(
        self, state: State, p_start: Array, pushed: Array, dt: float, t: float
    ) -> None:
        """Add a step of one kick, from ``p_start (N, 3)`` to ``state.p`` at positions ``state.x``.

        ``pushed (n, 3)`` are the momenta of the constrained particles before the conditions were
        imposed.  What these add is the constraint's doing, and every force works with the mean
        velocity of the step, so that the kinetic energy is accounted for exactly.
        """
        rhs, held = self._rhs, self._rhs.essential.particles
        density = rhs.material.density
        rhs.reaction += (state.p[held] - pushed) / dt
        mean = state.but(p=0.5 * (p_start + state.p))
        rhs.kinematic_gradient(mean.p, 1.0 / density, rhs.rates.F)
        self.stage(mean, state.x, dt, t)
        rhs.kinematic_gradient(p_start, 1.0 / density, rhs.rates.F)

    def impose(
        self, essential: EssentialConditions, state: State, t: float, weight: float
    ) -> None:
        """Impose the essential conditions; ``weight`` of the jump of ``p`` ends in the step.

        Its impulses are added here, at the positions of the stage, and its work by
        :meth:`accelerate`.
        """
        held = essential.particles
        before = state.p[held]
        essential.impose(state.p, t)
        if len(held):
            self._push(weight * self._V[held, None] * (state.p[held] - before), state.x[held])

    def accelerate(self, p_start: Array, state: State, dt: float) -> None:
        """What moves the constrained particles faster than ``p_start``, at the end of a step.

        Its work is that of the mean velocity of the step: the change of their kinetic energy,
        whatever the stages went through.
        """
        rhs, held = self._rhs, self._rhs.essential.particles
        if len(held):
            gained = rhs.essential.constrained(state.p[held] - p_start[held])
            rhs.reaction += gained / dt
            mean = 0.5 * (p_start[held] + state.p[held]) / rhs.material.density
            self.works[2] += np.sum(self._V[held, None] * gained * mean)

    def _react(self, impulse: Array, v: Array, x: Array) -> None:
        self.works[2] += np.sum(impulse * v)
        self._push(impulse, x)

    def _push(self, impulse: Array, x: Array) -> None:
        self.reaction += impulse
        self.constraint += _moments(impulse, x)
