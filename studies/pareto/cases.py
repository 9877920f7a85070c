"""One run: its errors on all threads, then the cost of its step on one."""

from __future__ import annotations

import time
from typing import Any

from sphsolid.compiled import set_threads, threads
from sphsolid.errors import Diverged
from studies.pareto.cost import counted_work, evaluations_per_step, held_bytes, step_cost
from studies.pareto.methods import METHODS, Method
from studies.pareto.scenes import (
    COLUMN,
    CUBE,
    column_history,
    cube_errors,
    history_rows,
    stated,
    stress_size,
    timed,
)
from studies.report.folding import folding

Row = dict[str, Any]


def run_case(
    *,
    scene: str,
    nu: float,
    method: str,
    cells: int,
    until: float,
    window_s: float,
    repeats: int,
) -> list[Row]:
    """Rows of two kinds: one ``run``, and for the column an ``instant`` a record.

    Bits do not depend on the number of threads, so the error comes from a run on all of them;
    ``repeats = 0`` leaves the cost out (runs that only serve as reference).
    """
    chosen = METHODS[method]
    run, instants = _errors(chosen, scene, nu, cells, until)
    named = {"scene": scene, "nu": nu, "method": method, "cells": cells}
    cost = _cost(chosen, scene, nu, cells, window_s, repeats) if repeats else {}
    rows = [{"kind": "run"} | named | {"family": chosen.family} | chosen.setting | run | cost]
    return rows + [{"kind": "instant"} | named | row for row in instants]


def _errors(
    method: Method, scene: str, nu: float, cells: int, until: float
) -> tuple[Row, list[Row]]:
    problem = stated(scene, nu)
    sim = method.simulation(problem, cells)
    row: Row = {"survived": True, "reason": ""}
    instants: list[Row] = []
    started = time.process_time()
    try:
        if scene == CUBE:
            row |= cube_errors(sim)
        else:
            instants = column_history(sim, until)
    except Diverged as lost:
        row |= {"survived": False, "reason": str(lost)}
        if scene == COLUMN:
            instants = history_rows(lost.history.table)  # type: ignore[attr-defined]
    if scene == CUBE:
        row["stress_size"] = stress_size(problem)
    row |= {
        "particles": len(sim.snapshot().X), "steps": sim.step, "end_time": sim.time,
        "error_run_cpu_s": time.process_time() - started,
    } | folding(sim)  # fmt: skip
    return row, instants


def _cost(
    method: Method, scene: str, nu: float, cells: int, window_s: float, repeats: int
) -> Row:
    problem, available = timed(scene, nu), threads()
    set_threads(1)
    try:
        started = time.process_time()
        sim = method.simulation(problem, cells)
        setup = time.process_time() - started
        step = step_cost(sim, window_s=window_s, repeats=repeats)
    finally:
        set_threads(available)
    work = counted_work(sim)
    return {
        "evaluations_per_step": evaluations_per_step(sim),
        "step_cpu_s": step.seconds,
        "step_cpu_spread": step.spread,
        "repeats": step.repeats,
        "window_steps": step.window,
        "setup_cpu_s": setup,
        "bytes": held_bytes(sim),
        "pairs": work.pairs,
        "gathered_bytes": work.gathered,
        "streamed_bytes": work.streamed,
        "multiply_adds": work.multiply_adds,
    }
