"""One run of a problem: its errors on all threads, then the cost of its step on one."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import set_threads, threads
from sphsolid.scenes import Scene
from studies.engine.case import Row
from studies.methods import Elements, Method
from studies.pareto.cost import counted_work, evaluations_per_step, held_bytes, step_cost
from studies.pareto.problems import PROBLEMS


@dataclass(frozen=True)
class Timing:
    """The least of ``repeats`` windows of ``window_s`` CPU seconds; none for a reference."""

    window_s: float
    repeats: int


def run_case(
    *, scene: str, nu: float, method: Method, cells: int, until: float, timing: Timing
) -> list[Row]:
    """Rows of two kinds: one ``run``, and for the column an ``instant`` a record.

    Bits do not depend on the number of threads, so the error comes from a run on all of them.
    """
    problem, elements = PROBLEMS[scene], isinstance(method.recipe, Elements)
    sim = method.simulation(problem.stated(nu, cells, elements=elements), spacing=1.0 / cells)
    started = time.process_time()
    found, instants = problem.errors(sim, nu, cells, until)
    found |= {
        "particles": len(sim.snapshot().X), "end_time": sim.time,
        "error_run_cpu_s": time.process_time() - started,
    }  # fmt: skip
    named = {"scene": scene, "nu": nu, "method": method.name, "cells": cells}
    bare = problem.timed(nu, cells, elements=elements)
    cost = _cost(method, bare, cells, timing) if timing.repeats else {}
    rows = [{"kind": "run"} | named | setting(sim) | found | cost]
    return rows + [{"kind": "instant"} | named | row for row in instants]


def setting(sim: Any) -> Row:
    """Columns ``solver, formulation, stabilisation, operator, projection, integrator``."""
    if isinstance(sim, fem.Simulation):
        return {"solver": "FEM"}
    return {
        "solver": "SPH",
        "formulation": sim.formulation.name,
        "stabilisation": _stabilisation(sim.stabilisation),
        "operator": sim.operator.name,
        "projection": "none" if sim.angular_momentum == sph.NoProjection() else "local",
        "integrator": sim.integrator.name,
    }


def _stabilisation(option: Any) -> str:
    if isinstance(option, sph.SUPG):
        return f"SUPG-{option.secondary.name}"
    return "restraint" if isinstance(option, sph.Restraint) else "none"


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
