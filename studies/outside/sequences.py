"""Sequences of lattices or meshes and their limits, of CalculiX and of ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from studies.measures.order import LEVELS, Limit, extrapolate
from studies.measures.tables import select

Array = NDArray[np.float64]
#: How runs of CalculiX are called beside methods.
CALCULIX = "CalculiX C3D20R"


@dataclass(frozen=True)
class Sequence:
    """``values (n,)`` on ``levels (n,)``, ascending numbers of cells."""

    levels: Array
    values: Array

    @property
    def has_limit(self) -> bool:
        """Whether there are enough levels to carry on to no spacing."""
        return len(self.levels) >= LEVELS

    @property
    def limit(self) -> Limit:
        """At no spacing, or where there are too few levels the finest and its last change."""
        if self.has_limit:
            return extrapolate(1.0 / self.levels, self.values)
        change = abs(self.values[-1] - self.values[-2]) if len(self.values) > 1 else np.nan
        return Limit(float(self.values[-1]), float(change))


def sequence(runs: pd.DataFrame, problem: str, quantity: str) -> Sequence | None:
    """Of the sound runs of one code; None where there is no run."""
    own = select(runs, problem=problem, quantity=quantity).sort_values("level")
    if "survived" in own:
        own = own[own["survived"].astype(bool) & ~own["folded"].astype(bool)]
    own = own[np.isfinite(own["value"].astype(float))]
    if not len(own):
        return None
    return Sequence(own["level"].to_numpy(dtype=float), own["value"].to_numpy(dtype=float))


def comparison(calculix: pd.DataFrame, ours: pd.DataFrame) -> pd.DataFrame:
    """A row a problem, quantity and method, CalculiX the first of them.

    ``outside`` and ``limit`` are the limits, each with ``_within``, what it may be off;
    ``off_limit`` is ``limit / outside - 1``, ``off_finest`` the same of the finest lattice, and
    ``left`` the finest lattice less its own limit, over that limit: nan where too few levels have
    none.
    """
    rows = []
    for problem, quantity in calculix[["problem", "quantity"]].drop_duplicates().itertuples(
        index=False
    ):
        theirs = sequence(calculix, problem, quantity)
        for method in (CALCULIX, *ours["method"].drop_duplicates()):
            runs = calculix if method == CALCULIX else select(ours, method=method)
            own = sequence(runs, problem, quantity)
            if theirs is None or own is None:
                continue
            known, limit, finest = theirs.limit, own.limit, float(own.values[-1])
            rows.append({
                "problem": problem, "quantity": quantity, "method": method,
                "outside": known.value, "outside_within": known.within,
                "levels": len(own.levels), "finest_level": int(own.levels[-1]),
                "finest": finest, "limit": limit.value, "limit_within": limit.within,
                "off_finest": finest / known.value - 1.0,
                "off_limit": limit.value / known.value - 1.0,
                "left": finest / limit.value - 1.0 if own.has_limit else np.nan,
            })  # fmt: skip
    columns = [
        "problem", "quantity", "method", "outside", "outside_within", "levels", "finest_level",
        "finest", "limit", "limit_within", "off_finest", "off_limit", "left",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def column_reference(calculix: pd.DataFrame, problem: str) -> pd.DataFrame:
    """Twist and corners of one column in the form of ``twisting_column/outside_reference.csv``."""
    names = {f"twist at {ms} ms [rad]": ("twist", ms) for ms in (20, 40, 60, 80, 100)}
    names["top corners at 100 ms [m]"] = ("corners", 100)
    rows = []
    for row in select(calculix, problem=problem).sort_values("level").itertuples():
        if row.quantity in names:
            quantity, ms = names[row.quantity]
            n = int(row.level)
            rows.append({
                "quantity": quantity, "time_ms": ms, "elements": f"{n}x{6 * n}x{n}",
                "step_ms": row.step_ms, "value": row.value,
            })  # fmt: skip
    return pd.DataFrame(rows, columns=["quantity", "time_ms", "elements", "step_ms", "value"])
