"""Figures of the conservation study, made from its tables and stored frames."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from sphsolid.look.frame import Absent
from sphsolid.look.view import Around, angled_view
from studies.conservation.claims import ROUND_OFF
from studies.conservation.runs import END, LOAD_ENDS, SHOT_TIMES, block_key
from studies.engine.plotting import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    outside_legend,
    panels,
)
from studies.engine.results import Results, Tables
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, PAPER, SUPG
from studies.pictures.picture import Panel, Percentile, Picture, Plan

#: The paper's operator as printed is dashed, the consistent one is not.
PRINTED, CONSISTENT = "paper, {p,F}, H6, Literal", "paper, {p,F}, H6, Consistent"
LOOKS: dict[str, dict[str, Any]] = {
    PRINTED: PAPER.look | {"linestyle": "--", "markerfacecolor": "white"},
    CONSISTENT: PAPER.look,
    SUPG.name: SUPG.look,
    PACKAGE.name: PACKAGE.look,
    B_BAR.name: B_BAR.look | {"linestyle": "none", "markerfacecolor": "white"},
}


def _run(history: pd.DataFrame, method: str) -> pd.DataFrame:
    """The records of a method at the published spacing."""
    own = select(history, method=method, until=END)
    return select(own, spacing=own["spacing"].max())


def _lines(ax: Axes, history: pd.DataFrame, column: str, least: float = -np.inf) -> None:
    """A line a method; a value of exactly nothing has no place on a log axis."""
    for name, look in LOOKS.items():
        run = _run(history, name)
        every = max(1, len(run) // 10)
        ax.plot(run["time"], np.maximum(run[column], least), label=name, markevery=every, **look)


def _shade(axes: Axes) -> None:
    axes.axvspan(0.0, LOAD_ENDS, color="0.9", zorder=0)
    axes.text(
        0.5 * LOAD_ENDS, 0.98, "tractions", transform=axes.get_xaxis_transform(), ha="center",
        va="top", size=7.5, color="0.35",
    )  # fmt: skip
    axes.set(xlabel="time [s]")
    axes.set_xlim(left=0.0)


def momenta(results: Results) -> Figure:
    """Components of the angular momentum over time, and the linear momentum (as Fig. 7)."""
    figure, axes = panels(2, 2, width=3.6, height=2.4)
    history = results.tables["history"].copy()
    for axis, ax in zip("xyz", axes.flat, strict=False):
        history["shown"] = history[f"L_{axis}"] / 1e5
        _lines(ax, history, "shown")
        ax.set(ylabel=f"L_{axis} [1e5 kg m²/s]")
    last = axes[1, 1]
    _lines(last, history[history["time"] > 0.0], "linear", 1e-18)
    _round_off(last)
    last.set(yscale="log", ylabel="|Σ V p| / Σ V |p|  [-]", ylim=(1e-18, 1e-10))
    for ax in axes.flat:
        _shade(ax)
    outside_legend(figure, axes.flat, columns=2)
    return figure


def drift(results: Results) -> Figure:
    """Angular momentum that no load gave, with and without the projection, on a log axis."""
    figure, axes = panels(1, 1, width=5.6, height=3.2)
    ax = axes[0, 0]
    history = results.tables["history"]
    later = history[history["time"] > 0.0]
    _lines(ax, later, "angular", 1e-17)
    for name in (PRINTED, CONSISTENT):
        run = _run(later, f"{name}, no projection")
        look = LOOKS[name] | {"marker": "x", "markevery": max(1, len(run) // 10)}
        ax.plot(run["time"], run["angular"], label=f"{name}, no projection", **look)
    _round_off(ax)
    ax.set(yscale="log", ylabel="|drift of L| / Σ V |x| |p|  [-]", ylim=(5e-18, 3e-2))
    _shade(ax)
    outside_legend(figure, [ax], columns=2)
    return figure


def _round_off(ax: Axes) -> None:
    ax.axhline(ROUND_OFF, color="0.5", linewidth=0.8, linestyle=(0, (1, 2)))


_TERMS = (
    ("work", "work of the tractions", BLACK, "-"),
    ("kinetic", "kinetic energy", BLUE, "-"),
    ("deviatoric", "strain energy, deviatoric", VERMILION, "-"),
    ("volumetric", "strain energy, volumetric", ORANGE, "-"),
    ("dissipation", "dissipation", PURPLE, "--"),
    ("projection", "work of the projection", SKY, "--"),
    ("residual", "residual", GREEN, ":"),
)


def budget(results: Results) -> Figure:
    """Every term of the energy budget of the block, linear and logarithmic."""
    figure, axes = panels(2, 4, width=2.7, height=2.4)
    for j, method in enumerate((PRINTED, CONSISTENT, SUPG.name, PACKAGE.name)):
        run = _run(results.tables["history"], method)
        for name, label, colour, style in _TERMS:
            for i in (0, 1):
                values = run[name] / 1e3 if i == 0 else np.maximum(np.abs(run[name]), 1e-4)
                axes[i, j].plot(run["time"], values, style, color=colour, label=label)
        axes[0, j].set(title=method, ylabel="energy [kJ]")
        axes[1, j].set(yscale="log", ylabel="|energy| [J]", ylim=(1e-4, 2e5))
        for i in (0, 1):
            _shade(axes[i, j])
    outside_legend(figure, [axes[0, 0]], columns=4)
    return figure


def cube(results: Results) -> Figure:
    """What the energy budget leaves over against the CFL number, and energies over ten turns."""
    figure, axes = panels(1, 2, width=3.7, height=4.4)
    _left_over(axes[0, 0], results.tables["cube"])
    _energies(axes[0, 1], results.tables["cube"], results.tables["cube_history"])
    outside_legend(figure, axes.flat, columns=2)
    return figure


def _left_over(ax: Axes, table: pd.DataFrame) -> None:
    kept = table[(table["outcome"] == "kept") & (table["left_over"] > 0.0)]
    kept = kept.assign(group=kept["group"].replace("usual default", "default"))
    rows = (
        ("default", PACKAGE.look, PACKAGE.name),
        ("package", SUPG.look, SUPG.name),
        ("ladder", PAPER.look, "paper, {p,F}, H1, Consistent"),
        ("methods", PAPER.look | {"linestyle": ":"}, "paper, {p,F}, H1, Consistent, SSP-RK3"),
        ("methods", PAPER.look | {"linestyle": "--"},
         "paper, {p,F}, H1, Consistent, position Verlet"),
        ("elements", B_BAR.look, B_BAR.name),
    )  # fmt: skip
    for group, look, method in rows:
        runs = select(kept, group=group, method=method)
        # The coarsest filled, finer ones open, the finest small.
        for number, spacing in enumerate(sorted(set(runs["spacing"]), reverse=True)):
            part = select(runs, spacing=spacing).sort_values("cfl")
            more = {"markerfacecolor": "white", "markersize": 4.8 - number} if number else {}
            label = f"{method}, 1/{1.0 / spacing:.0f}"
            ax.plot(part["cfl"], part["left_over"], label=label, **look | more)
    ladder = kept[kept["group"] == "ladder"]
    if len(ladder):
        at = np.array([ladder["cfl"].min(), ladder["cfl"].max()])
        low = ladder["left_over"].min() / 3.0
        for order in (2, 3):
            line = low * (at / at[0]) ** order
            ax.plot(at, line, ":", color="0.6", linewidth=0.8)
            ax.annotate(f"slope {order}", (at[-1], line[-1]), color="0.4", size=7.5, va="top")
    ax.set(
        xscale="log", yscale="log", xlabel="CFL number [-]",
        ylabel="|residual + projection| / initial energy [-]", title="spinning cube, energy budget",
    )  # fmt: skip
    marks = [0.075, 0.15, 0.3, 0.6]
    ax.xaxis.set_major_locator(FixedLocator(marks))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticklabels([f"{cfl:g}" for cfl in marks])


def _energies(ax: Axes, table: pd.DataFrame, history: pd.DataFrame) -> None:
    ladder = select(table, group="ladder", cfl=0.3)
    spacing = 0.125 if (ladder["spacing"] == 0.125).any() else 0.25
    usual = "paper, {p,F}, H1, Consistent"
    shown = ((usual, spacing, 0.3, PAPER.look), (B_BAR.name, spacing, 0.6, B_BAR.look))
    for method, h, cfl, look in shown:
        run = select(history, method=method, spacing=h, cfl=cfl, spin=table["spin"].max())
        for name, line in (("total", "-"), ("kinetic", "--"), ("strain", ":")):
            look = look | {"linestyle": line, "markevery": 16}
            ax.plot(run["turn"], run[name], label=f"{method}: {name}", **look)
    small = f"{usual}, h_over_dx = 0.77"
    run = select(history, method=small, cfl=0.3)
    look = PAPER.look | {"linewidth": 0.8, "markerfacecolor": "white", "markevery": 16}
    ax.plot(run["turn"], run["total"], label=f"{small}: total", **look)
    ax.set(
        xlabel="turns at the initial speed [-]", ylabel="energy / initial energy [-]",
        title=f"energies, h = 1/{1.0 / spacing:.0f}, CFL 0.3 (B-bar 0.6)", ylim=(0.0, 1.45),
    )  # fmt: skip


def _plan(tables: Tables, number: int) -> Plan:
    """Rows of methods over time, on the coarser mesh or the finer one; nothing where not run."""
    spacings = sorted(set(tables["history"]["spacing"]), reverse=True)
    if number >= len(spacings):
        return [[Absent("", 0.0)]]
    return [[Panel(method, block_key(method, spacings[number]), t) for t in SHOT_TIMES]
            for method in LOOKS]  # fmt: skip


#: The block over time, pressure as means over cells.
PICTURES = tuple(
    Picture(
        partial(_plan, number=number), colours=Percentile(98.0), window=Around(follow=True),
        view=angled_view(up="y", azimuth=-35.0, elevation=18.0),
    )
    for number in (0, 1)
)  # fmt: skip
FIGURES = {
    "momenta": momenta,
    "drift": drift,
    "budget": budget,
    "cube": cube,
    "sequence_1": PICTURES[0].draw,
    "sequence_2": PICTURES[1].draw,
}
