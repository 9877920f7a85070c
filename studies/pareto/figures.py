"""Error against cost with every curve named where it ends, each figure made from the main table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from studies.convergence.figures import select
from studies.pareto.iso_error import ASKED
from studies.pareto.methods import COMPARED, DENSE, FEM, MIXED, PAPER, PLAIN
from studies.pareto.scenes import COLUMN, CUBE, RATIOS
from studies.report.plotting import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    panels,
    save_figure,
)

COLOURS = {MIXED: BLUE, DENSE: PURPLE, PAPER: GREEN, PLAIN: ORANGE, FEM: BLACK}
_MARKERS = {"{p,F}": "o", "{p,F,J}": "^", "{p,F,H,J}": "s", "displacement": "X"}
_AXES = {
    "cpu_s_per_s": "CPU seconds per physical second",
    "bytes": "memory held [MB]",
}
_MEASURES = {
    "momentum": "momentum error [-]", "stress": "stress error [-]",
    "twist_rms": "twist error, rms over peak [-]", "energy": "energy not kept [-]",
}  # fmt: skip
_TITLES = {CUBE: "swinging cube", COLUMN: "twisting column"}
#: Least distance of two names as a share of the height of a panel.
_APART = 0.055
#: Share of the width of a panel that the names take.
_NAMES = 0.36


def spread_out(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Positions in ``[low, high]`` near the wanted ones, in their order, at least ``apart``.

    Where there is no room they are evenly spaced.
    """
    order = np.argsort(wanted, kind="stable")
    free = np.clip(np.asarray(wanted, dtype=float)[order], low, high)
    step = min(apart, (high - low) / max(1, len(free) - 1))
    up = free.copy()
    for i in range(1, len(up)):
        up[i] = max(up[i], up[i - 1] + step)
    down = np.minimum(up, high)
    for i in range(len(down) - 2, -1, -1):
        down[i] = min(down[i], down[i + 1] - step)
    placed = np.empty(len(free))
    placed[order] = down
    return placed.tolist()


def panel(ax: Axes, runs: pd.DataFrame, cost: str, measure: str) -> None:
    """Error over cost of every method that was compared, named at its finest lattice."""
    scale = 1e-6 if cost == "bytes" else 1.0
    ends: list[tuple[str, str, float, float]] = []
    for method in COMPARED:
        run = select(runs, method=method.label).sort_values("particles")
        run = run[np.isfinite(run[measure]) & (run[measure] > 0.0) & (run[cost] > 0.0)]
        if len(run) == 0:
            continue
        colour = COLOURS[method.family]
        x, y = scale * run[cost], run[measure]
        marker = _MARKERS.get(method.setting["formulation"], "D")
        ax.plot(x, y, color=colour, marker=marker, markersize=4.0, linewidth=1.2)
        ends.append((method.label, colour, float(x.iloc[-1]), float(y.iloc[-1])))
    ax.set(xscale="log", yscale="log")
    for axis in (ax.xaxis, ax.yaxis):
        low, high = axis.get_view_interval()
        # Decades alone where there are many, else numbers between them too.
        axis.set_major_locator(LogLocator(subs=(1.0,) if high > 300.0 * low else (1.0, 2.0, 5.0)))
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    # What is drawn beside the curves must not move the limits that it is placed by.
    ax.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())
    if not ends:
        ax.text(0.5, 0.5, "no data", transform=ax.transAxes, ha="center", va="center")
        return
    _guides(ax)
    _name(ax, ends)


def _guides(ax: Axes) -> None:
    low, high = ax.get_ylim()
    for asked in ASKED:
        if low < asked < high:
            ax.axhline(asked, color="0.6", linewidth=0.7, linestyle=":", zorder=1)


def _name(ax: Axes, ends: list[tuple[str, str, float, float]]) -> None:
    """Names in a column right of the curves, each joined to the end of its curve."""
    low, high = np.log10(ax.get_xlim())
    ax.set_xlim(10.0**low, 10.0 ** (low + (high - low) / (1.0 - _NAMES)))
    bottom, top = np.log10(ax.get_ylim())
    heights = [(np.log10(y) - bottom) / (top - bottom) for *_, y in ends]
    places = spread_out(heights, _APART, 0.02, 0.98)
    to_share = ax.transAxes.inverted()
    for (label, colour, x, y), place in zip(ends, places, strict=True):
        start = to_share.transform(ax.transData.transform((x, y)))
        bend = 1.0 - _NAMES + 0.03
        ax.plot([start[0], bend, bend + 0.03], [start[1], place, place], transform=ax.transAxes,
                color=colour, linewidth=0.5, alpha=0.6, clip_on=False)  # fmt: skip
        ax.text(bend + 0.04, place, label, transform=ax.transAxes, color=colour, size=7.0,
                va="center", ha="left")  # fmt: skip


def figure(
    table: pd.DataFrame, shown: Sequence[tuple[str, str]], cost: str, stem: Path
) -> Path:
    """A row of panels for each ``(scene, measure)``, a column for each nu; gives ``stem``."""
    drawing, axes = panels(len(shown), len(RATIOS), width=4.6, height=3.4)
    for row, (scene, measure) in enumerate(shown):
        for column, nu in enumerate(RATIOS):
            ax: Any = axes[row, column]
            panel(ax, select(table, scene=scene, nu=nu), cost, measure)
            ax.set(
                title=f"{_TITLES[scene]}, nu = {nu:g}",
                xlabel=_AXES[cost] if row == len(shown) - 1 else "",
                ylabel=_MEASURES[measure],
            )
    return save_figure(drawing, stem)


def figures(table: pd.DataFrame, out: Path) -> dict[str, Path]:
    """``pareto`` (one measure a scene), and both measures of each scene by CPU time and memory."""
    first = [(CUBE, "momentum"), (COLUMN, "twist_rms")]
    drawn = {"pareto": figure(table, first, "cpu_s_per_s", out / "pareto")}
    for scene, measures in ((CUBE, ("momentum", "stress")), (COLUMN, ("twist_rms", "energy"))):
        shown = [(scene, measure) for measure in measures]
        for cost, name in (("cpu_s_per_s", "time"), ("bytes", "memory")):
            stem = f"{scene}_{name}"
            drawn[stem] = figure(table, shown, cost, out / stem)
    return drawn
