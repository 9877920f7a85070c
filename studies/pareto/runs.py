"""One run of a scene: its errors on all threads, then the cost of its step on one."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import set_threads, threads
from sphsolid.record import Snapshot, instant_errors, period_errors
from sphsolid.scenes import Scene, amplitude_of_gradient, swinging_cube, twisting_column
from studies.engine.case import Row
from studies.measures.indicators import twist_of_top, whole_turns
from studies.measures.run import run
from studies.methods import Method
from studies.pareto.cost import counted_work, evaluations_per_step, held_bytes, step_cost

CUBE, COLUMN = "cube", "column"
SCENES = (CUBE, COLUMN)
#: Instants of a period at which errors are taken, ``(k + 1/2) T / 12``.
INSTANTS = 12
#: Largest principal value of the cube's displacement gradient.
LARGEST_GRADIENT = 0.2
#: Time [s] between two records of the column.
EVERY = 2.0e-3


@dataclass(frozen=True)
class Timing:
    """The least of ``repeats`` windows of ``window_s`` CPU seconds; none for a reference."""

    window_s: float
    repeats: int


def stated(scene: str, nu: float) -> Scene:
    """The problem that errors are taken of."""
    if scene == COLUMN:
        return twisting_column(poisson_ratio=nu)
    amplitude = amplitude_of_gradient("A+B+C=0", LARGEST_GRADIENT)
    return swinging_cube(
        family="A+B+C=0", amplitude=amplitude, manufactured=True, poisson_ratio=nu
    )


def timed(scene: str, nu: float) -> Scene:
    """The same body, material and constraints, small motion, no loads: what a step costs.

    The manufactured loads are numpy formulas of the study and cost more than the step of a method;
    they are the same for all methods.  A step's work does not depend on the size of the motion.
    """
    if scene == COLUMN:
        return twisting_column(poisson_ratio=nu, angular_velocity=1.0)
    return swinging_cube(family="A+B+C=0", poisson_ratio=nu)


@dataclass(frozen=True)
class TwistAndEnergy:
    """Rotation of the top [rad, within half a turn] and the energies [J]."""

    def record(self, snapshot: Snapshot, scene: Scene) -> Row:
        """Two columns."""
        energy = snapshot.kinetic_energy + snapshot.strain_energy
        return {"angle [rad]": twist_of_top(snapshot), "energy [J]": energy}


def run_case(
    *, scene: str, nu: float, method: Method, cells: int, until: float, timing: Timing
) -> list[Row]:
    """Rows of two kinds: one ``run``, and for the column an ``instant`` a record.

    Bits do not depend on the number of threads, so the error comes from a run on all of them.
    """
    problem = stated(scene, nu)
    sim = method.simulation(problem, spacing=1.0 / cells)
    started = time.process_time()
    found, instants = of_cube(sim) if scene == CUBE else of_column(sim, until)
    found |= {
        "particles": len(sim.snapshot().X), "end_time": sim.time,
        "error_run_cpu_s": time.process_time() - started,
    }  # fmt: skip
    if scene == CUBE:
        found["stress_size"] = stress_size(problem)
    named = {"scene": scene, "nu": nu, "method": method.name, "cells": cells}
    cost = _cost(method, timed(scene, nu), cells, timing) if timing.repeats else {}
    rows = [{"kind": "run"} | named | setting(sim) | found | cost]
    return rows + [{"kind": "instant"} | named | row for row in instants]


def setting(sim: Any) -> Row:
    """Columns ``solver, formulation, stabilisation, projection, integrator``."""
    if isinstance(sim, fem.Simulation):
        return {"solver": "FEM"}
    supg = sim.stabilisation
    return {
        "solver": "SPH",
        "formulation": sim.formulation.name,
        "stabilisation": f"SUPG-{supg.secondary.name}" if isinstance(supg, sph.SUPG) else "none",
        "projection": "none" if sim.angular_momentum == sph.NoProjection() else "local",
        "integrator": sim.integrator.name,
    }


def of_cube(sim: Any) -> tuple[Row, list[Row]]:
    """Largest component error of momentum and of stress over a period."""
    exact, instants = sim.scene.known_solution(), []
    for k in range(INSTANTS):
        ran = run(sim, until=(k + 0.5) * exact.period / INSTANTS)
        if not ran.survived:
            return ran.columns(), []
        instants.append(instant_errors(sim.snapshot(), exact))
    errors = period_errors(instants)
    return ran.columns() | {
        name: max(value for key, value in errors.items() if key[0] == letter)
        for name, letter in (("momentum", "p"), ("stress", "P"))
    }, []


def of_column(sim: Any, until: float) -> tuple[Row, list[Row]]:
    """Rows ``time [s], twist [rad], energy [J]`` of every record."""
    ran = run(sim, until=until, every=EVERY, record=[TwistAndEnergy()])
    twists = [0.0]
    for angle in ran.history["angle [rad]"]:
        twists.append(whole_turns(float(angle), twists[-1]))
    # The sense of rotation is not published, so it is counted positive.
    sense = 1.0 if max(twists) >= -min(twists) else -1.0
    energy = ran.history["energy [J]"]
    return ran.columns(), [
        {"time [s]": time, "twist [rad]": sense * angle, "energy [J]": kept}
        for time, angle, kept in zip(ran.history["time [s]"], twists[1:], energy, strict=True)
    ]


def stress_size(problem: Scene, points: int = 12) -> float:
    """Size of the exact stress in units of the norm's scale: its largest component.

    Near incompressibility it is far above one, because the scale is the shear's.
    """
    exact = problem.known_solution()
    middle = (np.arange(points) + 0.5) / points
    X = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3)
    instants = [(k + 0.5) * exact.period / INSTANTS for k in range(INSTANTS)]
    mean = np.mean([np.mean(exact.first_piola(X, t) ** 2, axis=0) for t in instants], axis=0)
    return float(np.sqrt(mean.max()) / exact.stress_scale)


def _cost(method: Method, problem: Scene, cells: int, timing: Timing) -> Row:
    available = threads()
    set_threads(1)
    try:
        started = time.process_time()
        sim = method.simulation(problem, spacing=1.0 / cells)
        setup = time.process_time() - started
        step = step_cost(sim, window_s=timing.window_s, repeats=timing.repeats)
    finally:
        set_threads(available)
    work = counted_work(sim)
    return {
        "evaluations_per_step": evaluations_per_step(sim), "step_cpu_s": step.seconds,
        "step_cpu_spread": step.spread, "repeats": step.repeats, "window_steps": step.window,
        "setup_cpu_s": setup, "bytes": held_bytes(sim), "pairs": work.pairs,
        "gathered_bytes": work.gathered, "streamed_bytes": work.streamed,
        "multiply_adds": work.multiply_adds,
    }  # fmt: skip
