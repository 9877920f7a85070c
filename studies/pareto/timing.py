"""What a step costs: CPU seconds on one thread, side by side with all that it is compared with.

*Bytes*: all arrays reachable from the simulation, each once, one rule for particles and elements.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from sphsolid.compiled import set_threads, threads
from studies.engine.case import Row
from studies.measures.turns import take_turns
from studies.methods import Elements, Method
from studies.pareto.problems import PROBLEMS


@dataclass(frozen=True)
class Timing:
    """So many ``rounds`` of windows of about ``window_s`` CPU seconds."""

    window_s: float
    rounds: int


def side_by_side(
    *, scene: str, nu: float, compared: Sequence[tuple[Method, int]], timing: Timing
) -> list[Row]:
    """One row of kind ``timing`` for each of ``compared``, a method and its cells per metre."""
    problem, available = PROBLEMS[scene], threads()
    sims, set_up = [], []
    set_threads(1)
    try:
        for method, cells in compared:
            bare = problem.timed(nu, cells, elements=isinstance(method.recipe, Elements))
            started = time.process_time()
            sims.append(method.simulation(bare, spacing=1.0 / cells))
            set_up.append(time.process_time() - started)
        held = [sim.memory_bytes() for sim in sims]
        timed = take_turns(sims, rounds=timing.rounds, window_s=timing.window_s)
    finally:
        set_threads(available)
    return [
        {
            "kind": "timing", "scene": scene, "nu": nu, "method": method.name, "cells": cells,
            "step_cpu_s": each.least, "step_cpu_spread": each.spread, "repeats": timing.rounds,
            "window_steps": each.steps, "setup_cpu_s": seconds, "bytes": size,
        }
        for (method, cells), each, seconds, size in zip(compared, timed, set_up, held, strict=True)
    ]  # fmt: skip
