"""One evaluation of the semi-discrete system (36) of [Lee2017], all passes in order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sphsolid.fields import tensor_field
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import Term, step_of
from sphsolid.scheme.tile import make_scratch
from sphsolid.scheme.time_step import STRETCH, take_stretches

Array = NDArray[np.float64]


class RightHandSide:
    """Rates of every evolved field at one stage.

    ``fields`` are those of the formulation and the terms.  After :meth:`evaluate` what was found is
    still there: ``stage`` with ``P (N, 3, 3)`` [Pa], the stress whose force was taken, and
    ``reaction (n, 3)`` [N/m^3], what the constraints added to the rate of ``p`` at the constrained
    particles.  ``P_galerkin (N, 3, 3)``, the stress before any term, is kept on demand.
    """

    def __init__(
        self, set_up: SetUp, terms: Sequence[Term], fields: Sequence[Field]
    ) -> None:
        self.set_up = set_up
        self.terms = tuple(terms)
        self.fields = tuple(fields)
        #: Names of what a time integrator advances, ``p`` first.
        self.evolved = tuple(field.name for field in fields if field.evolved)
        #: A term wants to know the step that the CFL rule allows.
        self.follows_step = any(term.follows_step for term in self.terms)
        # The others say that they have none, step after step.
        self._limiting = [
            term for term in self.terms
            if getattr(term.largest_step, "__func__", None) is not Term.largest_step
        ]  # fmt: skip
        self.material = set_up.material
        self.formulation = set_up.formulation
        self.operator = operator = set_up.operator
        self.loads, self.essential = set_up.loads, set_up.essential
        self.projects = set_up.projects
        #: ``grad v`` is taken even where no term of the step needs it.
        self.always_keeps_rates = any(name in self.evolved for name in "FHJ")
        self.rates = State(
            **{field.name: operator.zeros(field) for field in fields if field.name != "x"}
        )
        self.P = operator.zeros(Field("P", "tensor"))
        self.P_galerkin = self.P
        self.reaction = np.zeros((len(self.essential.particles), 3))
        self._scratch = make_scratch()
        #: Rates of the terms' own fields: nothing but the terms sets them.
        self._rates_of_terms = [
            self.rates[name] for name in self.evolved if name not in ("p", "F", "H", "J")
        ]
        wanted = self.projects and any(term.needs_projected_rate for term in terms)
        rate = Field("L_C", "tensor")
        self._projected_rate = operator.zeros(rate) if wanted else tensor_field(
            0, particle_major=self.P.base is not None and self.P.base.ndim == 3
        )

    def zeros(self) -> State:
        """A state of zeros."""
        return State(**{field.name: self.operator.zeros(field) for field in self.fields})

    def keep_galerkin_stress(self) -> None:
        """Keep the stress before any term adds to it, from now on."""
        if self.terms and self.P_galerkin is self.P:
            self.P_galerkin = self.operator.zeros(Field("P", "tensor"))

    def begin_step(self, units: Units) -> None:
        """Let every term take coefficients that belong to the state at the start of a step."""
        for term in self.terms:
            term.begin_step(units)

    @property
    def keeps_rates(self) -> bool:
        """True where the evaluations of this step take ``grad v``."""
        return self.always_keeps_rates or any(term.needs_rates for term in self.terms)

    def largest_step(self, state: State) -> float:
        """What the terms allow [s]; infinite where none has a limit of its own."""
        return min((step_of(term, state) for term in self._limiting), default=np.inf)

    def kinematic_gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor sum_b f_b (x) G_b(X_a)`` with the kinematic gradient."""
        self.operator.gradient(f, factor, out)

    def deformation_gradient(self, x: Array, out: Array) -> None:
        """``F = sum_b x_b (x) G_b(X_a)`` of positions ``x (N, 3)`` [m]."""
        self.operator.gradient(self.operator.arms(x), 1.0, out)

    def start(self, state: State) -> None:
        """Let every term fill its own fields at ``t = 0``; ``state.F`` is that of the start."""
        if STRETCH in state and len(state.F):
            take_stretches(state, self._scratch)
        for term in self.terms:
            term.start(state)

    def with_strains(self, state: State) -> State:
        """``state`` with every strain that it is evaluated with."""
        return state

    def of_geometry(self, state: State) -> State:
        """``state`` with the ``F`` of its ``x`` where the formulation does not evolve one.

        A stepper leaves there what it last had a use for.
        """
        if self.formulation.evolves_F:
            return state
        F = self.operator.zeros(Field("F", "tensor"))
        self.deformation_gradient(state.x, F)
        return state.but(F=F)

    def free_force(self, state: State) -> Array:
        """Force of the body itself ``(N, 3)`` [N/m^3] at free components, no load acting.

        For formulations in which every strain is that of the positions.
        """
        operator, rates = self.operator, self.rates
        self.stage = stage = Stage(
            state, state.x, operator.arms(state.x), 0.0, rates, self.P, self._projected_rate,
            projects=False, knows_F_x=operator.is_adjoint,
        )  # fmt: skip
        operator.gradient(stage.arms, 1.0, state.F)
        operator.rates_and_stress(
            self.material, stage, needs_rates=self.keeps_rates, knows_L=False
        )
        for term in self.terms:
            term.add_stress(stage)
        operator.internal_force(self.P, rates.p)
        self._add_rates(stage)
        self.essential.release(rates.p)
        return rates.p

    def evaluate(
        self,
        state: State,
        geometry: Array,
        t: float,
        *,
        knows_L: bool = False,
        derives_F: bool = False,
    ) -> State:
        """Rates of ``state`` at time ``t``; ``knows_L``: ``rates.F`` is that of ``state`` already.

        ``geometry (N, 3)`` [m] are the positions whose ``F_x = sum_b x_b (x) G_b`` the projection
        uses, with the gradient whose adjoint makes the force.  ``derives_F``: ``state.F`` is to be
        that of ``geometry``; where force and gradient are adjoint it needs no projection then.
        """
        operator, rates = self.operator, self.rates
        self.stage = stage = Stage(
            state, geometry, operator.arms(geometry), t, rates, self.P, self._projected_rate,
            self.projects, knows_F_x=derives_F and operator.is_adjoint,
        )  # fmt: skip
        compatible = stage.knows_F_x and not self._projected_rate.size
        if derives_F:
            operator.gradient(stage.arms, 1.0, state.F)
            if STRETCH in state:
                take_stretches(state, self._scratch)
        operator.rates_and_stress(
            self.material,
            replace(stage, projects=False) if compatible else stage,
            needs_rates=self.keeps_rates,
            knows_L=knows_L,
        )
        if self.P_galerkin is not self.P:
            self.P_galerkin[:] = self.P
        for term in self.terms:
            term.add_stress(stage)
        operator.internal_force(self.P, rates.p)
        if self.loads.any:
            rates.p += self.loads.at(t)[0]
        self._add_rates(stage)
        self.essential.reaction(rates.p, self.reaction)
        self.essential.release(rates.p)
        return rates

    def drift_and_kick(self, a: float, b: float, state: State, t: float) -> bool:
        """Move ``x`` by ``a`` [s], then ``p`` by ``b`` [s] with the force at time ``t``.

        False, and nothing is moved, where that takes more than one launch.  Nobody can be told then
        what the conditions did; prescribed velocities are left to the caller.
        """
        return False

    def _add_rates(self, stage: Stage) -> None:
        for rate in self._rates_of_terms:
            rate[...] = 0.0
        for term in self.terms:
            term.add_rates(stage)
