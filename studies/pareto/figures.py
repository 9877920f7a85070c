"""Error against cost, drawn and tabulated, each made from the tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from studies.engine.plotting import outside_legend, panels
from studies.engine.results import Results
from studies.measures.tables import select
from studies.pareto.iso_error import ASKED, DECIDED, NEITHER, OPEN, UNSURE, medians
from studies.pareto.methods import front
from studies.pareto.problems import CUBE, PROBLEMS

_AXES = {"cpu_s_per_s": "CPU seconds per physical second", "bytes": "memory held [MB]"}
_MEASURES = {
    "momentum": "momentum error [-]", "stress": "stress error [-]",
    "twist_rms": "twist error, rms over peak [-]", "energy": "energy not kept [-]",
    "frequency": "frequency error [-]", "pulse": "velocity error [-]",
}  # fmt: skip


def panel(ax: Axes, runs: pd.DataFrame, cost: str, measure: str, nu: float) -> None:
    """Error over cost of the methods of the front; dotted: the errors that are asked for."""
    scale = 1e-6 if cost == "bytes" else 1.0
    for method in front(nu):
        run = select(runs, method=method.name).sort_values("particles")
        run = run[np.isfinite(run[measure]) & (run[measure] > 0.0) & (run[cost] > 0.0)]
        if len(run):
            ax.plot(scale * run[cost], run[measure], label=method.name, **method.look)
    if not ax.lines:
        ax.text(0.5, 0.5, "not run", transform=ax.transAxes, ha="center", va="center")
        ax.set(xticks=[], yticks=[])
        return
    ax.set(xscale="log", yscale="log")
    for axis in (ax.xaxis, ax.yaxis):
        low, high = axis.get_view_interval()
        # Decades alone where there are many, else numbers between them too.
        axis.set_major_locator(LogLocator(subs=(1.0,) if high > 300.0 * low else (1.0, 2.0, 5.0)))
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    low, high = ax.get_ylim()
    for asked in ASKED:
        if low < asked < high:
            ax.axhline(asked, color="0.6", linewidth=0.7, linestyle=":", zorder=1)


def drawing(shown: Sequence[tuple[str, str]], cost: str, results: Results) -> Figure:
    """A row of panels for each ``(scene, measure)``, a column for each Poisson's ratio."""
    table = results.tables["table"]
    ratios = sorted({nu for scene, _ in shown for nu in PROBLEMS[scene].nus})
    figure, axes = panels(len(shown), len(ratios), width=4.2, height=3.6)
    for row, (scene, measure) in enumerate(shown):
        for column, nu in enumerate(ratios):
            ax: Any = axes[row, column]
            if nu not in PROBLEMS[scene].nus:
                ax.set_axis_off()
                continue
            panel(ax, select(table, scene=scene, nu=nu), cost, measure, nu)
            ax.set(
                title=f"{PROBLEMS[scene].title}, nu = {nu:g}",
                xlabel=_AXES[cost] if row == len(shown) - 1 else "",
                ylabel=_MEASURES[measure],
            )
    outside_legend(figure, axes.flat)
    return figure


# --- tables of the report: what is compared, a column a method ------------------------------------


def decided_rows(compared: pd.DataFrame) -> pd.DataFrame:
    """Comparisons that came to something."""
    shown = compared[~compared["outcome"].isin((NEITHER, OPEN, UNSURE))]
    return shown.assign(scene=shown["scene"].map(_title))


def of_each(by_name: pd.DataFrame) -> pd.DataFrame:
    """Methods of which a cost can be compared, from the lowest median to the highest."""
    return by_name[by_name["decided"] > 0].sort_values("median", kind="stable")


def by_error(alone: pd.DataFrame) -> pd.DataFrame:
    """A row per scene, nu, measure and error, a column per method of the front: CPU over FEM's."""
    shown = _of_front(alone[alone["outcome"].isin((*DECIDED, OPEN))])
    sign = {"at most": "≤ ", "at least": "≥ ", "both bounds": "? "}
    said = [
        f"{sign.get(bound, '')}{ratio:.2g}"
        for bound, ratio in zip(shown["bound"], shown["cpu_ratio"], strict=True)
    ]
    wide = _wide(shown.assign(value=said), ["scene", "nu", "measure", "asked"])
    return wide.rename(columns={"measure": "of", "asked": "error"})


def by_scene(alone: pd.DataFrame) -> pd.DataFrame:
    """A row per scene and nu, a column per method of the front: the median of its CPU ratios."""
    found = _of_front(medians(alone, by=("scene", "nu", "method")))
    known = found[found["decided"] > 0]
    return _wide(known.assign(value=known["median"]), ["scene", "nu"])


def at_cost(errors: pd.DataFrame) -> pd.DataFrame:
    """A row per scene, nu, measure and lattice of B-bar elements, a column per method."""
    shown = errors.assign(value=errors["error"])
    wide = _wide(shown, ["scene", "nu", "measure", "cells", "cpu_s_per_s"])
    return wide.rename(columns={"measure": "of", "cells": "1/h", "cpu_s_per_s": "CPU s/s"})


def _title(scene: str) -> str:
    return PROBLEMS[scene].title


def _of_front(frame: pd.DataFrame) -> pd.DataFrame:
    names = [method.name for nu in PROBLEMS[CUBE].nus for method in front(nu)]
    return frame[frame["method"].isin(names)]


def _wide(frame: pd.DataFrame, index: list[str]) -> pd.DataFrame:
    """``value`` by method, in the order of the problems and in that in which methods come first."""
    order = {name: place for place, name in enumerate(PROBLEMS)}
    sorted_frame = frame.sort_values("scene", key=lambda scene: scene.map(order), kind="stable")
    named = sorted_frame.assign(scene=sorted_frame["scene"].map(_title))
    wide = named.pivot(index=index, columns="method", values="value")
    rows = named[index].drop_duplicates()
    columns = list(dict.fromkeys(named["method"]))
    return wide.reindex(pd.MultiIndex.from_frame(rows))[columns].reset_index()
