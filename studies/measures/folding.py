"""Folded positions, a criterion of every study: what a run's row says, and what follows of it.

A run can end with every Jacobian near one while its particles have folded into a saw tooth that no
nodal gradient sees (``sphsolid.record.positions``): its other numbers then say nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

#: Columns of a run: whether its positions folded, and when that was found [s].
COLUMNS = ("folded", "folded_at")


def folding(solver: Any) -> dict[str, Any]:
    """Both columns of a run that ``solver`` made, sound or lost; ``nan`` where it never folded."""
    since = float(solver.positions.folded_since)
    return {"folded": not math.isnan(since), "folded_at": since}


def has_folded(runs: pd.DataFrame, by: float = math.inf) -> pd.Series[bool]:
    """Which rows had folded by a time [s]."""
    return runs["folded"].astype(bool) & ~(runs["folded_at"].astype(float) > by)


def sound(runs: pd.DataFrame) -> pd.Series[bool]:
    """Which rows reached their end (``survived``) without folding."""
    return runs["survived"].astype(bool) & ~has_folded(runs)


def largest(history: pd.DataFrame, column: str) -> float:
    """The largest value of a column of the recorder ``Positions`` over a run, nan without one."""
    return float(np.nanmax(history[column], initial=-np.inf)) if column in history else math.nan
