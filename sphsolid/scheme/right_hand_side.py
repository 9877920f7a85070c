"""One evaluation of the semi-discrete system (36) of [Lee2017], all passes in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud, Secondary
from sphsolid.cloud.pairs.pair_operator import PairOperator
from sphsolid.continuum import law
from sphsolid.fields import as_field, components, scalar_field, tensor_field, vector_field
from sphsolid.scheme import fine_scale, galerkin, pressure
from sphsolid.scheme.boundary import EssentialConditions, Loads
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.intrinsic_time import Times
from sphsolid.scheme.projection import AngularMomentumTreatment, LocalProjection
from sphsolid.scheme.stabilisation import (
    SUPG,
    FullHessian,
    SimplifiedHessian,
    Stabilisation,
    StabilisedStrains,
)
from sphsolid.scheme.tile import make_scratch

Array = NDArray[np.float64]


@dataclass
class State:
    """Evolved fields; those a formulation does not evolve have zero length.

    ``p (N, 3)`` [kg/(m^2 s)], ``x (N, 3)`` [m], ``F, H (N, 3, 3)``, ``J (N,)``.  ``F`` is always
    there: evolved, or taken from the geometry before each use.
    """

    p: Array
    x: Array
    F: Array
    H: Array
    J: Array

    @classmethod
    def zeros(cls, size: int, formulation: Formulation, *, particle_major: bool) -> State:
        """Zeros for ``size`` particles; ``particle_major`` says how tensors lie in memory."""
        return cls(
            p=vector_field(size),
            x=vector_field(size),
            F=tensor_field(size, particle_major=particle_major),
            H=tensor_field(size if formulation.evolves_H else 0, particle_major=particle_major),
            J=scalar_field(size if formulation.evolves_J else 0),
        )

    def rows(self) -> tuple[Array, Array, Array, Array]:
        """``p, F, H, J`` as a kernel wants them."""
        return tuple(  # type: ignore[return-value]
            components(as_field(field)) for field in (self.p, self.F, self.H, self.J)
        )

    def evolved(self, formulation: Formulation) -> list[Array]:
        """The arrays that a time integrator advances, ``x`` left out."""
        fields = [self.p]
        if formulation.evolves_F:
            fields.append(self.F)
        if formulation.evolves_H:
            fields.append(self.H)
        if formulation.evolves_J:
            fields.append(self.J)
        return fields


class RightHandSide:
    """Rates of every evolved field at one stage.

    After :meth:`evaluate` the terms are still there: ``P (N, 3, 3)`` the (projected) stress,
    ``P_fine (M, 3, 3)`` and ``flux (M, 3)`` at the secondary particles, ``reaction (n, 3)`` [N/m^3]
    what the constraints added to the rate of ``p`` at the constrained particles.

    ``times`` are the intrinsic times of the stabilisation [s], which whoever advances a state sets
    before a step: they belong to the state at its start, and to no step length.
    """

    def __init__(
        self,
        *,
        material: Any,
        cloud: Cloud,
        secondary: Secondary | None,
        formulation: Formulation,
        stabilisation: Stabilisation,
        angular_momentum: AngularMomentumTreatment,
        loads: Loads,
        essential: EssentialConditions,
    ) -> None:
        self.material = law.in_kernels(material)
        self.cloud = cloud
        self.secondary = secondary
        self.formulation = formulation
        self.stabilisation = stabilisation
        self.projects = isinstance(angular_momentum, LocalProjection)
        self.loads = loads
        self.essential = essential
        n, f = cloud.size, formulation
        #: ``grad v`` is taken even where no evolved field and no stabilisation needs it.
        self.keeps_rates = f.evolves_F or f.evolves_H or f.evolves_J or secondary is not None
        self.rates = State.zeros(n, f, particle_major=cloud.particle_major)
        self.P = tensor_field(n, particle_major=cloud.particle_major)
        self.reaction = np.zeros((len(essential.particles), 3))
        m = 0 if secondary is None else len(secondary.X)
        self.P_fine = tensor_field(m, particle_major=cloud.particle_major)
        self.times = Times()
        has_tau_p = isinstance(stabilisation, SUPG) and stabilisation.damps_J
        simplified = isinstance(stabilisation, SUPG) and isinstance(
            stabilisation.fine_scale, SimplifiedHessian
        )
        self._F_x_q = tensor_field(
            m if has_tau_p or not simplified else 0, particle_major=cloud.particle_major
        )
        self._inertia = vector_field(n if has_tau_p else 0)
        self.flux = vector_field(m if has_tau_p else 0)
        self.scratch = make_scratch()
        self._arms = vector_field(n)
        self._middle = cloud.middle
        supg = stabilisation if isinstance(stabilisation, SUPG) else None
        self.is_self_adjoint = supg is not None and supg.is_self_adjoint
        #: The rate of ``F`` that is interpolated to ``q``; without projection that is ``rates.F``.
        self._Fdot_C = tensor_field(
            n if self.is_self_adjoint and self.projects else 0,
            particle_major=cloud.particle_major,
        )

    def kinematic_gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor sum_b f_b (x) G_b(X_a)`` with the kinematic gradient."""
        self._gradient(self.cloud.kinematic, f, factor, out)

    def deformation_gradient(self, x: Array, out: Array) -> None:
        """``F = sum_b x_b (x) G_b(X_a)`` of positions ``x (N, 3)`` [m]."""
        self._gradient(self.cloud.kinematic, self._arms_of(x), 1.0, out)

    def _arms_of(self, x: Array) -> Array:
        """Positions from the middle of the body ``(N, 3)`` [m].

        ``sum_b G_b`` is zero to round-off, which positions far from the origin would multiply.
        """
        np.subtract(x, self._middle, out=self._arms)
        return self._arms

    def force_gradient(self, f: Array, factor: float, out: Array) -> None:
        """The same with the gradient whose adjoint makes the force."""
        self._gradient(self.cloud.force, f, factor, out)

    def secondary_gradient(self, f: Array) -> Array:
        """``sum_a f_a (x) G_a(X_q) (M, 3, 3)`` at the secondary particles, of which there are."""
        q = self.secondary
        assert q is not None
        out = tensor_field(len(q.X), particle_major=self.cloud.particle_major)
        self._gradient(q.sampling, f, 1.0, out)
        return out

    def _gradient(self, G: PairOperator, f: Array, factor: float, out: Array) -> None:
        result = as_field(out)
        galerkin.gradient(
            G, components(as_field(f)), factor, components(result), self.scratch
        )
        if result is not out:
            out[:] = result

    def evaluate(
        self, state: State, geometry: Array, t: float, *, knows_L: bool = False
    ) -> State:
        """Rates of ``state`` at time ``t``; ``knows_L``: ``rates.F`` is that of ``state`` already.

        ``geometry (N, 3)`` [m] are the positions whose ``F_x = sum_b x_b (x) G_b`` the projection
        uses, with the gradient whose adjoint makes the force.
        """
        f, cloud, rates = self.formulation, self.cloud, self.rates
        x = components(self._arms_of(geometry))
        p, F, H, J = state.rows()
        Fdot, P, pdot = components(rates.F), components(self.P), components(rates.p)
        galerkin.coarse(
            self.material, cloud.kinematic, cloud.force, cloud.is_adjoint, f.evolves_H, f.evolves_J,
            self.keeps_rates, knows_L, self.projects, len(self._Fdot_C) > 0, p, x, F, H, J, P, Fdot,
            components(rates.H), components(rates.J), components(self._Fdot_C), self.scratch,
        )  # fmt: skip
        if isinstance(self.stabilisation, SUPG):
            self._fine_stress(self.stabilisation, state, x)
        if self.is_self_adjoint:
            self.subtract_back(geometry, self.P)
        galerkin.internal_force(cloud.adjoint, P, pdot, self.scratch)
        if self.loads.any:
            rates.p += self.loads.at(t)[0]
        if isinstance(self.stabilisation, SUPG):
            self._dissipate(self.stabilisation, t)
        self.essential.reaction(rates.p, self.reaction)
        self.essential.release(rates.p)
        return rates

    def subtract_back(self, geometry: Array, P: Array) -> None:
        """``P_a -= B_a`` of the fine stress in :attr:`P_fine`: see ``SelfAdjoint``."""
        q = self.secondary
        assert q is not None
        fine_scale.subtract_back(
            q.spreading, self.cloud.force, self.projects, components(self._arms_of(geometry)),
            components(self.P_fine), components(P), self.scratch,
        )  # fmt: skip

    def _dissipate(self, supg: SUPG, t: float) -> None:
        q, rates, rho = self.secondary, self.rates, self.material.density
        assert q is not None
        if supg.damps_J:
            # R_p holds the Galerkin rate alone, so it is taken before D(p) is added.
            self._inertia[:] = rates.p
            self.essential.release(self._inertia)
            if self.loads.has_body_force:
                self._inertia -= self.loads.at(t)[1]
            flux = components(self.flux)
            pressure.momentum_residual(
                q.sampling, self.times.p / rho, components(self.P), components(self._inertia),
                components(self._F_x_q), flux, self.scratch,
            )  # fmt: skip
            pressure.volume_dissipation(q.spreading, flux, components(rates.J), self.scratch)
        fine_scale.momentum_dissipation(
            q.spreading, components(self.P_fine), components(rates.p), self.scratch
        )

    def _fine_stress(self, supg: SUPG, state: State, x: Array) -> None:
        q, rates, f = self.secondary, self.rates, self.formulation
        assert q is not None
        form = supg.fine_scale
        tau = self.times.F
        p, F, H, J = state.rows()
        Fdot, P_fine, F_x = components(rates.F), components(self.P_fine), components(self._F_x_q)
        if isinstance(form, SimplifiedHessian):
            gamma, alpha = form.moduli(self.material)
            if len(self._Fdot_C):
                Fdot = components(self._Fdot_C)
            fine_scale.simplified(
                q.sampling, self.material.density, tau * gamma, supg.xi_F * alpha, self.projects,
                supg.damps_J, p, x, F, Fdot, P_fine, F_x, self.scratch,
            )  # fmt: skip
            return
        taus = np.array([tau, self.times.H, self.times.J])
        alpha = self.material.mu
        if isinstance(form, StabilisedStrains):
            xis = np.array([supg.xi_F, form.xi_H, form.xi_J])
        else:
            assert isinstance(form, FullHessian)
            xis = np.array([supg.xi_F, 0.0, 0.0])
            alpha = alpha if form.alpha is None else form.alpha
        fine_scale.general(
            q.sampling, self.material, isinstance(form, StabilisedStrains), taus, xis, alpha,
            self.projects, f.evolves_H, f.evolves_J, p, x, F, H, J, Fdot, components(rates.H),
            components(rates.J), P_fine, F_x, self.scratch,
        )  # fmt: skip
