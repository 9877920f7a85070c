"""Error against cost, each figure made from the main table."""

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
from studies.pareto.iso_error import ASKED
from studies.pareto.methods import front
from studies.pareto.problems import PROBLEMS

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
