"""The displacement form on a box lattice, evaluated along its lines (see ``lattice_force``).

The state is ``p`` and ``x``, and of the strain each particle's smallest stretch, from which the
stable step is taken: no ``F``, ``grad v`` or rate of a strain is stored.  The forces are those of
the general evaluation to round-off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.box import BoxLattice, box_of
from sphsolid.cloud.lattice.lines import grid_of, planes
from sphsolid.cloud.lattice_difference import LatticeDifference, has_lines
from sphsolid.fields import components, tensor_field
from sphsolid.scheme import lattice_force, lattice_step
from sphsolid.scheme.filtered_dilatation import FilteredDilatationTerm
from sphsolid.scheme.formulation import Displacement
from sphsolid.scheme.integrator import Integrator
from sphsolid.scheme.lattice_arguments import packed
from sphsolid.scheme.restraint_lines import LineRestraint
from sphsolid.scheme.restraint_term import RestraintParts
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import Term
from sphsolid.scheme.time_step import STRETCH

Array = NDArray[np.float64]
_FREE = RestraintParts(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def has_lattice_form(set_up: SetUp, terms: Sequence[Term], integrator: Integrator) -> bool:
    """True for the displacement form with a lattice difference and no terms but those it knows.

    The integrator must leave it to the evaluation to take ``F``.
    """
    return (
        has_lines(set_up.cloud.kind)
        and box_of(set_up.cloud.mesh).is_ordered  # type: ignore[union-attr]
        and isinstance(set_up.formulation, Displacement)
        and getattr(integrator, "derives_F", False)
        and all(isinstance(term, LineRestraint | FilteredDilatationTerm) for term in terms)
        # One pass takes one of each; the general evaluation adds up any number.
        and len({type(term) for term in terms}) == len(terms)
    )


class LatticeRightHandSide(RightHandSide):
    """The rate of ``p``, and each particle's smallest stretch into the state."""

    def __init__(
        self, set_up: SetUp, terms: Sequence[Term], fields: Sequence[Field]
    ) -> None:
        kept = [field for field in fields if field.name != "F"]
        super().__init__(set_up, terms, kept)
        cloud, kind = set_up.cloud, set_up.cloud.kind
        box = box_of(cloud.mesh)
        assert isinstance(box, BoxLattice)
        assert isinstance(kind, LatticeDifference)
        self._restraint: LineRestraint | None = None
        smoothing, self._rest = 0, 0.0
        for term in terms:
            if isinstance(term, LineRestraint):
                self._restraint = term
            elif isinstance(term, FilteredDilatationTerm):
                smoothing, self._rest = term.options.order, term.stiffness
        self._grid = grid_of(kind.order, box, smoothing=smoothing)
        self._planes = planes(self._grid, smoothing)
        self._work = lattice_force.make_work(
            self._grid, workers=numba.config.NUMBA_NUM_THREADS, filtered=smoothing > 0,
            restrained=self._restraint is not None, beta=self._rest > 0.0,
        )  # fmt: skip
        self._middle, self._lines = cloud.middle, packed(self._grid)
        self._known: tuple[State | None, tuple[Any, ...]] = (None, ())
        # No stress is kept, nor a gradient.
        self.P = self.P_galerkin = tensor_field(0, particle_major=cloud.particle_major)
        self._F = tensor_field(0, particle_major=cloud.particle_major)
        self.has_budget = False

    def keep_galerkin_stress(self) -> None:
        """For a budget: ``F`` and its law's stress, that of an evaluation, from now on."""
        if not self.has_budget:
            tensor = Field("P", "tensor")
            self._F, self.P_galerkin = self.operator.zeros(tensor), self.operator.zeros(tensor)
            self.rates = State(**self.rates, F=self.operator.zeros(tensor))
            self.has_budget = True

    def with_strains(self, state: State) -> State:
        """``state`` with the ``F`` of the last evaluation, which a budget asks for."""
        return state.but(F=self._F)

    def start(self, state: State) -> None:
        """The smallest stretches of the first positions."""
        super().start(state)
        self._sum(self._rows(state, self.operator.arms(state.x)))

    def free_force(self, state: State) -> Array:
        """Force of the body itself ``(N, 3)`` [N/m^3] at free components, no load acting."""
        self._sum(self._rows(state, self.operator.arms(state.x)))
        self.essential.release(self.rates.p)
        return self.rates.p

    def evaluate(
        self, state: State, geometry: Array, t: float, *, knows_L: bool = False,
        derives_F: bool = False,
    ) -> State:  # fmt: skip
        """The rate of ``p`` of ``state`` at time ``t``, whose positions are ``geometry``."""
        rates, rows = self.rates, self._known_rows(state)
        arms = self.operator.arms(geometry)
        self.stage = Stage(
            state, geometry, arms, t, rates, self.P, self._projected_rate, False, True
        )
        self._sum(rows)
        if self.loads.any:
            rates.p += self.loads.at(t)[0]
        if self.has_budget:
            self._keep(state, arms)
        self.essential.reaction(rates.p, self.reaction)
        self.essential.release(rates.p)
        return rates

    def drift_and_kick(self, a: float, b: float, state: State, t: float) -> bool:
        """In one launch, unless somebody keeps a budget."""
        if self.has_budget:
            return False
        load = np.ascontiguousarray(self.loads.at(t)[0]) if self.loads.any else lattice_step.NO_LOAD
        essential, rows = self.essential, self._known_rows(state)
        lattice_step.drift_and_kick(
            a / self.material.density, b, self._middle, load, essential.particles, essential.free,
            self._lines, self._planes, self.material, self._rest, self._parts, *rows,
        )  # fmt: skip
        return True

    def _known_rows(self, state: State) -> tuple[Any, ...]:
        if self._known[0] is not state:
            # A state keeps its arrays; of a small body, finding their memory is most of a step.
            self._known = state, self._rows(state, self.operator.arms(state.x))
        return self._known[1]

    def _rows(self, state: State, arms: Array) -> tuple[Any, ...]:
        rows = components(state.p), self._work, components(state[STRETCH])[0]
        return components(state.x), components(arms), *rows, components(self.rates.p)

    @property
    def _parts(self) -> RestraintParts:
        return _FREE if self._restraint is None else self._restraint.acting

    def _sum(self, rows: tuple[Any, ...]) -> None:
        lattice_step.forces(
            self._lines, self._planes, self.material, self._rest, self._parts, *rows[1:]
        )

    def _keep(self, state: State, arms: Array) -> None:
        """What the powers of an evaluation are taken from."""
        operator = self.operator
        operator.gradient(arms, 1.0, self._F)
        operator.gradient(state.p, 1.0 / self.material.density, self.rates.F)
        self.stage = stage = replace(self.stage, state=self.with_strains(state))
        lattice_force.law_alone(self.material, components(self._F), components(self.P_galerkin))
        for term in self.terms:
            if isinstance(term, LineRestraint):
                term.measured(stage)
