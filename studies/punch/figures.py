"""Curves of the punch test: pressure noise, top face, its height over time and over spacing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from studies.convergence.figures import select
from studies.harness.results import Results
from studies.punch.cases import COMPARED
from studies.punch.methods import (
    DISPLACEMENT,
    FEM,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    TAU_P,
    TOOLKIT,
    WIDE,
    WIDE_NO_TAU_P,
    toolkit,
    whole_tau_F,
    without_tau_F,
)
from studies.punch.pictures import READINGS, one_run
from studies.report.plotting import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    outside_legend,
    panels,
    save_figure,
)

#: Heights of the top face at 15 ms [m] by an independent hexahedral finite element code.
INDEPENDENT = {"initial": (0.455, 0.541), "held": (0.350, 0.744)}
LOOKS: dict[str, dict[str, Any]] = {
    FEM: {"color": BLACK, "linestyle": "-."},
    # Displacement SPH and {p,F,H,J} without SUPG are the same to round-off: one wide, one thin.
    DISPLACEMENT: {"color": ORANGE, "linewidth": 2.8, "alpha": 0.6},
    GALERKIN: {"color": PURPLE, "linewidth": 0.9},
    H6_NO_TAU_P: {"color": SKY},
    H6: {"color": GREEN, "linestyle": "--"},
    H1: {"color": BLUE},
    TOOLKIT: {"color": VERMILION},
}


def noise_figure(results: Results, stem: Path) -> Path:
    """Noise over ``tau_p`` (above) and over time (below), both readings; gives ``stem``."""
    table, history = results.tables["table"], results.tables["history"]
    figure, axes = panels(2, 2, width=3.6, height=2.7)
    for column, press in enumerate(READINGS):
        _noise_over_tau_p(axes[0, column], table, press)
        ax = axes[1, column]
        for method in (DISPLACEMENT, GALERKIN, H6_NO_TAU_P, H6, H1, TOOLKIT, FEM):
            _over_time(ax, table, history, press, method, "noise", 1.0)
        ax.set(title=f"{press}: over time", xlabel="time [ms]", ylabel="pressure noise [-]")
        ax.set_ylim(bottom=0.0)
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def _noise_over_tau_p(ax: Axes, table: pd.DataFrame, press: str) -> None:
    families: list[tuple[str, list[tuple[float, str]], str, dict[str, Any]]] = [
        ("{p,F,J} by default", [(t, toolkit(t)) for t in TAU_P], "Consistent",
         {"color": VERMILION, "marker": "o"}),
        ("{p,F,J} H1, τ_F = dt", [(t, whole_tau_F(t)) for t in TAU_P], "Consistent",
         {"color": BLUE, "marker": "^"}),
        ("{p,F,J} H1, τ_F = 0", [(t, without_tau_F(t)) for t in TAU_P], "Consistent",
         {"color": BLUE, "marker": "^", "linestyle": "--", "markerfacecolor": "white"}),
        ("{p,F,J} H1, τ_F = dt, Literal", [(t, whole_tau_F(t)) for t in TAU_P], "Literal",
         {"color": BLACK, "marker": "^", "linestyle": ":"}),
        ("{p,F,H,J} H6, τ_F = 0.5 dt", [(0.0, H6_NO_TAU_P), (0.1, H6)], "Consistent",
         {"color": GREEN, "marker": "s"}),
        ("the same, support 2 dx", [(0.0, WIDE_NO_TAU_P), (0.1, WIDE)], "Consistent",
         {"color": GREEN, "marker": "s", "linestyle": "--", "markerfacecolor": "white"}),
    ]  # fmt: skip
    for label, members, operator, look in families:
        found = [(tau, one_run(table, press, method, operator)) for tau, method in members]
        points = [(tau, run["noise_mean"].iloc[0]) for tau, run in found if len(run)]
        if points:
            ax.plot(*zip(*points, strict=True), label=label, **look)
    ax.set(
        title=f"{press}: mean of 0.5 to 15 ms", xlabel="τ_p / dt [-]", ylabel="pressure noise [-]"
    )
    ax.set_ylim(bottom=0.0)


def _over_time(
    ax: Axes,
    table: pd.DataFrame,
    history: pd.DataFrame,
    press: str,
    method: str,
    column: str,
    factor: float,
    level: int = 0,
    **look: Any,
) -> None:
    run = one_run(table, press, method, level=level)
    if len(run):
        mine = history[history["key"] == run["key"].iloc[0]]
        # At the start there is no pressure yet, and noise is a ratio of nothings.
        mine = mine[mine["time [s]"] > 0.0] if column == "noise" else mine
        label = method if level == 0 else f"{method}, {run['lattice'].iloc[0]}"
        ax.plot(1e3 * mine["time [s]"], factor * mine[column], label=label, **LOOKS[method] | look)


def profile_figure(results: Results, stem: Path) -> Path:
    """The edge of the top face at 15 ms, and where it is against the finest elements."""
    table, profile = results.tables["table"], results.tables["profile"]
    at = profile[np.isclose(profile["time"], COMPARED)]
    figure, axes = panels(2, 2, width=3.6, height=2.6)
    for column, press in enumerate(READINGS):
        elements = select(table, press=press, method=FEM)
        if len(elements) == 0:
            continue
        finest = elements.loc[elements["cells"].idxmax()]
        reference = at[at["key"] == finest["key"]].sort_values("X")
        above, below = axes[:, column]
        for edge in INDEPENDENT[press]:
            above.axhline(edge, color="0.6", linewidth=0.8, linestyle="--")
        for method in (DISPLACEMENT, H6, H1, TOOLKIT, FEM):
            run = one_run(table, press, method)
            mine = at[at["key"] == run["key"].iloc[0]].sort_values("X") if len(run) else at[:0]
            if len(mine):
                look = LOOKS[method] | {"marker": "o", "markersize": 2.6}
                above.plot(mine["x"], mine["z"], label=method, **look)
                there = np.interp(mine["X"], reference["X"], reference["z"])
                below.plot(mine["X"], 1e3 * (mine["z"] - there), label=method, **look)
        above.plot(
            reference["x"], reference["z"], color="0.5", linewidth=2.6, alpha=0.5,
            label=f"B-bar FEM, finest ({'; '.join(_finest(table))})",
        )  # fmt: skip
        below.axhspan(-4.0, 4.0, color="0.9", zorder=0)
        above.set(title=f"{press}, 15 ms", xlabel="x [m]", ylabel="height of the top edge [m]")
        below.set(xlabel="X [m]", ylabel="height, less finest FEM [mm]")
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def _finest(table: pd.DataFrame) -> list[str]:
    found = [select(table, press=press, method=FEM).sort_values("cells") for press in READINGS]
    return [elements["lattice"].iloc[-1] for elements in found if len(elements)]


def height_figure(results: Results, stem: Path) -> Path:
    """Why one instant is a poor measure: the lowest height over time, and refined."""
    table, history = results.tables["table"], results.tables["history"]
    figure, axes = panels(1, 3, width=3.0, height=2.7)
    for method in (DISPLACEMENT, H6, H1, TOOLKIT, FEM):
        _over_time(axes[0, 0], table, history, "initial", method, "top_low [m]", 1.0)
        _over_time(axes[0, 1], table, history, "initial", method, "total_energy [J]", 1.0)
    axes[0, 0].axvline(1e3 * COMPARED, color="0.6", linewidth=0.8, linestyle="--")
    axes[0, 0].set(title="initial", xlabel="time [ms]", ylabel="lowest height [m]")
    axes[0, 1].set(title="initial", xlabel="time [ms]", ylabel="kinetic and strain energy [J]")
    ax = axes[0, 2]
    for method in (H6, H1, TOOLKIT, FEM):
        runs = select(table, press="initial", method=method)
        runs = runs[runs["operator"] != "Literal"].sort_values("cells")
        if len(runs):
            ax.plot(1.0 / runs["cells"], runs["top_low"], marker="o", label=method, **LOOKS[method])
    ax.axhline(INDEPENDENT["initial"][0], color="0.6", linewidth=0.8, linestyle="--")
    ax.set(title="initial, 15 ms", xlabel="spacing [m]", ylabel="lowest height [m]")
    ax.set_xlim(left=0.0)
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)
