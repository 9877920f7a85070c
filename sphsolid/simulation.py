"""A scene, a cloud and a scheme wired together; no formula lives here."""

from __future__ import annotations

import copy
import math
import time as clock
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from typing import Literal as OneOf

import numpy as np

from sphsolid.cloud.cloud import build_secondary, consistency_report
from sphsolid.cloud.first_possible import first_possible
from sphsolid.cloud.long_cells import doubts
from sphsolid.cloud.operator import Consistent, Literal, OperatorKind, SummationByParts
from sphsolid.cloud.secondary import default_secondary
from sphsolid.cloud.smoothing import SmoothingFunction, WendlandC2
from sphsolid.continuum import law
from sphsolid.continuum.check_law import check_first_use
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.defaults import (
    Integrator,
    default_cfl,
    default_initial_strain,
    default_integrator,
    default_stabilisation,
    largest_stable_cfl,
    operator_candidates,
)
from sphsolid.describe import memory_bytes, plan, summary
from sphsolid.errors import InputError
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.geometry.mesh import protected, read_only
from sphsolid.recommendation import recommend
from sphsolid.record.balance import Balance, MomentumWatch, NotTracked, total_momentum
from sphsolid.record.checkpoint import (
    ACCOUNT,
    checkpoint_of,
    common_identity,
    put_back,
    rebuilt,
    restore,
)
from sphsolid.record.history import History
from sphsolid.record.march import march
from sphsolid.record.output import NO_OUTPUT, Output
from sphsolid.record.placement import (
    NO_SECONDARY_GRADIENT,
    NoSecondaryGradient,
    Placement,
    SecondaryGradient,
)
from sphsolid.record.plain import plain
from sphsolid.record.positions import PositionWatch
from sphsolid.record.probes import check_probes
from sphsolid.record.progress import Progress
from sphsolid.record.recorders import Recorder
from sphsolid.record.samples import Sampler, Samples
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.vtu import write_vtu
from sphsolid.scenes.checks import as_float, number
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scenes.stated_deformation import refuse_contradiction
from sphsolid.scheme.boundary import EssentialConditions, Loads
from sphsolid.scheme.elastic_response import highest_frequency
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.initial_state import initial_state
from sphsolid.scheme.initial_strain import Compatible, Equilibrated, Given, InitialStrain
from sphsolid.scheme.intrinsic_time import Times, Units
from sphsolid.scheme.position_verlet import PositionVerlet
from sphsolid.scheme.power import TERMS, Account
from sphsolid.scheme.projection import (
    AngularMomentumTreatment,
    LocalProjection,
    NoProjection,
)
from sphsolid.scheme.right_hand_side import RightHandSide, State
from sphsolid.scheme.ssp_rk3 import SSPRK3
from sphsolid.scheme.stabilisation import SUPG, Stabilisation, check_formulation, check_pair
from sphsolid.scheme.time_step import TimeStep, check_cfl
from sphsolid.scheme.tvd_rk2 import TVDRK2

#: Steps between two looks at the positions: one takes about as long as a step.
LOOK_EVERY = 50


def _known(name: str, option: object, *kinds: type) -> None:
    if option is not None and not isinstance(option, kinds):
        allowed = ", ".join(f"{kind.__name__}()" for kind in kinds)
        raise InputError(f"{name} = {option!r} is not an option object; use one of {allowed}")


class Simulation:
    """SUPG-stabilised mixed total-Lagrangian SPH of one scene.

    ``spacing`` [m] of the particles, where the body does not bring its own; options are
    objects.  Everything is checked before the first
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
        operator: OperatorKind | None = None,
        smoothing: SmoothingFunction | None = None,
        h_over_dx: float | None = None,
        cfl: float | OneOf["auto"] | None = None,
        angular_momentum: AngularMomentumTreatment | None = None,
        initial_strain: InitialStrain | None = None,
        integrator: Integrator | None = None,
    ) -> None:
        started = clock.perf_counter()
        check_scene(scene)
        spacing, h_over_dx, cfl = as_float(spacing), as_float(h_over_dx), as_float(cfl)
        given = {
            "stabilisation": stabilisation, "h_over_dx": h_over_dx, "integrator": integrator,
            "cfl": cfl, "formulation": formulation, "operator": operator, "smoothing": smoothing,
        }  # fmt: skip
        self._arguments: dict[str, Any] = given | {
            "spacing": spacing, "angular_momentum": angular_momentum,
            "initial_strain": initial_strain,
        }  # fmt: skip
        for name, value in self._arguments.items():
            if isinstance(value, type):
                raise InputError(f"{name} = {value.__name__} is a class; write {value.__name__}()")
        if h_over_dx is not None:
            number("h_over_dx", h_over_dx, "spacings")
        #: Options that were left to ``sphsolid.defaults``.
        self.by_default = tuple(name for name, value in given.items() if value is None)
        self.scene = scene
        #: The law and its parameters as they are now; what is done to its text later is not seen.
        self.material = check_first_use(scene.material)
        _known("integrator", integrator, TVDRK2, SSPRK3, PositionVerlet)
        self.integrator: Integrator = default_integrator() if integrator is None else integrator
        self.advice = recommend(scene)
        self.formulation = self.advice.formulation if formulation is None else formulation
        check_formulation(self.formulation)
        if cfl == "auto":
            cfl = largest_stable_cfl(self.integrator, self.formulation, self.material)
        cfl = default_cfl(self.integrator) if cfl is None else cfl
        if isinstance(cfl, bool):
            raise InputError(f"cfl = {cfl} is not a number; 0.3 is the paper's value")
        check_cfl(cfl)
        if stabilisation is not None:
            check_pair(self.formulation, stabilisation)
        mesh = scene.body.mesh(spacing)
        check_probes(scene, mesh)
        if stabilisation is None:
            stabilisation = default_stabilisation(
                self.formulation, self.material, secondary=default_secondary(mesh)
            )
            check_pair(self.formulation, stabilisation)
        self.stabilisation: Stabilisation = stabilisation
        if smoothing is not None and not hasattr(smoothing, "slope"):
            raise InputError(
                f"smoothing = {smoothing!r} is not a smoothing function; use one of WendlandC2(), "
                "CubicSpline(), QuinticSpline()"
            )
        _known("operator", operator, Literal, Consistent, SummationByParts)
        _known("angular_momentum", angular_momentum, LocalProjection, NoProjection)
        _known("initial_strain", initial_strain, Compatible, Given, Equilibrated)
        self.angular_momentum = (
            LocalProjection() if angular_momentum is None else angular_momentum
        )
        found = first_possible(
            mesh,
            WendlandC2() if smoothing is None else smoothing,
            operator_candidates(mesh, operator, h_over_dx),
        )
        self.cloud = found.cloud
        self.operator: OperatorKind = found.candidate.operator
        self.h_over_dx = found.candidate.h_over_dx
        #: Operators that the default tried before this one, and why each was refused.
        self.refused = found.refused
        #: What makes the operators doubtful on this mesh.
        self.doubts = tuple(doubts(self.cloud))
        if self.doubts:
            warnings.warn("; ".join(self.doubts), stacklevel=2)
        self.secondary = (
            build_secondary(
                self.cloud,
                self.stabilisation.secondary,
                adjoint_weight=self.stabilisation.is_self_adjoint,
            )
            if isinstance(self.stabilisation, SUPG)
            else None
        )
        self.consistency = consistency_report(self.cloud, scene.body.volume)

        self._sampler = Sampler(scene, self.cloud.mesh)
        # One object for all snapshots, so that what is made for it can be kept.
        self._shown_mesh = protected(self.cloud.mesh)
        self._rhs = self._right_hand_side()
        self._rhs.loads.at(0.0)
        self.initial_strain = self._chosen_strain(initial_strain)
        if isinstance(self.initial_strain, Compatible) and initial_strain is None:
            # Whoever asks for Compatible() knows that the stated F is left out.
            refuse_contradiction(scene, self.cloud.X)
        self._state = initial_state(scene, self._rhs, self.initial_strain)
        #: The stable step [s] of the state as it is; nan where nobody has asked for it yet.
        self._allowed = math.nan
        self._stepper = self.integrator.stepper(self._rhs, self._state, self._rhs.essential)
        self._time_step = TimeStep(
            cfl=cfl,
            h_min=self._shortest_length(),
            wave_speed=reference_p_wave_speed(self.material),
            size=self.cloud.size,
        )
        self._watch = MomentumWatch(np.zeros((2, 3)))
        self._start_energy = np.zeros(())
        #: What was seen of the positions: see ``record.positions``.
        self.positions = PositionWatch(every=LOOK_EVERY)
        self.time = 0.0
        self.step = 0
        self.setup_seconds = clock.perf_counter() - started
        self._seconds_before = 0.0
        self._running_since: float | None = None

    def _right_hand_side(self) -> RightHandSide:
        return RightHandSide(
            material=self.material,
            cloud=self.cloud,
            secondary=self.secondary,
            formulation=self.formulation,
            stabilisation=self.stabilisation,
            angular_momentum=self.angular_momentum,
            loads=Loads(self.scene, self.cloud),
            essential=EssentialConditions(self.scene, self.cloud),
        )

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        """A branch of the run: a state of its own on the same particles."""
        branch = object.__new__(type(self))
        memo[id(self)] = branch
        vars(branch).update(vars(self))
        # Functions with a memory have one each.
        branch.scene = copy.deepcopy(self.scene, memo)
        branch._time_step = copy.deepcopy(self._time_step, memo)
        branch._rhs = rhs = branch._right_hand_side()
        major = self.cloud.particle_major
        branch._state = State.zeros(self.cloud.size, self.formulation, particle_major=major)
        branch._stepper = self.integrator.stepper(rhs, branch._state, rhs.essential)
        branch._allowed = math.nan
        branch.positions = copy.copy(self.positions)
        branch._running_since = None
        put_back(branch, checkpoint_of(self), "the copy")
        return branch

    def __copy__(self) -> Simulation:
        """As a deep copy: two simulations of one state would each move the other's."""
        return copy.deepcopy(self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Set up again where it is unpickled, and put into the state of now, bit for bit."""
        return rebuilt, (type(self), self.scene, self._arguments, checkpoint_of(self))

    @property
    def run_seconds(self) -> float:
        """Seconds spent in ``run``, those before a restart included."""
        since = self._running_since
        return self._seconds_before + (0.0 if since is None else clock.perf_counter() - since)

    @property
    def name(self) -> str:
        """Scene, formulation, stabilisation and operator in a file-name friendly form."""
        formulation = self.formulation.name.strip("{}").replace(",", "")
        return (
            f"{self.scene.name}-{formulation}-{self.stabilisation.name}-{self.operator.name}"
        ).replace(" ", "_")

    def _chosen_strain(self, asked: InitialStrain | None) -> InitialStrain:
        stated = self.scene.states_deformation
        if isinstance(asked, Given) and not (stated and self.formulation.evolves_F):
            raise InputError(
                "initial_strain = Given() needs a scene that states its "
                "initial_deformation_gradient and a formulation that evolves F; "
                "use Compatible()"
            )
        if isinstance(asked, Equilibrated) and not (stated and self.cloud.is_adjoint):
            raise InputError(
                "initial_strain = Equilibrated() needs a scene that states its "
                "initial_deformation_gradient and an operator whose force and gradient are "
                "adjoint; use Compatible()"
            )
        if asked is not None:
            return asked
        if not stated:
            return Compatible()
        return default_initial_strain(
            self.operator, self.formulation, adjoint=self.cloud.is_adjoint
        )

    def _shortest_length(self) -> float:
        """What a CFL number counts [m]: the least distance of particles, or less off a lattice.

        A lattice's highest frequency is ``2 c_p / h_min``; that of particles with very uneven
        volumes and distances can be nearly twice as high.
        """
        if self.cloud.mesh.is_lattice:
            return self.cloud.h_min
        omega = highest_frequency(self._rhs)
        resolved = 2.0 * reference_p_wave_speed(self.material)
        return resolved / omega if omega * self.cloud.h_min > resolved else self.cloud.h_min

    @property
    def state(self) -> State:
        """The evolved fields themselves, not copies."""
        # Who takes them may change them, and with them the step that is allowed.
        self._allowed = math.nan
        return self._state

    def stable_time_step(self) -> float:
        """Largest step allowed now [s]; raises ``Diverged`` when the state is invalid.

        Where the volume of the law stiffens with compression (``law.stiffening``), the step is
        that much shorter.
        """
        s, material = self._state, self.material
        allowed = self._time_step.stable(
            self.formulation.evolves_J, s, self.cloud.X, self.time, self.step, self._rhs.scratch
        )
        if not law.is_quadratic(material):
            J = s.J if self.formulation.evolves_J else determinant(split(s.F))
            allowed /= float(np.max(law.stiffening(material, J)))
        self._allowed = allowed
        return allowed

    def advance(self, dt: float) -> None:
        """One step of ``dt`` [s]; intrinsic times of the step are shares of the stable one."""
        self._rhs.times = self._times()
        self._allowed = math.nan
        self._stepper.advance(dt, self.time)
        self.time += dt
        self.step += 1
        account = self._stepper.account
        if isinstance(account, Account):
            self._watch.step(self._momentum(), account.impulse)

    def _times(self) -> Times:
        supg = self.stabilisation
        if not isinstance(supg, SUPG):
            return Times()
        if supg.follows_step and math.isnan(self._allowed):
            self.stable_time_step()
        return supg.seconds(Units(self._time_step.crossing, self._allowed))

    def track_balance(self) -> None:
        """Account for energy and momentum from now on: about a third more time a step."""
        if isinstance(self._stepper.account, Account):
            return
        self._stepper.account = Account(self._rhs)
        self._watch = MomentumWatch(self._momentum())
        start = self.snapshot()
        self._start_energy = np.array(start.kinetic_energy + start.strain_energy)

    def _momentum(self) -> np.ndarray:
        s, density = self._state, self.material.density
        return total_momentum(self.cloud.V, density, s.x, s.p / density)

    def _balance(self) -> Balance | NotTracked:
        account = self._stepper.account
        if not isinstance(account, Account):
            return NotTracked()
        essential = self._rhs.essential
        force = self.cloud.V[essential.particles, None] * self._rhs.reaction
        return Balance(
            start_energy=float(self._start_energy),
            works=dict(zip(TERMS, account.works.tolist(), strict=True)),
            start_momentum=self._watch.start,
            momentum=self._watch.now,
            impulse=account.impulse,
            traction_impulse=account.traction.copy(),
            largest_step_drift=self._watch.largest_step_drift,
            reaction_impulse=essential.by_face(account.reaction),
            reaction_force=essential.by_face(force),
        )

    def run(
        self,
        *,
        until: float | None = None,
        every: float | None = None,
        record: Sequence[Recorder] = (),
        progress: Callable[[Progress], None] | None = None,
        output: Output = NO_OUTPUT,
    ) -> History:
        """Advance to ``until`` [s] and record every ``every`` [s]; see ``record.march``."""
        self._running_since = clock.perf_counter()
        try:
            return march(
                self, until=until, every=every, record=record, progress=progress, output=output
            )
        finally:
            self._seconds_before = self.run_seconds
            self._running_since = None

    def save(self, path: str | Path) -> None:
        """Write the state now as a ``.vtu`` file; see ``record.write_vtu``."""
        write_vtu(self.snapshot(), path)

    def restore(self, path: str | Path) -> None:
        """Take over, bit for bit, a checkpoint that an equal simulation wrote."""
        restore(self, path)

    def identity(self) -> dict[str, str]:
        """What a checkpoint must agree on with the simulation that takes it over."""
        options = {
            name: plain(getattr(self, name))
            for name in (
                "formulation", "stabilisation", "operator", "h_over_dx", "angular_momentum",
                "initial_strain", "integrator",
            )
        }  # fmt: skip
        options |= {"smoothing": plain(self.cloud.smoothing), "cfl": plain(self._time_step.cfl)}
        common = common_identity(self.scene, self.material, self.cloud.mesh, self.cloud.V)
        return common | {"method": "SPH"} | options

    def samples(self, times: Sequence[float]) -> Samples:
        """What the scene's functions say at ``times`` [s], by which a checkpoint knows them."""
        return self._sampler.at(times)

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self.run_seconds}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._seconds_before = totals["run_seconds"]

    def state_arrays(self) -> dict[str, Any]:
        """The arrays that hold the state, and the account where one is kept."""
        arrays = dict(vars(self.state))
        account = self._stepper.account
        if isinstance(account, Account):
            totals = account.arrays() | self._watch.arrays() | {"energy": self._start_energy}
            totals["reaction_now"] = self._rhs.reaction
            arrays |= {f"{ACCOUNT}{name}": value for name, value in totals.items()}
        return arrays

    def state_changed(self) -> None:
        """Forget the step that was allowed before."""
        self._allowed = math.nan

    def snapshot(self) -> Snapshot:
        """Copies of the state now, with the constitutive stress ``P(F, H, J)``."""
        s, f, material = self._state, self.formulation, self.material
        F = split(s.F)
        H = split(s.H) if f.evolves_H else cofactor(F)
        J = s.J if f.evolves_J else determinant(F)
        density = law.stored_energy(material, F, H, J)
        X, V = read_only(self.cloud.X), read_only(self.cloud.V)
        return Snapshot(
            time=self.time,
            step=self.step,
            material=material,
            mesh=self._shown_mesh,
            X=X,
            V=V,
            x=s.x.copy(),
            velocity=s.p / material.density,
            stress_X=X,
            stress_V=V,
            F=s.F.copy(),
            J=np.array(J, copy=True),
            P=join(law.first_piola(material, F, H, J)),
            strain_energy=float(np.sum(self.cloud.V * density)),
            balance=self._balance(),
            secondary=self._secondary_gradient(),
        )

    def placement(self) -> Placement:
        """Where the particles are now, and the gradient of it at the secondary ones."""
        return Placement(self.time, self.cloud.mesh, self.state.x, self._secondary_gradient())

    def _secondary_gradient(self) -> SecondaryGradient | NoSecondaryGradient:
        if self.secondary is None:
            return NO_SECONDARY_GRADIENT
        return SecondaryGradient(self.secondary.X, self._rhs.secondary_gradient(self.state.x))

    def plan(self) -> str:
        """What is active and why, before anything runs."""
        return plan(self)

    def memory_bytes(self) -> int:
        """Bytes of all arrays that live during a run."""
        return memory_bytes(self)

    def summary(self) -> str:
        """How far the run is and what it cost."""
        return summary(self)
