"""What a step costs: all methods take turns in one process, so that ratios are side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.scenes import twisting_column
from studies.engine.case import Row
from studies.measures.turns import take_turns
from studies.methods import Method


def run_cost(
    *, methods: Sequence[tuple[str, Method]], cells: int, window_s: float, repeats: int
) -> list[Row]:
    """A row ``cost`` a method: the least processor seconds a step of ``repeats`` turns.

    A turn takes about ``window_s`` seconds (``measures.turns``).  The column hardly twists, so that
    no method is near its end; the work of a step is the same.
    """
    scene = twisting_column(angular_velocity=1.0)
    sims = {name: method.simulation(scene, spacing=1.0 / cells) for name, method in methods}
    timed = take_turns(sims.values(), rounds=repeats, window_s=window_s)
    return [
        {
            "kind": "cost", "method": name, "cells": cells,
            "particles": len(each.sim.snapshot().X), "step_s": each.least,
            "window_steps": each.steps, "repeats": repeats,
        }
        for name, each in zip(sims, timed, strict=True)
    ]  # fmt: skip


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
