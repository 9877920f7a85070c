"""The outside reference of the column: what a code that shares nothing with this one found."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pandas as pd

#: Provenance in its first lines, figures below.
TABLE = Path(__file__).with_name("outside_reference.csv")
NAME = "CalculiX C3D20R"
#: Instants [ms] at which the twist is compared.
INSTANTS = (20, 40, 60, 80, 100)


@dataclass(frozen=True)
class Known:
    """``value`` on the finest mesh, ``elements``; ``within``: what a coarser mesh changed."""

    value: float
    within: float
    elements: str


@cache
def figures() -> pd.DataFrame:
    """Columns ``quantity, time_ms, elements, step_ms, value``; rows from coarse to fine."""
    return pd.read_csv(TABLE, comment="#")


@cache
def twist(ms: int = 100) -> Known:
    """The twist [rad] at an instant of :data:`INSTANTS`.

    ``within`` is the distance from the next coarser mesh, or what half the step changed where
    that was tried, whichever is more.
    """
    runs = figures()
    step = runs["step_ms"].max()
    at_step = runs[(runs["quantity"] == "twist") & (runs["step_ms"] == step)]
    coarse, fine = at_step[at_step["time_ms"] == ms].iloc[-2:].itertuples()
    return Known(fine.value, max(abs(fine.value - coarse.value), _of_the_step()), fine.elements)


def _of_the_step() -> float:
    runs = figures()
    twist_runs = runs[runs["quantity"] == "twist"]
    pairs = [
        group["value"].max() - group["value"].min()
        for _, group in twist_runs.groupby(["time_ms", "elements"])
        if len(group) > 1
    ]
    return float(max(pairs))


@cache
def corners() -> float:
    """Mean height [m] of the corners of the top face at 0.1 s."""
    runs = figures()
    return float(runs[runs["quantity"] == "corners"]["value"].iloc[-1])
