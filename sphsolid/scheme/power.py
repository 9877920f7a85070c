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

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant, load
from sphsolid.fields import components, scalar_field, tensor_field, vector_field
from sphsolid.scheme import fine_scale, galerkin, pressure
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.right_hand_side import RightHandSide, State
from sphsolid.scheme.stabilisation import SUPG

Array = NDArray[np.float64]
#: Order of the works in :attr:`Account.works`.
TERMS = (
    "traction", "body_force", "constraint", "projection", "adjoint_defect",
    "dissipation_p", "dissipation_J",
)  # fmt: skip


@kernel
def _stress_powers(  # type: ignore[no-untyped-def]
    material, has_H, has_J, V, L_k, L_f, P_C, F, H, J, D_J, out
):
    """Columns of ``out (N, 3)`` [W]: projection, adjoint defect, ``D(J)``."""
    for a in prange(len(V)):
        F_a = load(F, a)
        H_a = load(H, a) if has_H else cofactor(F_a)
        J_a = J[a] if has_J else determinant(F_a)
        P_a = law.first_piola(material, F_a, H_a, J_a)
        L_f_a = load(L_f, a)
        out[a, 0] = -V[a] * contract(axpy(-1.0, P_a, load(P_C, a)), L_f_a)
        out[a, 1] = V[a] * contract(P_a, axpy(-1.0, L_f_a, load(L_k, a)))
        out[a, 2] = 0.0
        if has_J:
            out[a, 2] = V[a] * law.conjugate_stresses(material, F_a, H_a, J_a)[2] * D_J[a]


def _moments(impulse: Array, x: Array) -> Array:
    return np.stack([impulse.sum(axis=0), np.cross(x, impulse).sum(axis=0)])


@dataclass(frozen=True)
class NoAccount:
    """Nobody asked where energy and momentum go: the stages are not looked at."""

    def stage(self, state: State, geometry: Array, dt: float, t: float) -> None:
        """Nothing."""

    def impose(
        self, essential: EssentialConditions, state: State, t: float, weight: float
    ) -> None:
        """Impose the essential conditions, nothing else."""
        essential.impose(state.p, t)


class Account:
    """Work [J] of every term and impulses, integrated with the integrator's own stages.

    ``works (7,)`` in the order of :data:`TERMS`; ``traction, body_force, constraint (2, 3)`` hold
    the linear [N s] and the angular impulse [N m s] about the origin; ``reaction (n, 3)`` [N s]
    the impulse on each constrained particle.
    """

    def __init__(self, rhs: RightHandSide) -> None:
        self._rhs = rhs
        n = rhs.cloud.size
        self.works = np.zeros(len(TERMS))
        self.traction = np.zeros((2, 3))
        self.body_force = np.zeros((2, 3))
        self.constraint = np.zeros((2, 3))
        self.reaction = np.zeros((len(rhs.essential.particles), 3))
        self._powers = np.zeros((n, 3))
        rhs.keeps_rates = True
        self._D_p = vector_field(n)
        extra = n if rhs.is_self_adjoint else 0
        self._force = vector_field(extra)
        self._minus_B = tensor_field(extra, particle_major=rhs.cloud.particle_major)
        self._D_J = scalar_field(n if rhs.formulation.evolves_J else 0)
        self._L_f = (
            rhs.rates.F
            if rhs.cloud.is_adjoint
            else tensor_field(n, particle_major=rhs.cloud.particle_major)
        )

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
        rhs, cloud = self._rhs, self._rhs.cloud
        v = state.p / rhs.material.density
        self._dissipation()
        P = rhs.P
        if rhs.is_self_adjoint:
            # The stress that made the force holds -B, whose work belongs to D(p).
            self._minus_B[:] = 0.0
            rhs.subtract_back(geometry, self._minus_B)
            galerkin.internal_force(
                cloud.adjoint, components(self._minus_B), components(self._force), rhs.scratch
            )
            self._D_p += self._force
            P = rhs.P - self._minus_B
        if not cloud.is_adjoint:
            rhs.force_gradient(v, 1.0, self._L_f)
        f = rhs.formulation
        _stress_powers(
            rhs.material, f.evolves_H, f.evolves_J, cloud.V, rhs.rates.F, self._L_f, P,
            state.F, state.H, state.J, self._D_J, self._powers,
        )  # fmt: skip
        self.works[3:5] += dt * np.sum(self._powers[:, :2], axis=0)
        self.works[5] += dt * np.sum(cloud.V[:, None] * v * self._D_p)
        self.works[6] += dt * np.sum(self._powers[:, 2])
        if rhs.loads.any:
            total, body = rhs.loads.at(t)
            for k, (load_, impulse) in enumerate(
                ((total - body, self.traction), (body, self.body_force))
            ):
                force = dt * cloud.V[:, None] * load_
                self.works[k] += np.sum(v * force)
                impulse += _moments(force, geometry)
        held = rhs.essential.particles
        if len(held):
            self._react(dt * cloud.V[held, None] * rhs.reaction, v[held], geometry[held])

    def impose(
        self, essential: EssentialConditions, state: State, t: float, weight: float
    ) -> None:
        """Impose the essential conditions; ``weight`` of the jump of ``p`` ends in the step."""
        held = essential.particles
        before = state.p[held]
        essential.impose(state.p, t)
        if len(held):
            p = state.p[held]
            jump = weight * self._rhs.cloud.V[held, None] * (p - before)
            self._react(jump, p / self._rhs.material.density, state.x[held])

    def _react(self, impulse: Array, v: Array, x: Array) -> None:
        self.works[2] += np.sum(impulse * v)
        self.reaction += impulse
        self.constraint += _moments(impulse, x)

    def _dissipation(self) -> None:
        # Evaluated again from the fine-scale stress and flux, not taken as what is left over.
        rhs, q = self._rhs, self._rhs.secondary
        if q is None or not isinstance(rhs.stabilisation, SUPG):
            return
        self._D_p[:] = 0.0
        fine_scale.momentum_dissipation(
            q.spreading, components(rhs.P_fine), components(self._D_p), rhs.scratch
        )
        if rhs.stabilisation.damps_J:
            self._D_J[:] = 0.0
            pressure.volume_dissipation(
                q.spreading, components(rhs.flux), components(self._D_J), rhs.scratch
            )
