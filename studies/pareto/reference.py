"""The column has no exact solution: a reference that no method is favoured by.

Each kind of method has a limit of its own, carried on from its two finest lattices to no spacing
with order two; the reference is the mean of the limits.  Its *uncertainty* is the larger of half
the distance between the kinds and of the mean of how far the limits move when their finest lattice
is left out.  The energy of the body is exact: it is kept.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from studies.pareto.methods import REFERENCES

ORDER = 2.0
KINDS = tuple(method.name for method in REFERENCES)
COLUMNS = ["nu", "time [s]", "twist [rad]", "uncertainty [rad]", "kinds", "finest"]


def limit(values: Sequence[float], cells: Sequence[int], order: float = ORDER) -> float:
    """Of the two finest of ``values``, carried on to no spacing with ``order``."""
    (coarse, fine), (n, m) = values[-2:], cells[-2:]
    return fine + (fine - coarse) / ((m / n) ** order - 1.0)


def spread(values: Sequence[float], cells: Sequence[int], order: float = ORDER) -> float:
    """How far the limit moves without the finest lattice; with two: how far it is from it."""
    if len(values) < 3:
        return abs(limit(values, cells, order) - values[-1])
    return abs(limit(values, cells, order) - limit(values[:-1], cells[:-1], order))


def reference(history: pd.DataFrame, kinds: Sequence[str] = KINDS) -> pd.DataFrame:
    """One row per nu and record: mean of the limits [rad] and its uncertainty [rad].

    ``history`` has columns ``nu, method, cells, time [s], twist [rad]``; a kind counts at an
    instant that two of its lattices reached; instants without any are left out.
    """
    if len(history) == 0:
        return pd.DataFrame(columns=COLUMNS)
    known = history[history["method"].isin(kinds)].assign(time=history["time [s]"].round(7))
    rows = []
    for (nu, time), at in known.groupby(["nu", "time"]):
        limits, moves, finest = [], [], 0
        for _, kind in at.sort_values("cells").groupby("method"):
            values, cells = kind["twist [rad]"].tolist(), kind["cells"].tolist()
            if len(values) >= 2:
                limits.append(limit(values, cells))
                moves.append(spread(values, cells))
                finest = max(finest, cells[-1])
        if limits:
            apart = 0.5 * (max(limits) - min(limits))
            unsure = max(apart, float(np.mean(moves)))
            rows.append((nu, time, float(np.mean(limits)), unsure, len(limits), finest))
    return pd.DataFrame(rows, columns=COLUMNS)


def column_errors(history: pd.DataFrame, known: pd.DataFrame) -> pd.DataFrame:
    """One row per ``nu, method, cells``: errors and the reference's uncertainty on their scale.

    ``twist_rms``: root mean square over the records of the distance from the reference over its
    largest value; ``twist_end``: distance at the last record over the value there; ``energy``:
    ``|E / E0 - 1|`` there, ``energy_kept`` ``E / E0``.  A run that ended early has no errors.
    """
    columns = [
        "nu", "method", "cells", "twist_rms", "twist_end", "energy", "energy_kept",
        "twist_rms_uncertainty", "twist_end_uncertainty",
    ]  # fmt: skip
    rows = []
    for (nu, method, cells), run in history.groupby(["nu", "method", "cells"], sort=False):
        here = known[known["nu"] == nu].set_index("time [s]")
        time = run["time [s]"].round(7)
        if len(here) == 0 or time.iloc[-1] < here.index.max():
            continue
        there = here.loc[time]
        peak = there["twist [rad]"].abs().max()
        apart = run["twist [rad]"].to_numpy() - there["twist [rad]"].to_numpy()
        unsure = there["uncertainty [rad]"].to_numpy()
        end = abs(there["twist [rad]"].iloc[-1])
        kept = run["energy [J]"].iloc[-1] / run["energy [J]"].iloc[0]
        rows.append(
            (nu, method, cells, np.sqrt(np.mean(apart**2)) / peak, abs(apart[-1]) / end,
             abs(kept - 1.0), kept, np.sqrt(np.mean(unsure**2)) / peak, unsure[-1] / end)
        )  # fmt: skip
    return pd.DataFrame(rows, columns=columns)
