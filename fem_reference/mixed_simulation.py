"""Mixed methods of cells on a scene, with the surface of ``Simulation``; no formula but TVD-RK2.

    U* = U^n + dt R(U^n),    U^{n+1} = (U^n + U* + dt R(U*)) / 2,
    x^{n+1} = x^n + dt (v^n + v*) / 2

([Shu1988], [Lee2017] Algorithm 1).  ``x^{n+1}`` is known before stage two, which projects with it:
that is what makes angular momentum exact.
"""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference import pg_fem_kernels as kernels
from fem_reference.essential import EssentialConditions
from fem_reference.loads import loads_of, nodal_force
from fem_reference.mixed_budget import MixedBudget, NoStageBudget
from fem_reference.pg_fem import PGFEM
from sphsolid.compiled import threads
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.continuum.check_law import check_first_use
from sphsolid.continuum.wave_speed import THINNEST
from sphsolid.errors import Diverged, require
from sphsolid.geometry.body import AS_MESHED, AsMeshed, Spacing
from sphsolid.geometry.mesh import read_only
from sphsolid.protocols import check_protocol
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
DEFAULT_METHOD = PGFEM()
#: Steps between two looks at the positions.
LOOK_EVERY = 200


class MixedSimulation(BaseSimulation):
    """The Petrov-Galerkin method {p, F, H, J} on ``scene``, with the surface of ``Simulation``.

    Unknowns are nodal positions and velocities ``(N, 3)`` and the strains ``F, H, J`` of every
    node; lumped mass; two-stage TVD Runge-Kutta.  The constructor raises ``InputError`` for a wrong
    ``spacing``, ``cfl``, ``method``, tag, load or initial state.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        spacing: Spacing = AS_MESHED,
        method: PGFEM = DEFAULT_METHOD,
        cfl: float = 0.3,
    ) -> None:
        """``spacing`` [m] nominal, of nodes, unless the body has its own; ``cfl`` fraction of the
        time in which a p-wave crosses the shortest cell, in (0, 1].
        """
        check_scene(scene)
        asked = as_float(cfl)
        require(
            isinstance(asked, float) and 0.0 < asked <= 1.0,
            f"cfl = {cfl!r} is outside (0, 1]; 0.3 is usual for the mixed methods",
        )
        check_protocol(
            "method", method, ("name", "discretise"), "use fem_reference.PGFEM()"
        )
        if not isinstance(spacing, AsMeshed):
            spacing = number("spacing", spacing, "m")
        arguments = {"spacing": spacing, "method": method, "cfl": cfl}
        super().__init__(
            scene, check_first_use(scene.material), arguments, look_every=LOOK_EVERY
        )
        self.method, self.cfl = method, asked
        self._wall_time, self._smallest_dt = 0.0, math.inf
        self._works: MixedBudget | NoStageBudget = NoStageBudget()
        mesh = scene.body.mesh(spacing)
        check_probes(scene, mesh)
        self._cells = method.discretise(mesh=mesh, material=self.material)
        cells = self._cells.cells
        self._take_points(cells.mesh, cells.V)
        self._loads = loads_of(scene, cells.sk, cells.load_shapes)
        self._essential = EssentialConditions.of(scene.constraints, cells.mesh)
        self._mass = (self.material.density * cells.V)[:, None]
        self._reaction_now = np.zeros((len(self._essential.nodes), 3))
        self._crossing = cells.length / reference_p_wave_speed(self.material)
        self._start()

    def _start(self) -> None:
        """Nodal state at ``t = 0``."""
        scene, X = self.scene, self._points.vertices
        refuse_contradiction(scene, X)
        displacement, velocity = scene.initial_state(X)
        self._x, self._v = X + displacement, velocity.copy()
        self._essential.apply(self._v, 0.0)
        self._strains = self._cells.start(self._x)
        self._saved_v, self._saved = np.empty_like(self._v), np.empty_like(self._strains)
        bad = np.flatnonzero(~(self._cells.look(self._strains) > 0.0))
        require(
            len(bad) == 0,
            f"scene {scene.name!r}: the initial displacement turns the body inside out at node "
            f"{bad[0] if len(bad) else 0} (det F <= 0); reduce its amplitude or refine the mesh",
        )

    # ------------------------------------------------------------------ steps
    @by_team
    def stable_time_step(self) -> float:
        """``cfl * length / (c_p / min_a lambda_a)`` [s].

        ``length`` is the smallest altitude of a tetrahedron, or the shortest edge of a brick, in
        the undeformed body; ``lambda_a`` the smallest principal stretch of ``F_a``; ``c_p`` that of
        the undeformed solid.  Raises ``Diverged`` when the state is invalid.
        """
        smallest = self._cells.look(self._strains)
        finite = np.isfinite(self._v).all(axis=1) & np.isfinite(self._strains).all(axis=1)
        least = np.where(finite & np.isfinite(smallest), smallest, -2.0)
        a = int(np.argmin(least))
        if least[a] < THINNEST:
            reason = "non-finite state" if least[a] < -1.5 else "negative or vanishing Jacobian"
            X = self._points.vertices[a]
            at = (float(X[0]), float(X[1]), float(X[2]))
            advice = f"a cfl below {self.cfl:g}, larger tau_F or tau_p, or a finer mesh"
            raise Diverged(reason, self.time, self.step, a, at, advice)
        return self.cfl * self._crossing * float(least[a])

    @step_by_team
    def advance(self, dt: float) -> None:
        """One step of ``dt`` [s]; intrinsic times follow the stable step of now."""
        start = time.perf_counter()
        v, strains, cells = self._v, self._strains, self._cells
        cells.begin_step(self.stable_time_step())
        self._evaluate(self.time)
        self._tell(0.5 * dt, self.time)
        kernels.first_stage(dt, cells.v_dot, self._saved_v, v)
        kernels.first_stage(dt, cells.strains_dot, self._saved, strains)
        # Half of a jump made here is averaged away.
        self._works.impose(self._essential, self._x, v, self.time + dt, 0.5)
        self._x += 0.5 * dt * (self._saved_v + v)
        self._evaluate(self.time + dt)
        self._tell(0.5 * dt, self.time + dt)
        kernels.second_stage(dt, cells.v_dot, self._saved_v, v)
        kernels.second_stage(dt, cells.strains_dot, self._saved, strains)
        self._works.impose(self._essential, self._x, v, self.time + dt, 1.0)
        self._wall_time += time.perf_counter() - start
        self._budget.step(self._momentum)
        self.time += dt
        self.step += 1
        self._smallest_dt = min(self._smallest_dt, dt)

    def _evaluate(self, t: float) -> None:
        """Rates of the state now."""
        cells, V = self._cells, self._volumes[:, None]
        cells.galerkin_rates(self._v, self._strains)
        rate = cells.v_dot
        np.negative(cells.internal_force(self._x, self._v, self._strains), out=rate)
        if self._loads:
            rate += nodal_force(self._loads, t, len(rate)) / V
        held = self._essential.nodes
        before = rate[held]
        rate[held] = np.einsum("nij,nj->ni", self._essential.free, before)
        self._reaction_now = V[held] * (rate[held] - before)
        inertia = rate
        body = tuple(load for load in self._loads if load.what == "body force")
        if body:
            inertia = rate - nodal_force(body, t, len(rate)) / V
        cells.volume_dissipation(self._strains, inertia)
        rate /= self.material.density

    def _tell(self, dt: float, t: float) -> None:
        if self._works.looks:
            powers = self._cells.stress_powers(self._x, self._v, self._strains)
            self._works.stage(self._x, self._v, dt, t, self._reaction_now, powers)

    # ------------------------------------------------------------------ what it hands out
    @property
    def name(self) -> str:
        """``<scene>_fem_<method>``, for file names."""
        return f"{self.scene.name}_fem_{self.method.name}"

    @property
    def elements(self) -> int:
        """Number of cells."""
        return self._cells.cells.count

    def snapshot(self) -> Snapshot:
        """State now: nodes with lumped volumes, strains and stresses at the nodes too."""
        S, X, V = self._strains, read_only(self._points.vertices), read_only(self._volumes)
        return Snapshot(
            time=self.time,
            step=self.step,
            material=self.material,
            mesh=self._shown_mesh,
            X=X,
            V=V,
            x=self._x.copy(),
            velocity=self._v.copy(),
            stress_X=X,
            stress_V=V,
            F=S[:, :9].reshape(-1, 3, 3).copy(),
            J=S[:, 18].copy(),
            P=self._cells.stress(S),
            strain_energy=self._cells.energy(S),
            budget=self._budget.now(self._reaction_force),
        )

    def placement(self) -> Placement:
        """Where the nodes are now."""
        return Placement(self.time, self._points, self._x)

    def plan(self) -> str:
        """What is active and what it will cost, in words."""
        dt = self.stable_time_step()
        loads = ", ".join(load.what for load in self._loads) or "none (no load vector is formed)"
        remaining = max(0.0, self.scene.end_time - self.time)
        return "\n".join(
            (
                f"{self.name}: mixed finite elements",
                f"  cells        {self._cells.description()}",
                f"  nodes        {len(self._volumes)}, lumped mass",
                f"  time         TVD-RK2, cfl {self.cfl:g}, dt {dt:.4g} s now, "
                f"{math.ceil(remaining / dt)} steps to {self.scene.end_time:.4g} s at that",
                f"  essential    {len(self._essential.nodes)} constrained nodes, "
                f"{len(self._essential.driven)} constraints with a prescribed motion",
                f"  loads        {loads}",
                *([f"  initial F    {NOT_USED}"] if self.scene.states_deformation else []),
                f"  memory       {self.memory_bytes() / 1e6:.1f} MB of arrays",
                f"  threads      at most {threads()}, as many as pay",
            )
        )

    def summary(self) -> str:
        """What was done: steps, time steps, speed; whether the positions are sound."""
        positions = self.positions.line(self.placement())
        size = f"{self.elements} cells, {len(self._volumes)} nodes"
        done = f"{self.name}: t = {self.time:.6g} s after {self.step} steps; {size}"
        if self.step == 0:
            return f"{done}\n{positions}"
        speed = 1.0e9 * self._wall_time / (self.step * len(self._volumes))
        return (
            f"{done}, smallest dt {self._smallest_dt:.4g} s, {self._wall_time:.3g} s in steps = "
            f"{speed:.0f} ns per node-step on at most {threads()} threads\n{positions}"
        )

    # ------------------------------------------------------------------ what the base asks for
    def _motion(self) -> tuple[Array, Array]:
        return self._x, self._v

    def _open_works(self) -> tuple[Works, Callable[[Array], dict[str, Array]]]:
        self._works = MixedBudget(self._loads, self._mass, self._essential.nodes)
        return self._works, self._essential.by_face

    def _reaction(self) -> Array:
        return self._reaction_now

    def _reaction_force(self) -> Array:
        return self._reaction_now

    def __deepcopy__(self, memo: dict[int, Any]) -> MixedSimulation:
        """Set up again with the law as it was here, and put into the state of now."""
        scene = copy.deepcopy(replace(self.scene, material=self.material), memo)
        return rebuilt(type(self), scene, self._arguments, checkpoint_of(self))

    def _options(self) -> dict[str, Any]:
        return {"method": "mixed FEM", "options": self.method, "cfl": self.cfl}

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self._wall_time, "smallest_dt": self._smallest_dt}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._wall_time = totals["run_seconds"]
        self._smallest_dt = totals["smallest_dt"]

    def _fields(self) -> dict[str, Array]:
        return {"x": self._x, "v": self._v, "strains": self._strains}

    def state_changed(self) -> None:
        """Nothing is derived from the state but what each step finds anew."""
