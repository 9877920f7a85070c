"""What a step costs: CPU seconds on one thread, side by side with all that it is compared with."""

from __future__ import annotations

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
    set_threads(1)
    try:
        sims = [
            method.simulation(
                problem.timed(nu, cells, elements=isinstance(method.recipe, Elements)),
                spacing=1.0 / cells,
            )
            for method, cells in compared
        ]
        timed = take_turns(sims, rounds=timing.rounds, window_s=timing.window_s)
    finally:
        set_threads(available)
    return [
        {
            "kind": "timing", "scene": scene, "nu": nu, "method": method.name, "cells": cells,
            "step_cpu_s": each.least, "step_cpu_spread": each.spread, "repeats": timing.rounds,
            "window_steps": each.steps,
        }
        for (method, cells), each in zip(compared, timed, strict=True)
    ]  # fmt: skip
