"""What a step costs: all methods take turns in one process, so that ratios are side by side."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.scenes import twisting_column
from studies.engine.case import Row
from studies.measures.rhythm import cycle
from studies.methods import Method


def run_cost(
    *, methods: Sequence[tuple[str, Method]], cells: int, window_s: float, repeats: int
) -> list[Row]:
    """A row ``cost`` a method: the least processor seconds a step of ``repeats`` turns.

    A turn has steps for about ``window_s`` seconds, in whole cycles (``measures.rhythm``).  The
    column hardly twists, so that no method is near its end; the work of a step is the same.
    """
    scene = twisting_column(angular_velocity=1.0)
    sims: dict[str, Any] = {}
    turns: dict[str, int] = {}
    for name, method in methods:
        sim = method.simulation(scene, spacing=1.0 / cells)
        sim.advance(sim.stable_time_step())
        whole = cycle(sim)
        guess = max(seconds_of(sim, max(2, whole)), 1.0e-9)
        turns[name] = whole * max(-(-2 // whole), round(window_s / guess / whole))
        sims[name] = sim
    best = dict.fromkeys(sims, float("inf"))
    for _ in range(repeats):
        for name, sim in sims.items():
            best[name] = min(best[name], seconds_of(sim, turns[name]))
    return [
        {
            "kind": "cost", "method": name, "cells": cells, "particles": len(sim.snapshot().X),
            "step_s": best[name], "window_steps": turns[name], "repeats": repeats,
        }
        for name, sim in sims.items()
    ]  # fmt: skip


def seconds_of(sim: Any, steps: int) -> float:
    """Processor seconds a step of the next ``steps``."""
    started = time.process_time()
    for _ in range(steps):
        sim.advance(sim.stable_time_step())
    return (time.process_time() - started) / steps


def step_seconds(cost: pd.DataFrame, method: str, particles: Any) -> NDArray[np.float64]:
    """Seconds a step with ``particles``: a fixed part and one for each, through what was measured.

    Where one lattice was timed, or the larger is no dearer, all of it is for each particle.
    """
    own = cost[cost["method"] == method].sort_values("particles")
    n, t = own["particles"].to_numpy(float), own["step_s"].to_numpy(float)
    wanted = np.asarray(particles, float)
    if len(n) == 0:
        return np.full(wanted.shape, np.nan)
    each = (t[-1] - t[0]) / (n[-1] - n[0]) if len(n) > 1 else 0.0
    if each <= 0.0 or t[0] < each * n[0]:
        return np.asarray(t[-1] / n[-1] * wanted)
    return np.asarray(t[0] + each * (wanted - n[0]))
