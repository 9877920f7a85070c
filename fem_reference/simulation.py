"""Wiring of the finite element reference: scene in, snapshots out; no formula."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex, MeshTet

from fem_reference.b_bar_hex import BBarHex
from fem_reference.cell_tables import Hexahedra
from fem_reference.central_difference import Motion, central_difference_step
from fem_reference.element import (
    Element,
    check_element,
    check_elements,
    refuse_unwritten_force,
    volumetric_energy,
)
from fem_reference.energy_budget import NoBudget, StepBudget
from fem_reference.essential import EssentialConditions
from fem_reference.loads import loads_of, nodal_force
from fem_reference.updates import divide_by_mass
from sphsolid.compiled import threads
from sphsolid.continuum import law, reference_p_wave_speed
from sphsolid.continuum.check_law import check_first_use
from sphsolid.errors import Diverged, InputError, require
from sphsolid.geometry.body import AS_MESHED, AsMeshed, Spacing
from sphsolid.geometry.mesh import Mesh, read_only
from sphsolid.record import Snapshot
from sphsolid.record.checkpoint import checkpoint_of, rebuilt
from sphsolid.record.placement import Placement
from sphsolid.record.probes import check_probes
from sphsolid.run.base import BaseSimulation
from sphsolid.run.running_budget import Works
from sphsolid.run.team import by_team, step_by_team
from sphsolid.scenes.checks import as_float, number
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scenes.stated_deformation import NOT_USED, refuse_contradiction

Array = NDArray[np.float64]


#: Options are immutable objects, so one default serves every simulation.
DEFAULT_ELEMENT = BBarHex()
HEXAHEDRA = Hexahedra()


#: Steps between two looks at the positions: one takes as long as two or three steps.
LOOK_EVERY = 200


class Simulation(BaseSimulation):
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
        check_element(element)
        if not isinstance(spacing, AsMeshed):
            spacing = number("spacing", spacing, "m")
        super().__init__(
            scene,
            check_first_use(scene.material),
            {"spacing": spacing, "element": element, "cfl": cfl},
            look_every=LOOK_EVERY,
        )
        self.element = element
        self.cfl: float = asked
        self._wall_time = 0.0
        self._smallest_dt = math.inf
        self._works: StepBudget | NoBudget = NoBudget()
        edge = spacing if isinstance(spacing, AsMeshed) else element.cell_size(spacing)
        # An element that does not say so has hexahedra.
        kind = getattr(element, "cells", HEXAHEDRA)
        require(
            hasattr(kind, "meshes"),
            f"element {element.name}: cells = {kind!r} are none; use Hexahedra() or Tetrahedra()",
        )
        mesh, sk = kind.meshes(scene.body.mesh(edge), f"element = {element.name}")
        check_probes(scene, mesh)
        self._discretise(mesh, sk)
        self._start()

    def _discretise(self, mesh: Mesh, sk: MeshHex | MeshTet) -> None:
        """Elements, loads and constraints on ``mesh``."""
        self._elements = self.element.discretise(mesh=mesh, sk=sk, material=self.material)
        check_elements(self.element.name, self._elements)
        self._take_points(self._elements.mesh, self._elements.nodal_volumes)
        self._loads = loads_of(self.scene, sk, self._elements.load_shapes)
        self._essential = EssentialConditions.of(self.scene.constraints, self._elements.mesh)
        self._mass = (self.material.density * self._volumes)[:, None]
        self._wave_speed = reference_p_wave_speed(self.material)
        self._constraint_force = np.zeros((len(self._essential.nodes), 3))

    def _start(self) -> None:
        """Nodal motion at ``t = 0``."""
        scene, X = self.scene, self._points.vertices
        refuse_contradiction(scene, X)
        displacement, velocity = scene.initial_state(X)
        self._motion_now = Motion(X + displacement, velocity.copy(), np.empty_like(X))
        self._essential.apply(self._motion_now.v, 0.0)
        refuse_unwritten_force(self.element.name, self._elements, self._motion_now.x)
        self._accelerate(self._motion_now.x, 0.0, self._motion_now.a)
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

    @by_team
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
        length = self._elements.smallest_length()
        if not 0.0 < length < math.inf:
            raise InputError(
                f"element {self.element.name}: smallest_length() returned {length!r}; wanted is a "
                "finite length above 0 m"
            )
        return self.cfl * length / self._wave_speed

    @step_by_team
    def advance(self, dt: float) -> None:
        """One central-difference step of ``dt`` [s]; raises ``Diverged`` when ``J <= 0`` or nan."""
        start = time.perf_counter()
        central_difference_step(
            self._motion_now,
            t=self.time,
            dt=dt,
            accelerate=self._accelerate,
            essential=self._essential,
            budget=self._works,
        )
        self._wall_time += time.perf_counter() - start
        # Each half step imposes once: twice the impulse over dt is the mean force.
        self._constraint_force = self._works.mean_reaction(dt, self._constraint_force)
        self._budget.step(self._momentum)
        self.time += dt
        self.step += 1
        self._smallest_dt = min(self._smallest_dt, dt)
        self._check()

    def snapshot(self) -> Snapshot:
        """State now: nodes with lumped volumes, stresses at the centres of the mesh's cells."""
        x, v = self._motion()
        stress, mesh = self._elements.stress(x), self._points
        X, V = read_only(mesh.vertices), read_only(self._volumes)
        at_centres = float(
            np.sum(self._elements.volumes * law.volumetric_energy(self.material, stress.J))
        )
        return Snapshot(
            time=self.time,
            step=self.step,
            material=self.material,
            mesh=self._shown_mesh,
            X=X,
            V=V,
            x=x.copy(),
            velocity=v.copy(),
            stress_X=X[mesh.cells].mean(axis=1),
            stress_V=read_only(self._elements.volumes),
            F=stress.F,
            J=stress.J,
            P=stress.P,
            strain_energy=self._elements.strain_energy(x),
            # What the element stores by its own quadrature, beside that of the values shown.
            added_volumetric_energy=volumetric_energy(self._elements, x, at_centres) - at_centres,
            budget=self._budget.now(self._reaction_force),
        )

    def placement(self) -> Placement:
        """Where the nodes are now."""
        return Placement(self.time, self._points, self._motion_now.x)

    def _motion(self) -> tuple[Array, Array]:
        return self._motion_now.x, self._motion_now.v

    def _open_works(self) -> tuple[Works, Callable[[Array], dict[str, Array]]]:
        self._works = StepBudget(self._loads, self._mass, self._essential)
        return self._works, self._essential.by_face

    def _reaction(self) -> Array:
        return self._constraint_force

    def _reaction_force(self) -> Array:
        return self._constraint_force

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        """Set up again with the law as it was here, and put into the state of now."""
        scene = copy.deepcopy(replace(self.scene, material=self.material), memo)
        return rebuilt(type(self), scene, self._arguments, checkpoint_of(self))

    def _options(self) -> dict[str, Any]:
        return {"method": "FEM", "element": self.element, "cfl": self.cfl}

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self._wall_time, "smallest_dt": self._smallest_dt}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._wall_time = totals["run_seconds"]
        self._smallest_dt = totals["smallest_dt"]

    def _fields(self) -> dict[str, Array]:
        return dict(vars(self._motion_now))

    def state_changed(self) -> None:
        """Bring what is derived from the state up to date: the elements' Jacobians."""
        x = self._motion_now.x
        self._elements.internal_force(x, np.empty_like(x))

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
                f"  nodes        {len(self._volumes)}, lumped mass",
                f"  time         central differences, cfl {self.cfl:g}, dt {dt:.4g} s now, "
                f"{math.ceil(remaining / dt)} steps to {self.scene.end_time:.4g} s at that, more "
                "as elements are compressed",
                f"  essential    {len(self._essential.nodes)} constrained nodes, "
                f"{moving} constraints with a prescribed motion",
                f"  loads        {loads}",
                *([f"  initial F    {NOT_USED}"] if self.scene.states_deformation else []),
                f"  memory       {self.memory_bytes() / 1e6:.1f} MB of arrays",
                f"  threads      at most {threads()}, as many as pay",
            )
        )

    def summary(self) -> str:
        """What was done: steps, time steps, speed; whether the positions are sound."""
        elements = self._elements.count
        positions = self.positions.line(self.placement())
        done = f"{self.name}: t = {self.time:.6g} s after {self.step} steps"
        if self.step == 0:
            return f"{done}; {elements} elements, {len(self._volumes)} nodes\n{positions}"
        speed = 1.0e9 * self._wall_time / (self.step * elements)
        return (
            f"{done}; {elements} elements, {len(self._volumes)} nodes, smallest dt "
            f"{self._smallest_dt:.4g} s, {self._wall_time:.3g} s in steps = {speed:.0f} ns per "
            f"element-step on at most {threads()} threads\n{positions}"
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

