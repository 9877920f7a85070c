"""The finite volume method on a scene, with the surface of ``Simulation``; only TVD-RK2 is here."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference.constrained_touch import ConstrainedTOUCH, TouchRates
from fem_reference.essential import EssentialConditions
from fem_reference.touch_budget import NoTouchBudget, TouchBudget
from sphsolid.compiled import threads
from sphsolid.continuum.check_law import check_first_use
from sphsolid.continuum.wave_speed import THINNEST
from sphsolid.errors import Diverged, require
from sphsolid.geometry.body import AS_MESHED, AsMeshed, Spacing
from sphsolid.geometry.mesh import read_only
from sphsolid.protocols import check_protocol
from sphsolid.record import Snapshot
from sphsolid.record.budget import total_momentum
from sphsolid.record.checkpoint import checkpoint_of, rebuilt
from sphsolid.record.placement import Placement
from sphsolid.record.probes import check_probes
from sphsolid.record.snapshot import Masses
from sphsolid.run.base import BaseSimulation
from sphsolid.run.running_budget import Works
from sphsolid.scenes.checks import as_float, number
from sphsolid.scenes.scene import Scene, check_scene
from sphsolid.scenes.stated_deformation import NOT_USED, refuse_contradiction

Array = NDArray[np.float64]
#: Options are immutable objects, so one default serves every simulation.
DEFAULT_METHOD = ConstrainedTOUCH()
#: Steps between two looks at the positions.
LOOK_EVERY = 200


class FiniteVolumeSimulation(BaseSimulation):
    """Cell-centred finite volumes on ``scene``, with the surface of ``Simulation``.

    Unknowns are the velocities and positions ``(E, 3)`` of the cells and the positions ``(N, 3)``
    of the nodes; two-stage TVD Runge-Kutta.  Momentum and energy are those of the cells; snapshots
    show nodes.  Raises ``InputError`` for a wrong argument, tag or initial state.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        spacing: Spacing = AS_MESHED,
        method: ConstrainedTOUCH = DEFAULT_METHOD,
        cfl: float = 0.3,
    ) -> None:
        """``spacing`` [m] nominal, of nodes, unless the body has its own; ``cfl`` fraction of the
        time in which a p-wave crosses the shortest cell, in (0, 1].
        """
        check_scene(scene)
        asked = as_float(cfl)
        require(
            isinstance(asked, float) and 0.0 < asked <= 1.0,
            f"cfl = {cfl!r} is outside (0, 1]; 0.3 is usual for the finite volume method",
        )
        check_protocol(
            "method", method, ("name", "discretise"), "use fem_reference.ConstrainedTOUCH()"
        )
        if not isinstance(spacing, AsMeshed):
            spacing = number("spacing", spacing, "m")
        arguments = {"spacing": spacing, "method": method, "cfl": cfl}
        super().__init__(
            scene, check_first_use(scene.material), arguments, look_every=LOOK_EVERY
        )
        self.method, self.cfl = method, asked
        self._wall_time, self._smallest_dt = 0.0, math.inf
        self._works: TouchBudget | NoTouchBudget = NoTouchBudget()
        mesh = scene.body.mesh(spacing)
        check_probes(scene, mesh)
        self._cells = method.discretise(scene=scene, mesh=mesh, material=self.material)
        cells = self._cells.cells
        self._take_points(cells.mesh, cells.V)
        self._essential = EssentialConditions.of(scene.constraints, cells.mesh)
        self._reaction_now = np.zeros((len(self._cells.boundary.held), 3))
        self._start()

    def _start(self) -> None:
        scene, X, centres = self.scene, self._points.vertices, self._cells.maps.X
        refuse_contradiction(scene, X)
        self._x = X + scene.initial_state(X)[0]
        moved, velocity = scene.initial_state(centres)
        self._centres, self._v = centres + moved, velocity.copy()
        bad = np.flatnonzero(~(self._cells.smallest_stretch(self._x) > 0.0))
        require(
            len(bad) == 0,
            f"scene {scene.name!r}: the initial displacement turns cell "
            f"{bad[0] if len(bad) else 0} inside out (J <= 0); reduce its amplitude or refine",
        )

    # ------------------------------------------------------------------ steps
    def stable_time_step(self) -> float:
        """``cfl * L / (c_p / min_e lambda_e)`` [s].

        ``L`` is the smallest stretch of the reference maps, the edge of a cube; ``lambda_e`` the
        smallest principal stretch of ``F_e``.  Raises ``Diverged`` when the state is invalid.
        """
        least = self._cells.smallest_stretch(self._x)
        least = np.where(np.isfinite(self._v).all(axis=1), least, -2.0)
        e = int(np.argmin(least))
        if least[e] < THINNEST:
            reason = "non-finite state" if least[e] < -1.5 else "negative or vanishing Jacobian"
            X = self._cells.maps.X[e]
            at = (float(X[0]), float(X[1]), float(X[2]))
            advice = f"a cfl below {self.cfl:g}, or a finer mesh"
            raise Diverged(reason, self.time, self.step, e, at, advice)
        return self.cfl * self._cells.cells.length * float(least[e]) / self._cells.c_p

    def advance(self, dt: float) -> None:
        """One step of ``dt`` [s]."""
        start = time.perf_counter()
        v, x, centres = self._v, self._x, self._centres
        first = self._evaluate(v, x, centres, self.time, 0.5 * dt)
        v_star, x_star = v + dt * first.v, x + dt * first.x
        # Positions of the end of the step are known: the second stage projects with them.
        ahead = centres + 0.5 * dt * (v + v_star)
        second = self._evaluate(v_star, x_star, ahead, self.time + dt, 0.5 * dt)
        v += 0.5 * dt * (first.v + second.v)
        x += 0.5 * dt * (first.x + second.x)
        centres[:] = ahead
        self._wall_time += time.perf_counter() - start
        self._budget.step(self._momentum)
        self.time += dt
        self.step += 1
        self._smallest_dt = min(self._smallest_dt, dt)
        self.stable_time_step()

    def _evaluate(self, v: Array, x: Array, arms: Array, t: float, weight: float) -> TouchRates:
        with np.errstate(all="ignore"):
            rates = self._cells.evaluate(v, x, arms, t)
        self._essential.apply(rates.x, t)
        boundary = self._cells.boundary
        held = boundary.held
        self._reaction_now = np.einsum("nij,nj->ni", boundary.Q[held], rates.force[held])
        self._works.stage(self._cells, rates, v, x, arms, t, weight)
        return rates

    # ------------------------------------------------------------------ what it hands out
    @property
    def name(self) -> str:
        """``<scene>_fv_<method>``, for file names."""
        return f"{self.scene.name}_fv_{self.method.name}"

    @property
    def elements(self) -> int:
        """Number of cells."""
        return self._cells.cells.count

    def _nodal_velocity(self) -> Array:
        """What moves the nodes now ``(N, 3)`` [m/s]."""
        with np.errstate(all="ignore"):
            rates = self._cells.evaluate(self._v, self._x, self._centres, self.time)
        self._essential.apply(rates.x, self.time)
        return rates.x

    def snapshot(self) -> Snapshot:
        """State now: nodes with lumped volumes, strains and stresses in the cells.

        Momentum and kinetic energy are those of the cells.
        """
        cells, maps = self._cells, self._cells.maps
        F, H, J = cells.strains(self._x)
        return Snapshot(
            time=self.time,
            step=self.step,
            material=self.material,
            mesh=self._shown_mesh,
            X=read_only(self._points.vertices),
            V=read_only(self._volumes),
            x=self._x.copy(),
            velocity=self._nodal_velocity(),
            stress_X=maps.X,
            stress_V=maps.V,
            F=F,
            J=J,
            P=cells.stress(F, H, J),
            strain_energy=cells.energy(self._x),
            budget=self._budget.now(self._reaction_force),
            carried_by=Masses(maps.V, self._centres.copy(), self._v.copy()),
        )

    def placement(self) -> Placement:
        """Where the nodes are now."""
        return Placement(self.time, self._points, self._x)

    def plan(self) -> str:
        """What is active and what it will cost, in words."""
        dt = self.stable_time_step()
        remaining = max(0.0, self.scene.end_time - self.time)
        return "\n".join(
            (
                f"{self.name}: cell-centred finite volumes",
                f"  cells        {self._cells.description()}",
                f"  nodes        {len(self._volumes)}, moved by the fluxes",
                f"  time         TVD-RK2, cfl {self.cfl:g}, dt {dt:.4g} s now, "
                f"{math.ceil(remaining / dt)} steps to {self.scene.end_time:.4g} s at that",
                f"  essential    {len(self._cells.boundary.held)} constrained faces",
                *([f"  initial F    {NOT_USED}"] if self.scene.states_deformation else []),
                f"  memory       {self.memory_bytes() / 1e6:.1f} MB of arrays",
                f"  threads      {threads()} (numpy takes one)",
            )
        )

    def summary(self) -> str:
        """What was done: steps, time steps, speed; whether the positions are sound."""
        positions = self.positions.line(self.placement())
        size = f"{self.elements} cells, {len(self._volumes)} nodes"
        done = f"{self.name}: t = {self.time:.6g} s after {self.step} steps; {size}"
        if self.step == 0:
            return f"{done}\n{positions}"
        speed = 1.0e9 * self._wall_time / (self.step * self.elements)
        return (
            f"{done}, smallest dt {self._smallest_dt:.4g} s, {self._wall_time:.3g} s in steps = "
            f"{speed:.0f} ns per cell-step\n{positions}"
        )

    # ------------------------------------------------------------------ what the base asks for
    def _momentum(self) -> Array:
        return total_momentum(
            self._cells.maps.V, self.material.density, self._centres, self._v
        )

    def _motion(self) -> tuple[Array, Array]:
        return self._x, self._nodal_velocity()

    def _open_works(self) -> tuple[Works, Callable[[Array], dict[str, Array]]]:
        self._works = TouchBudget(self._cells)
        return self._works, self._cells.boundary.by_face

    def _reaction(self) -> Array:
        return self._reaction_now

    def _reaction_force(self) -> Array:
        return self._reaction_now

    def __deepcopy__(self, memo: dict[int, Any]) -> FiniteVolumeSimulation:
        """Set up again with the law as it was here, and put into the state of now."""
        scene = copy.deepcopy(replace(self.scene, material=self.material), memo)
        return rebuilt(type(self), scene, self._arguments, checkpoint_of(self))

    def _options(self) -> dict[str, Any]:
        return {"method": "finite volumes", "options": self.method, "cfl": self.cfl}

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self._wall_time, "smallest_dt": self._smallest_dt}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._wall_time = totals["run_seconds"]
        self._smallest_dt = totals["smallest_dt"]

    def _fields(self) -> dict[str, Array]:
        return {"x": self._x, "v": self._v, "centres": self._centres}

    def state_changed(self) -> None:
        """Nothing is derived from the state but what each step finds anew."""
