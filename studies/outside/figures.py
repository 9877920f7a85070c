"""Figures: every sequence against CalculiX, and the beam beside particle codes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from studies.engine.plotting import BLACK, BLUE, outside_legend, panels
from studies.engine.results import Results, Tables
from studies.measures.tables import select
from studies.methods import METHODS
from studies.outside.claims import CYLINDER, PLANE, TIP
from studies.outside.sequences import CALCULIX, sequence

Array = NDArray[np.float64]
#: Codes of the published figures that are drawn.
AUTHORS, PARTICLE_CODE = "Turek and Hron", "TrixiParticles.jl"
CALCULIX_LOOK = {"color": BLUE, "marker": "*", "linestyle": ":"}
_TWIST = "twist at 100 ms [rad]"


def main_quantity(calculix: pd.DataFrame, problem: str) -> str:
    """The one that is drawn: the first that a problem reads, or of a column its last twist."""
    quantities = list(select(calculix, problem=problem)["quantity"].drop_duplicates())
    return _TWIST if _TWIST in quantities else str(quantities[0])


def sequences_figure(results: Results) -> Figure:
    """Difference from CalculiX's limit over cells, one panel a problem."""
    calculix, ours = results.tables["calculix"], results.tables["ours"]
    problems = list(calculix["problem"].drop_duplicates())
    columns = 3
    figure, axes = panels(math.ceil(len(problems) / columns), columns, width=2.6, height=2.2)
    for ax, problem in zip(axes.flat, problems, strict=False):
        quantity = main_quantity(calculix, problem)
        known = sequence(calculix, problem, quantity)
        assert known is not None
        _line(ax, known.levels * 2, known.values, known.limit.value, CALCULIX, CALCULIX_LOOK)
        for method in ours["method"].drop_duplicates():
            own = sequence(select(ours, method=method), problem, quantity)
            if own is not None:
                look = METHODS[method].look
                _line(ax, own.levels, own.values, known.limit.value, method, look)
        ax.axhspan(-1.0, 1.0, color="0.9", zorder=0)
        ax.set_title(f"{problem}\n{quantity}", fontsize=6.5)
        ax.set_xscale("log")
        ax.set_xticks(sorted({*known.levels * 2, *_levels(ours, problem)}))
        ax.set_xticks([], minor=True)
        ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    for ax in axes.flat[len(problems) :]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("difference [%]")
    for ax in axes.flat[max(0, len(problems) - columns) : len(problems)]:
        ax.set_xlabel("spacings of points along a length")
    outside_legend(figure, axes.flat, columns=4)
    return figure


def _levels(ours: pd.DataFrame, problem: str) -> set[float]:
    return set(select(ours, problem=problem)["level"].astype(float))


def _line(
    ax: Axes, levels: Array, values: Array, limit: float, label: str, look: dict[str, str]
) -> None:
    ax.plot(levels, 100.0 * (values / limit - 1.0), label=label, markersize=4, **look)  # type: ignore[arg-type]


def beam_figure(results: Results) -> Figure:
    """The lowest place of the tip over points across the height, with either clamp."""
    tables = results.tables
    particles = tables["particles"]
    figure, axes = panels(1, 2, width=3.2)
    for ax, problem in zip(axes.flat, (PLANE, CYLINDER), strict=True):
        ticks = set[int]()
        for code, look, points, values in _beam_curves(tables, problem):
            ax.plot(points, values, label=code, markersize=4, **look)
            ticks |= {int(n) for n in points}
        authors = select(particles, problem=problem, code=AUTHORS)
        if len(authors):
            ends = authors["low"].min(), authors["high"].max()
            ax.axhspan(*ends, color=BLACK, alpha=0.4, linewidth=1.0, label=AUTHORS)
        ax.set(title=problem, xlabel="points across the height", xscale="log")
        ax.set_xticks(sorted(ticks), [str(n) for n in sorted(ticks)])
        ax.set_xticks([], minor=True)
    axes.flat[0].set_ylabel("least u_y of the tip [mm]")
    outside_legend(figure, axes.flat, columns=3)
    return figure


def _beam_curves(
    tables: Tables, problem: str
) -> Iterator[tuple[str, dict[str, str], Array, Array]]:
    """Code, look, points across the height and places of the tip: every code that has some."""
    theirs = sequence(tables["calculix"], problem, TIP)
    if theirs is not None:
        yield CALCULIX, CALCULIX_LOOK, 2 * theirs.levels + 1, theirs.values
    for method in tables["ours"]["method"].drop_duplicates():
        own = sequence(select(tables["ours"], method=method), problem, TIP)
        if own is not None:
            yield method, METHODS[method].look, own.levels + 1, own.values
    others = select(tables["particles"], problem=problem, code=PARTICLE_CODE)
    if len(others):
        look = {"color": "0.5", "marker": "x", "linestyle": "--"}
        yield PARTICLE_CODE, look, others["points"].to_numpy(), others["low"].to_numpy()


FIGURES = {"sequences": sequences_figure, "beam": beam_figure}
