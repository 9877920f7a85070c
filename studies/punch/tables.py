"""The tables of the punch test: one row a run, measured against the finest finite elements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from studies.engine.case import Row
from studies.engine.results import Tables
from studies.measures import folding
from studies.measures.tables import select
from studies.methods import B_BAR, Method
from studies.punch.runs import COMPARED, CONSISTENT, EVERY, OWN_OPERATOR, Reading

RUN = [
    "key", "press", "method", "operator", "lattice", "cells", "particles", "h_over_dx",
    "integrator", "until", "survived", "diverged_at", "where", "why", *folding.COLUMNS, "steps",
    "cpu_s", "wall_s",
]  # fmt: skip
#: What the history says of a run, see :func:`measures`.
MEASURED = [
    "top_low", "top_high", "top_rms", "profile_same", "profile_finest", "pressure_1",
    "pressure_99", "noise", "noise_mean", "noise_late", "J_min", "J_max", "energy_kept",
    "energy_D_p", "energy_D_J", "energy_projection", "energy_rest", "floor_impulse",
    "press_impulse", "momentum_drift",
]  # fmt: skip
COST = ["lattice", "tau_p", "ns_none", "ns_H1", "ns_H6", "terms_ratio", "step_ratio"]
PROFILE = ["key", "time", "X", "x", "z"]
_SAME = 0.01 * EVERY


def tables(rows: list[Row]) -> Tables:
    """``table``: a row per run; ``history`` and ``profile`` what it is made from; ``cost``."""
    history = _frame(rows, "instant", ["key", "time [s]"])
    profile = _frame(rows, "profile", PROFILE)
    runs = _frame(rows, "run", RUN)
    found = [measures(run, runs, history, profile) for run in runs.to_dict("records")]
    measured = pd.DataFrame(found, columns=MEASURED, index=runs.index)
    return {
        "table": pd.concat([runs[RUN], measured], axis=1),
        "history": history,
        "profile": profile[PROFILE],
        "cost": _frame(rows, "cost", COST)[COST],
    }


def _frame(rows: list[Row], kind: str, columns: Sequence[str]) -> pd.DataFrame:
    """Rows of one kind, with at least ``columns``, these first."""
    found = pd.DataFrame([row for row in rows if row["kind"] == kind])
    others = [name for name in found.columns if name not in (*columns, "kind")]
    return found.reindex(columns=[*columns, *others])


def one_run(
    table: pd.DataFrame, reading: Reading, method: Method, operator: Any = CONSISTENT,
    level: int = 0,
) -> pd.DataFrame:  # fmt: skip
    """The row of a run, or none; ``level`` 0 is the coarsest lattice, 1 the next."""
    levels = sorted(table["cells"].unique())
    if level >= len(levels):
        return table.iloc[:0]
    found = select(table, press=reading.name, method=method.name, cells=levels[level])
    if method not in OWN_OPERATOR:
        found = select(found, operator=operator.name)
    return found.head(1)


def elements(table: pd.DataFrame, reading: Reading) -> pd.DataFrame:
    """The B-bar runs of a reading, from the coarsest lattice to the finest."""
    return select(table, press=reading.name, method=B_BAR.name).sort_values("cells")


def measures(
    run: dict[Any, Any], runs: pd.DataFrame, history: pd.DataFrame, profile: pd.DataFrame
) -> dict[str, float]:
    """The numbers of one run, :data:`MEASURED`; ``nan`` where the run did not get so far.

    At 15 ms: heights of the top face [m], percentiles by volume of the pressure [Pa], noise,
    impulse [N s] of floor and punch.  ``top_rms`` [m]: distance of the lowest or the
    highest height, the larger, from that of the finest finite elements, root mean square over the
    records to 15 ms.  ``profile_same``, ``profile_finest`` [m]: largest difference of the edge from
    elements of the same, of the finest lattice.  ``noise_mean``: over the records to 15 ms,
    ``noise_late`` after.  Energies at the last record, as shares of what was supplied: the energy
    at the start and the work of the punch.
    """
    mine = history[history["key"] == run["key"]].sort_values("time [s]")
    if len(mine) == 0:
        return {}
    time = mine["time [s]"].to_numpy()
    first = (time > 0.0) & (time <= COMPARED + _SAME)
    out = _at_comparison(mine[np.isclose(time, COMPARED, rtol=0.0, atol=_SAME)])
    out |= {
        "noise_mean": _mean(mine["noise"].to_numpy()[first]),
        "noise_late": _mean(mine["noise"].to_numpy()[time > COMPARED + _SAME]),
        "J_min": float(mine["J_min"].min()),
        "J_max": float(mine["J_max"].max()),
        "momentum_drift": float(
            (mine["linear_drift [kg m/s]"] / mine["linear_scale [kg m/s]"].max()).max()
        ),
    } | _energies(mine)
    references = select(runs, press=run["press"], method=B_BAR.name)
    if len(references):
        finest = references.loc[references["cells"].idxmax()]
        same = select(references, lattice=run["lattice"])
        out["top_rms"] = _rms_difference(mine[first], history[history["key"] == finest["key"]])
        out["profile_finest"] = _profile_difference(profile, run["key"], finest["key"])
        if len(same):
            out["profile_same"] = _profile_difference(profile, run["key"], same["key"].iloc[0])
    return out


def _at_comparison(row: pd.DataFrame) -> dict[str, float]:
    columns = {
        "top_low": "top_low [m]",
        "top_high": "top_high [m]",
        "pressure_1": "pressure_1 [Pa]",
        "pressure_99": "pressure_99 [Pa]",
        "noise": "noise",
        "floor_impulse": "reaction_impulse_Z-_z [N s]",
        "press_impulse": "reaction_impulse_pressed_z [N s]",
    }
    if len(row) == 0:
        return {}
    return {name: float(row[c].iloc[0]) for name, c in columns.items() if c in row}


def _energies(mine: pd.DataFrame) -> dict[str, float]:
    last = mine.iloc[-1]
    supplied = float(mine["total_energy [J]"].iloc[0] + last["work_constraint [J]"])
    parts = {
        "energy_kept": "total_energy [J]",
        "energy_D_p": "dissipation_p [J]",
        "energy_D_J": "dissipation_J [J]",
        "energy_projection": "work_projection [J]",
        "energy_rest": "energy_rest [J]",
    }
    return {name: float(last[column]) / supplied for name, column in parts.items()}


def _rms_difference(mine: pd.DataFrame, reference: pd.DataFrame) -> float:
    """Of both ends of the range, at instants that both runs have; ``nan`` if one is missing."""
    ends = ["top_low [m]", "top_high [m]"]
    ours, theirs = (
        frame.set_index((frame["time [s]"] / EVERY).round().astype(int))[ends]
        for frame in (mine, reference)
    )
    if len(ours) < round(COMPARED / EVERY) or not ours.index.isin(theirs.index).all():
        return float("nan")
    return float(np.sqrt(((ours - theirs.loc[ours.index]) ** 2).mean()).max())


def _profile_difference(profile: pd.DataFrame, key: str, reference: str) -> float:
    """Largest difference of heights of the same material points of the edge at 15 ms."""
    at = profile[np.isclose(profile["time"], COMPARED, rtol=0.0, atol=_SAME)]
    ours, theirs = (at[at["key"] == name].sort_values("X") for name in (key, reference))
    if len(ours) == 0 or len(theirs) == 0:
        return float("nan")
    between = np.interp(ours["X"], theirs["X"], theirs["z"])
    return float(np.max(np.abs(ours["z"].to_numpy() - between)))


def _mean(values: NDArray[np.float64]) -> float:
    return float(values.mean()) if len(values) else float("nan")
