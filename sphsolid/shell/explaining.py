"""``sphsolid explain``: what a case will do, before it does it."""

from __future__ import annotations

import copy
import math
import time
from typing import Any

from sphsolid.record.display import duration
from sphsolid.shell.case import Case

#: Steps are timed for so long [s], and at least so many of them.
_TIMED_FOR, _LEAST = 1.0, 3


def explain(case: Case, *, timed: bool = True) -> str:
    """The plan of the simulation, and what the run will cost.

    With ``timed`` a few steps are taken on the side: the first compiles, the others are measured.
    """
    simulation = case.simulation()
    lines = [simulation.plan(), "", "run"]
    step = simulation.stable_time_step()
    gaps = max(1, math.ceil(case.run.until / case.run.every - 1e-9))
    # Steps are shortened so that each record is the end of one.
    steps = gaps * math.ceil(min(case.run.every, case.run.until) / step - 1e-9)
    names = ", ".join(type(each).__name__ for each in case.run.record)
    lines += [
        f"  to           {case.run.until:.4g} s in about {steps} steps of at most {step:.4g} s, "
        "more as the body is compressed",
        f"  records      {gaps + 1}, every {case.run.every:.4g} s: {names}",
        f"  files        {case.run.folder}: history.csv"
        + "".join(f", {name}" for name, each in _files(case) if hasattr(each, "records")),
    ]
    if timed:
        seconds = _seconds_a_step(simulation)
        points = len(simulation.placement().x)
        lines.append(
            f"  time         about {duration(steps * seconds)}: {1e3 * seconds:.3g} ms a step, "
            f"{1e9 * seconds / points:.0f} ns a point, measured now, records not counted"
        )
    return "\n".join(lines)


def _files(case: Case) -> list[tuple[str, Any]]:
    run = case.run
    return [
        ("frames (VTU, PVD)", run.frames), ("run.vtkhdf", run.vtkhdf),
        ("checkpoint.npz", run.checkpoints),
    ]  # fmt: skip


def _seconds_a_step(simulation: Any) -> float:
    """Measured on a copy, which is thrown away."""
    tried = copy.deepcopy(simulation)
    tried.advance(tried.stable_time_step())
    began, taken = time.perf_counter(), 0
    while taken < _LEAST or time.perf_counter() - began < _TIMED_FOR:
        tried.advance(tried.stable_time_step())
        taken += 1
        if tried.time > 0.5 * simulation.scene.end_time and taken >= _LEAST:
            break
    return (time.perf_counter() - began) / taken
