"""One evaluation of the semi-discrete system (36) of [Lee2017], all passes in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud, Secondary
from sphsolid.scheme import fine_scale, galerkin, pressure
from sphsolid.scheme.boundary import EssentialConditions, Loads
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.projection import AngularMomentumTreatment, LocalProjection
from sphsolid.scheme.stabilisation import (
    SUPG,
    FullHessian,
    SimplifiedHessian,
    Stabilisation,
    StabilisedStrains,
)

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
        self.material = material
        self.cloud = cloud
        self.secondary = secondary
        self.formulation = formulation
        self.stabilisation = stabilisation
        self.projects = isinstance(angular_momentum, LocalProjection)
        self.loads = loads
        self.essential = essential
        n, f = cloud.size, formulation
        self.rates = State(
            p=np.zeros((n, 3)),
            x=np.zeros((0, 3)),
            F=np.zeros((n, 3, 3)),
            H=np.zeros((n if f.evolves_H else 0, 3, 3)),
            J=np.zeros(n if f.evolves_J else 0),
        )
        self.P = np.zeros((n, 3, 3))
        self.reaction = np.zeros((len(essential.particles), 3))
        self.F_x = np.zeros((n, 3, 3))
        m = 0 if secondary is None else len(secondary.X)
        self._S = np.zeros((n if m else 0, 3, 3))
        self._v = np.zeros((n if m else 0, 3))
        self.P_fine = np.zeros((m, 3, 3))
        self._F_x_q = np.zeros((m, 3, 3))
        has_tau_p = isinstance(stabilisation, SUPG) and stabilisation.tau_p > 0.0
        self._inertia = np.zeros((n if has_tau_p else 0, 3))
        self.flux = np.zeros((m if has_tau_p else 0, 3))

    def set_geometry(self, x: Array) -> None:
        """Take ``F_x = sum_b x_b (x) G_b`` with the gradient whose adjoint makes the force.

        Angular momentum is exact when stage one projects with ``F_x(x^n)`` and stage two with
        ``F_x(x^{n+1})``; the second is the first of the next step, so one pass a step is enough.
        """
        if self.projects:
            pairs = self.cloud.pairs
            galerkin.gradient(
                pairs.indptr, pairs.indices, self.cloud.gradients.force, x, 1.0, self.F_x
            )

    def kinematic_gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor sum_b f_b (x) G_b(X_a)`` with the kinematic gradient."""
        pairs = self.cloud.pairs
        galerkin.gradient(
            pairs.indptr, pairs.indices, self.cloud.gradients.kinematic, f, factor, out
        )

    def evaluate(self, state: State, geometry: Array, dt: float, t: float) -> State:
        """Rates of ``state`` at time ``t``.

        ``geometry (N, 3)`` [m] are the positions that ``F_x`` uses; the caller has called
        :meth:`set_geometry` with them.
        """
        f, material, pairs = self.formulation, self.material, self.cloud.pairs
        rates = self.rates
        self.kinematic_gradient(state.p, 1.0 / material.density, rates.F)
        if f.evolves_H or f.evolves_J:
            galerkin.strain_rates(
                f.evolves_H, f.evolves_J, rates.F, state.F, state.H, rates.H, rates.J
            )
        galerkin.stress(
            material, f.evolves_H, f.evolves_J, self.projects,
            state.F, state.H, state.J, self.F_x, self.P,
        )  # fmt: skip
        galerkin.internal_force(
            pairs.indptr, pairs.indices, self.cloud.divergence, self.P, rates.p
        )
        if self.loads.any:
            rates.p += self.loads.at(t)[0]
        if isinstance(self.stabilisation, SUPG):
            self._stabilise(self.stabilisation, state, geometry, dt, t)
        self.essential.reaction(rates.p, self.reaction)
        self.essential.release(rates.p)
        return rates

    def _stabilise(
        self, supg: SUPG, state: State, geometry: Array, dt: float, t: float
    ) -> None:
        q, rates, rho = self.secondary, self.rates, self.material.density
        assert q is not None
        np.multiply(state.p, 1.0 / rho, out=self._v)
        self._fine_stress(supg, state, geometry, dt)
        if supg.tau_p > 0.0:
            # R_p holds the Galerkin rate alone, so it is taken before D(p) is added.
            self._inertia[:] = rates.p
            self.essential.release(self._inertia)
            if self.loads.has_body_force:
                self._inertia -= self.loads.at(t)[1]
            pressure.momentum_residual(
                q.pairs.indptr, q.pairs.indices, q.sample, supg.tau_p * dt / rho,
                self.P, self._inertia, self._F_x_q, self.flux,
            )  # fmt: skip
            pressure.volume_dissipation(
                q.spread_pairs.indptr, q.spread_pairs.indices, q.spread, self.flux, rates.J
            )
        fine_scale.momentum_dissipation(
            q.spread_pairs.indptr, q.spread_pairs.indices, q.spread, self.P_fine, rates.p
        )

    def _fine_stress(self, supg: SUPG, state: State, geometry: Array, dt: float) -> None:
        q, rates, f = self.secondary, self.rates, self.formulation
        assert q is not None
        form = supg.fine_scale
        tau = supg.tau_F * dt
        if isinstance(form, SimplifiedHessian):
            gamma, alpha = form.moduli(self.material)
            galerkin.combine(tau * gamma, supg.xi_F * alpha, rates.F, state.F, self._S)
            fine_scale.simplified(
                q.pairs.indptr, q.pairs.indices, q.sample, tau * gamma, supg.xi_F * alpha,
                self.projects, self._v, geometry, self._S, self.P_fine, self._F_x_q,
            )  # fmt: skip
            return
        taus = np.array([supg.tau_F, form.tau_H, form.tau_J]) * dt
        alpha = self.material.mu
        if isinstance(form, StabilisedStrains):
            xis = np.array([supg.xi_F, form.xi_H, form.xi_J])
        else:
            assert isinstance(form, FullHessian)
            xis = np.array([supg.xi_F, 0.0, 0.0])
            alpha = alpha if form.alpha is None else form.alpha
        fine_scale.general(
            q.pairs.indptr, q.pairs.indices, q.sample, self.material,
            isinstance(form, StabilisedStrains), taus, xis, alpha, self.projects,
            f.evolves_H, f.evolves_J, self._v, geometry, state.F, state.H, state.J,
            rates.F, rates.H, rates.J, self.P_fine, self._F_x_q,
        )  # fmt: skip
