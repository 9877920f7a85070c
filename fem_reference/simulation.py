"""Wiring of the finite element reference: scene in, snapshots out; no formula."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference.account import Account, NoAccount
from fem_reference.b_bar_hex import BBarHex
from fem_reference.central_difference import central_difference_step
from fem_reference.element import Element
from fem_reference.essential import EssentialConditions
from fem_reference.loads import loads_of, nodal_force
from fem_reference.mesh import scikit_fem_mesh
from fem_reference.updates import divide_by_mass
from sphsolid.compiled import threads
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.continuum.check_law import check_first_use
from sphsolid.errors import Diverged, InputError, require
from sphsolid.geometry.body import AS_MESHED, AsMeshed, Spacing
from sphsolid.geometry.mesh import hexahedra, protected, read_only
from sphsolid.record import History, Output, Progress, Snapshot, march, restore, write_vtu
from sphsolid.record.balance import Balance, MomentumWatch, NotTracked, total_momentum
from sphsolid.record.checkpoint import ACCOUNT, checkpoint_of, common_identity, rebuilt
from sphsolid.record.output import NO_OUTPUT
from sphsolid.record.placement import Placement
from sphsolid.record.plain import plain
from sphsolid.record.positions import PositionWatch
from sphsolid.record.probes import check_probes
from sphsolid.record.recorders import Recorder
from sphsolid.record.samples import Sampler, Samples
from sphsolid.scenes.checks import as_float, number
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scenes.stated_deformation import NOT_USED, refuse_contradiction

Array = NDArray[np.float64]


#: Options are immutable objects, so one default serves every simulation.
DEFAULT_ELEMENT = BBarHex()


#: Steps between two looks at the positions: one takes as long as two or three steps.
LOOK_EVERY = 200


class Simulation:
    """Explicit finite elements on ``scene``, with the surface of ``sphsolid.Simulation``.

    Unknowns are the nodal positions ``x (N, 3)`` [m] and velocities ``(N, 3)`` [m/s]; lumped mass;
    central differences.  The constructor raises ``InputError`` for a wrong
    ``spacing``, ``cfl``, ``element``, tag, load or initial state.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        spacing: Spacing = AS_MESHED,
        element: Element = DEFAULT_ELEMENT,
        cfl: float = 0.6,
    ) -> None:
        """``spacing`` [m] nominal, of nodes, unless the body has its own; ``cfl`` fraction of the
        stable step, in (0, 1].
        """
        check_scene(scene)
        asked = as_float(cfl)
        require(
            isinstance(asked, float) and 0.0 < asked <= 1.0,
            f"cfl = {cfl!r} is outside (0, 1]; central differences are stable to about 0.85, use "
            "0.6",
        )
        if isinstance(element, type) or not hasattr(element, "discretise"):
            raise InputError(
                f"element = {element!r} is no element technology; use BBarHex() or TaylorHoodHex()"
            )
        #: The law and its parameters as they are now; what is done to its text later is not seen.
        self.material = check_first_use(scene.material)
        self.scene = scene
        self.element = element
        self.cfl: float = asked
        #: What was seen of the positions: see ``sphsolid.record.positions``.
        self.positions = PositionWatch(every=LOOK_EVERY)
        self.time = 0.0
        self.step = 0
        if not isinstance(spacing, AsMeshed):
            spacing = number("spacing", spacing, "m")
        edge = spacing if isinstance(spacing, AsMeshed) else element.cell_size(spacing)
        self._arguments = {"spacing": spacing, "element": element, "cfl": cfl}
        mesh = hexahedra(scene.body.mesh(edge), f"element = {element.name}")
        check_probes(scene, mesh)
        sk = scikit_fem_mesh(mesh)
        self._elements = element.discretise(mesh=mesh, sk=sk, material=self.material)
        self._mesh = self._elements.mesh
        self._loads = loads_of(scene, sk, self._elements.load_shapes)
        self._essential = EssentialConditions.of(scene.constraints, self._mesh)
        self._sampler = Sampler(scene, self._mesh)
        # One object for all snapshots, so that what is made for it can be kept.
        self._shown_mesh = protected(self._mesh)
        self._V = self._elements.nodal_volumes
        self._mass = (self.material.density * self._V)[:, None]
        self._wave_speed = reference_p_wave_speed(self.material)
        self._wall_time = 0.0
        self._smallest_dt = math.inf
        self._account: Account | NoAccount = NoAccount()
        self._watch = MomentumWatch(np.zeros((2, 3)))
        self._reaction_force = np.zeros((len(self._essential.nodes), 3))
        self._start_energy = np.zeros(())

        refuse_contradiction(scene, self._mesh.vertices)
        displacement, velocity = scene.initial_state(self._mesh.vertices)
        self._x = self._mesh.vertices + displacement
        self._v = velocity.copy()
        self._essential.apply(self._v, 0.0)
        self._a = np.empty_like(self._x)
        self._accelerate(self._x, 0.0, self._a)
        folded = self._elements.invalid_element()
        require(
            folded < 0,
            f"scene {scene.name!r}: the initial displacement turns element {folded} inside out "
            "(J <= 0); reduce its amplitude or refine the mesh",
        )

    @property
    def name(self) -> str:
        """``<scene>_fem_<element>``, for file names."""
        return f"{self.scene.name}_fem_{self.element.name}"

    @property
    def elements(self) -> int:
        """Number of elements; the cells of a snapshot's mesh are eight for each of a quadratic."""
        return self._elements.count

    def stable_time_step(self) -> float:
        """``cfl * min_e (L_e lambda_e / max(1, Jbar_e)) / c_p`` [s].

        ``L_e`` belongs to the undeformed element: for ``BBarHex`` the smallest stretch of its
        reference map (the edge of a cube), for ``TaylorHoodHex`` a measured share of the distance
        of its nodes.  ``lambda_e`` is the smallest principal stretch at its Gauss points now,
        ``Jbar_e`` its mean (largest) dilatation, ``c_p`` the p-wave speed of the undeformed solid:
        waves in the reference body travel at most about ``c_p max(1, J) / lambda``.  A law whose
        volume stiffens, ``U''(J) > kappa``, has ``J sqrt(U'' / kappa)`` for ``J``.  The limit
        ``2 / omega_max`` of central differences lies between 0.85 (free, nearly incompressible
        B-bar cubes) and 3 (distorted elements) times this at ``cfl = 1``.  Raises ``Diverged``
        when the state is invalid.
        """
        self._check()
        return self.cfl * self._elements.smallest_length() / self._wave_speed

    def advance(self, dt: float) -> None:
        """One central-difference step of ``dt`` [s]; raises ``Diverged`` when ``J <= 0`` or nan."""
        start = time.perf_counter()
        central_difference_step(
            self._x,
            self._v,
            self._a,
            t=self.time,
            dt=dt,
            accelerate=self._accelerate,
            essential=self._essential,
            account=self._account,
        )
        self._wall_time += time.perf_counter() - start
        if isinstance(self._account, Account):
            # Each half step imposes once: twice the impulse over dt is the mean force.
            self._reaction_force = 2.0 / dt * self._account.last_reaction
            self._watch.step(self._momentum(), self._account.impulse)
        self.time += dt
        self.step += 1
        self._smallest_dt = min(self._smallest_dt, dt)
        self._check()

    def snapshot(self) -> Snapshot:
        """State now: nodes with lumped volumes, stresses at the centres of the mesh's cells."""
        stress = self._elements.stress(self._x)
        X, V = read_only(self._mesh.vertices), read_only(self._V)
        return Snapshot(
            time=self.time,
            step=self.step,
            material=self.material,
            mesh=self._shown_mesh,
            X=X,
            V=V,
            x=self._x.copy(),
            velocity=self._v.copy(),
            stress_X=X[self._mesh.cells].mean(axis=1),
            stress_V=read_only(self._elements.volumes),
            F=stress.F,
            J=stress.J,
            P=stress.P,
            strain_energy=self._elements.strain_energy(self._x),
            balance=self._balance(),
        )

    def placement(self) -> Placement:
        """Where the nodes are now."""
        return Placement(self.time, self._mesh, self._x)

    def track_balance(self) -> None:
        """Account for energy and momentum from now on."""
        if isinstance(self._account, Account):
            return
        self._account = Account(self._loads, self._mass, self._essential)
        self._watch = MomentumWatch(self._momentum())
        start = self.snapshot()
        self._start_energy = np.array(start.kinetic_energy + start.strain_energy)

    def _momentum(self) -> Array:
        return total_momentum(self._V, self.material.density, self._x, self._v)

    def _balance(self) -> Balance | NotTracked:
        account = self._account
        if not isinstance(account, Account):
            return NotTracked()
        return Balance(
            start_energy=float(self._start_energy),
            works={name: float(work) for name, work in account.works.items()},
            start_momentum=self._watch.start,
            momentum=self._watch.now,
            impulse=account.impulse,
            traction_impulse=account.impulses["traction"].copy(),
            largest_step_drift=self._watch.largest_step_drift,
            reaction_impulse=self._essential.by_face(account.reaction),
            reaction_force=self._essential.by_face(self._reaction_force),
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
        """Advance to ``until`` [s] recording every ``every`` [s]; see ``sphsolid.record.march``."""
        return march(
            self, until=until, every=every, record=record, progress=progress, output=output
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Set up again where it is copied or unpickled, and put into the state of now."""
        return rebuilt, (type(self), self.scene, self._arguments, checkpoint_of(self))

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        """Set up again with the law as it was here, and put into the state of now."""
        scene = copy.deepcopy(replace(self.scene, material=self.material), memo)
        return rebuilt(type(self), scene, self._arguments, checkpoint_of(self))

    def __copy__(self) -> Simulation:
        """As a deep copy: two simulations of one state would each move the other's."""
        return copy.deepcopy(self)

    def save(self, path: str | Path) -> None:
        """Write the state now as a ``.vtu`` file; see ``record.write_vtu``."""
        write_vtu(self.snapshot(), path)

    def restore(self, path: str | Path) -> None:
        """Take over, bit for bit, a checkpoint that an equal simulation wrote."""
        restore(self, path)

    def identity(self) -> dict[str, str]:
        """What a checkpoint must agree on with the simulation that takes it over."""
        options = {"method": "FEM", "element": plain(self.element), "cfl": plain(self.cfl)}
        return common_identity(self.scene, self.material, self._mesh, self._V) | options

    def samples(self, times: Sequence[float]) -> Samples:
        """What the scene's functions say at ``times`` [s], by which a checkpoint knows them."""
        return self._sampler.at(times)

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self._wall_time, "smallest_dt": self._smallest_dt}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._wall_time = totals["run_seconds"]
        self._smallest_dt = totals["smallest_dt"]

    def state_arrays(self) -> dict[str, Array]:
        """The arrays that hold the state, and the account where one is kept."""
        arrays = {"x": self._x, "v": self._v, "a": self._a}
        if isinstance(self._account, Account):
            totals = self._account.arrays() | self._watch.arrays() | {"energy": self._start_energy}
            totals["reaction_now"] = self._reaction_force
            arrays |= {f"{ACCOUNT}{name}": value for name, value in totals.items()}
        return arrays

    def state_changed(self) -> None:
        """Bring what is derived from the state up to date: the elements' Jacobians."""
        self._elements.internal_force(self._x, np.empty_like(self._x))

    def plan(self) -> str:
        """What is active and what it will cost, in words."""
        dt = self.stable_time_step()
        remaining = max(0.0, self.scene.end_time - self.time)
        loads = ", ".join(load.what for load in self._loads) or "none (no load vector is formed)"
        moving = len(self._essential.driven)
        return "\n".join(
            (
                f"{self.name}: explicit finite elements",
                f"  elements     {self._elements.description()}",
                f"  nodes        {len(self._x)}, lumped mass",
                f"  time         central differences, cfl {self.cfl:g}, dt {dt:.4g} s now, "
                f"{math.ceil(remaining / dt)} steps to {self.scene.end_time:.4g} s at that, more "
                "as elements are compressed",
                f"  essential    {len(self._essential.nodes)} constrained nodes, "
                f"{moving} constraints with a prescribed motion",
                f"  loads        {loads}",
                *([f"  initial F    {NOT_USED}"] if self.scene.states_deformation else []),
                f"  memory       {self._nbytes() / 2**20:.1f} MiB of arrays",
                f"  threads      {threads()}",
            )
        )

    def summary(self) -> str:
        """What was done: steps, time steps, speed; whether the positions are sound."""
        elements = self._elements.count
        positions = self.positions.line(self.placement())
        done = f"{self.name}: t = {self.time:.6g} s after {self.step} steps"
        if self.step == 0:
            return f"{done}; {elements} elements, {len(self._x)} nodes\n{positions}"
        speed = 1.0e9 * self._wall_time / (self.step * elements)
        return (
            f"{done}; {elements} elements, {len(self._x)} nodes, smallest dt "
            f"{self._smallest_dt:.4g} s, {self._wall_time:.3g} s in steps = {speed:.0f} ns per "
            f"element-step on {threads()} threads\n{positions}"
        )

    def _accelerate(self, x: Array, t: float, acceleration: Array) -> None:
        self._elements.internal_force(x, acceleration)
        if self._loads:
            acceleration -= nodal_force(self._loads, t, len(x))
        divide_by_mass(self._mass, acceleration)

    def _check(self) -> None:
        element = self._elements.invalid_element()
        if element < 0:
            return
        X = self._elements.centre(element)
        raise Diverged(
            reason=f"element {element} is inside out, not finite or flattened",
            time=self.time,
            step=self.step,
            particle=element,
            position=(float(X[0]), float(X[1]), float(X[2])),
            advice=f"a cfl below {self.cfl:g}, a finer mesh, or a smaller load",
        )

    def _nbytes(self) -> int:
        state = 3 * self._x.nbytes + 2 * self._V.nbytes + self._mesh.vertices.nbytes
        loads = sum(load.matrix.data.nbytes + load.matrix.indices.nbytes for load in self._loads)
        return state + self._elements.nbytes + self._essential.nbytes + loads
