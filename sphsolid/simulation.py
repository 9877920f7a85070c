"""A scene, a cloud and a scheme wired together; no formula lives here."""

from __future__ import annotations

import copy
import math
import time as clock
from collections.abc import Callable, Sequence
from typing import Any
from typing import Literal as OneOf

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Secondary, consistency_report
from sphsolid.cloud.operator import OperatorKind
from sphsolid.cloud.smoothing import SmoothingFunction
from sphsolid.continuum import law
from sphsolid.continuum.tensor import determinant, split
from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.defaults import default_initial_strain, is_displacement_form, is_restrained
from sphsolid.describe import plan, summary
from sphsolid.errors import Diverged, require
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.options import Options, choose, discretised
from sphsolid.record.checkpoint import checkpoint_of, put_back
from sphsolid.record.placement import Placement
from sphsolid.record.snapshot import Snapshot
from sphsolid.run.base import BaseSimulation
from sphsolid.run.running_budget import NotOpened, Works
from sphsolid.run.team import by_team, step_by_team
from sphsolid.scenes.scene import Scene
from sphsolid.scenes.stated_deformation import refuse_contradiction
from sphsolid.scheme.boundary import EssentialConditions, Loads
from sphsolid.scheme.dilatation import Dilatation
from sphsolid.scheme.elastic_response import displacement_frequency, highest_frequency
from sphsolid.scheme.energy_budget import StageBudget
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.initial_state import initial_state
from sphsolid.scheme.initial_strain import Compatible, InitialStrain
from sphsolid.scheme.integrator import Integrator, stepper_of
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.lattice_form import LatticeRightHandSide, has_lattice_form
from sphsolid.scheme.lattice_operator import operator_on
from sphsolid.scheme.projection import AngularMomentumTreatment
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stabilisation import Stabilisation
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import TermOption, terms_of
from sphsolid.scheme.time_step import STRETCH, TimeStep
from sphsolid.sph_snapshot import secondary_gradient, snapshot_of

Array = NDArray[np.float64]
#: Steps between two looks at the positions: one takes about as long as a step.
LOOK_EVERY = 50


class Simulation(BaseSimulation):
    """SUPG-stabilised mixed total-Lagrangian SPH of one scene.

    ``spacing`` [m] of the particles, where the body does not bring its own; options are
    objects, ``terms`` those beside the stabilisation.  Everything is checked before the first
    step: wrong pairs, a support that is too small, NaN in the initial data raise ``InputError``.
    Where nothing is given, ``sphsolid.defaults`` chooses and ``plan()`` says what.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        spacing: Spacing = AS_MESHED,
        formulation: Formulation | None = None,
        stabilisation: Stabilisation | None = None,
        dilatation: Dilatation | None = None,
        terms: Sequence[TermOption] = (),
        operator: OperatorKind | None = None,
        smoothing: SmoothingFunction | None = None,
        h_over_dx: float | None = None,
        cfl: float | OneOf["auto"] | None = None,
        angular_momentum: AngularMomentumTreatment | None = None,
        initial_strain: InitialStrain | None = None,
        integrator: Integrator | None = None,
    ) -> None:
        started = clock.perf_counter()
        options = Options(
            spacing, formulation, stabilisation, dilatation, terms, operator, smoothing, h_over_dx,
            cfl, angular_momentum, initial_strain, integrator,
        )  # fmt: skip
        method = choose(scene, options)
        super().__init__(scene, method.material, options.given, look_every=LOOK_EVERY)
        #: Options that were left to ``sphsolid.defaults``.
        self.by_default = options.by_default
        self.integrator, self.formulation = method.integrator, method.formulation
        self.advice, self.angular_momentum = method.advice, method.angular_momentum
        self.stabilisation, self.dilatation = method.stabilisation, method.dilatation
        self.terms = method.terms
        self.particles = particles = discretised(method, options)
        self.cloud, self.operator = particles.cloud, particles.operator
        self.h_over_dx = particles.h_over_dx
        self.refused, self.doubts = particles.refused, particles.doubts
        self.consistency = consistency_report(self.cloud, scene.body.volume)
        self.cloud.tables.forget()
        self._take_points(self.cloud.mesh, self.cloud.V)
        self._set_up = self._made_set_up()
        self._rhs = self._right_hand_side()
        self._rhs.loads.at(0.0)
        self.initial_strain = self._chosen_strain(initial_strain)
        self._state = initial_state(scene, self._rhs, self.initial_strain)
        #: The stable step [s] of the state as it is; nan where nobody has asked for it yet.
        self._allowed = math.nan
        self._stepper = stepper_of(
            self.integrator, self._rhs, self._state, self._rhs.essential
        )
        self._time_step = TimeStep(
            cfl=method.cfl,
            h_min=self._shortest_length(),
            wave_speed=reference_p_wave_speed(self.material),
            size=self.cloud.size,
        )
        self.setup_seconds = clock.perf_counter() - started

    # ------------------------------------------------------------------ building
    def _made_set_up(self) -> SetUp:
        return SetUp(
            material=law.in_kernels(self.material),
            cloud=self.cloud,
            operator=operator_on(self.cloud),
            formulation=self.formulation,
            projects=self.angular_momentum.projects,
            loads=Loads(self.scene, self.cloud),
            essential=EssentialConditions(self.scene, self.cloud),
        )

    def _right_hand_side(self) -> RightHandSide:
        # The dilatation last: it sees what the others do to J.
        options = (self.stabilisation, *self.terms, self.dilatation)
        fields = [*self.formulation.fields, *(f for option in options for f in option.fields)]
        names = [field.name for field in fields]
        require(len(names) == len({*names}), f"two fields have one name: {', '.join(names)}")
        terms = terms_of(options, self._set_up)
        if is_displacement_form(self.formulation) and getattr(self.integrator, "derives_F", False):
            # F is then of the last evaluation, and so is the stretch that the step is taken from:
            # who looks at the state, and brings F up to date with it, must not change the step.
            fields.append(Field(STRETCH, evolved=False))
        lean = has_lattice_form(self._set_up, terms, self.integrator)
        return (LatticeRightHandSide if lean else RightHandSide)(self._set_up, terms, fields)

    def _chosen_strain(self, asked: InitialStrain | None) -> InitialStrain:
        stated, adjoint = self.scene.states_deformation, self.cloud.is_adjoint
        if asked is not None:
            asked.check(stated=stated, evolves_F=self.formulation.evolves_F, adjoint=adjoint)
            return asked
        chosen: InitialStrain = Compatible()
        if stated:
            chosen = default_initial_strain(self.operator, self.formulation, adjoint=adjoint)
        if not chosen.uses_stated:
            # Whoever asks for Compatible() knows that the stated F is left out.
            refuse_contradiction(self.scene, self.cloud.X)
        return chosen

    def _shortest_length(self) -> float:
        """What a CFL number counts [m]: the least distance of particles, or less off a lattice.

        A lattice's highest frequency is ``2 c_p / h_min``; that of particles with very uneven
        volumes and distances can be nearly twice as high.  That of an operator with a quadrature of
        its own, such as differences of order four, is higher too.  Of the displacement form with a
        restraint it is ``2 c_p / omega`` with the highest frequency that there is.
        """
        resolved = 2.0 * reference_p_wave_speed(self.material)
        if is_restrained(self.formulation, (self.stabilisation, *self.terms)):
            omega = displacement_frequency(self._rhs, self._state)
            return resolved / omega if omega > 0.0 else self.cloud.h_min
        if self.cloud.mesh.is_lattice and not hasattr(self.operator, "layout"):
            return self.cloud.h_min
        omega = highest_frequency(self._rhs)
        return resolved / omega if omega * self.cloud.h_min > resolved else self.cloud.h_min

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        """A branch of the run: a state of its own on the same particles."""
        branch = object.__new__(type(self))
        memo[id(self)] = branch
        vars(branch).update(vars(self))
        # Functions with a memory have one each.
        branch.scene = copy.deepcopy(self.scene, memo)
        branch._time_step = copy.deepcopy(self._time_step, memo)
        branch._set_up = self._set_up.again(branch._made_set_up())
        branch._rhs = rhs = branch._right_hand_side()
        branch._state = rhs.zeros()
        branch._stepper = stepper_of(self.integrator, rhs, branch._state, rhs.essential)
        branch._budget = NotOpened()
        branch.positions = copy.copy(self.positions)
        branch._running_since = None
        put_back(branch, checkpoint_of(self), "the copy")
        return branch

    # ------------------------------------------------------------------ what it is
    @property
    def name(self) -> str:
        """Scene, formulation, stabilisation, terms and operator, fit for file names."""
        formulation = self.formulation.name.strip("{}").replace(",", "")
        parts = [self.scene.name, formulation, self.stabilisation.name]
        parts += [*(term.name for term in self.terms), self.operator.name]
        return "-".join(parts).replace(" ", "_")

    @property
    def secondary(self) -> Secondary | None:
        """The secondary particles of the first term that has some."""
        return next((t.secondary for t in self._rhs.terms if t.secondary is not None), None)

    @property
    def state(self) -> State:
        """The evolved fields themselves, not copies, and an ``F`` that is not evolved."""
        # Who takes them may change them, and with them the step that is allowed.
        self._allowed = math.nan
        if not self.formulation.evolves_F and len(self._state.F):
            self._rhs.deformation_gradient(self._state.x, self._state.F)
        return self._state

    def _options(self) -> dict[str, Any]:
        names = (
            "formulation", "stabilisation", "dilatation", "terms", "operator", "h_over_dx",
            "angular_momentum", "initial_strain", "integrator",
        )  # fmt: skip
        options = {name: getattr(self, name) for name in names}
        cfl, smoothing = self._time_step.cfl, self.cloud.smoothing
        return {"method": "SPH"} | options | {"smoothing": smoothing, "cfl": cfl}

    # ------------------------------------------------------------------ a step
    @by_team
    def stable_time_step(self) -> float:
        """Largest step allowed now [s]; raises ``Diverged`` when the state is invalid.

        Where the volume of the law stiffens with compression (``law.stiffening``), the step is
        that much shorter; no term is given more than its own limit.
        """
        s, material = self._state, self.material
        try:
            allowed = self._time_step.stable(s, self.cloud.X, self.time, self.step)
        except Diverged:
            # Stretches of the last evaluation found it: say where it is lost now.
            self.check_state()
            raise
        if not law.is_quadratic(material):
            # An F that is not evolved is that of the last evaluation, or of now where somebody
            # looked: who looks must not change the step.
            F = s.F if self.formulation.evolves_F else self._rhs.of_geometry(s).F
            J = s.J if self.formulation.evolves_J else determinant(split(F))
            allowed /= float(np.max(law.stiffening(material, J)))
        self._allowed = min(allowed, self._rhs.largest_step(s))
        return self._allowed

    def check_state(self) -> None:
        """Raise ``Diverged`` when the state now is no solution any more."""
        now = {name: f for name, f in self._rhs.of_geometry(self._state).items() if name != STRETCH}
        self._time_step.stable(State(**now), self.cloud.X, self.time, self.step)

    @step_by_team
    def advance(self, dt: float) -> None:
        """One step of ``dt`` [s]; intrinsic times of the step are shares of the stable one."""
        if self._rhs.follows_step and math.isnan(self._allowed):
            self.stable_time_step()
        self._rhs.begin_step(Units(self._time_step.crossing, self._allowed, self.step))
        self._allowed = math.nan
        self._stepper.advance(dt, self.time)
        self.time += dt
        self.step += 1
        self._budget.step(self._momentum)

    def state_changed(self) -> None:
        """Forget the step that was allowed before."""
        self._allowed = math.nan

    def _fields(self) -> dict[str, Array]:
        return dict(self.state)

    def _motion(self) -> tuple[Array, Array]:
        return self._state.x, self._state.p / self.material.density

    # ------------------------------------------------------------------ the budget
    def _open_works(self) -> tuple[Works, Callable[[Array], dict[str, Array]]]:
        works = self._stepper.budget = StageBudget(self._rhs)
        return works, self._rhs.essential.by_face

    def _reaction(self) -> Array:
        return self._rhs.reaction

    def _reaction_force(self) -> Array:
        return self.cloud.V[self._rhs.essential.particles, None] * self._rhs.reaction

    # ------------------------------------------------------------------ what it hands out
    def snapshot(self) -> Snapshot:
        """Copies of the state now, with the constitutive stress ``P(F, H, J)``."""
        return snapshot_of(
            self._state, self._rhs, self.material, self._shown_mesh, time=self.time,
            step=self.step, budget=self._budget.now(self._reaction_force),
        )  # fmt: skip

    def placement(self) -> Placement:
        """Where the particles are now, and the gradient of it at the secondary ones."""
        x = self.state.x
        return Placement(self.time, self.cloud.mesh, x, secondary_gradient(self._rhs, x))

    def plan(self) -> str:
        """What is active and why, before anything runs."""
        return plan(self)

    def summary(self) -> str:
        """How far the run is and what it cost."""
        return summary(self)
