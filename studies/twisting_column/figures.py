"""Curves of the twisting column, each figure made from the study's tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from studies.convergence.figures import select
from studies.report.plotting import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    Curve,
    convergence_panel,
    outside_legend,
    panels,
    save_figure,
)
from studies.twisting_column import outside
from studies.twisting_column.methods import (
    DISPLACEMENT,
    FEM,
    FORCE,
    H1,
    H6,
    LITERAL,
    NO_TAU_P,
    TOOLKIT,
    common_lattice,
    finest,
    lattice,
    usual,
)
from studies.twisting_column.requirements import rest_by_step

#: Lines of the methods, the same in all figures of the study.
LOOKS: dict[str, dict[str, Any]] = {
    H1: {"color": BLUE, "marker": "o"},
    H6: {"color": SKY, "marker": "s", "linestyle": "--"},
    TOOLKIT: {"color": GREEN, "marker": "^"},
    NO_TAU_P: {"color": GREEN, "marker": "v", "linestyle": ":"},
    LITERAL: {"color": VERMILION, "marker": "o", "markerfacecolor": "white"},
    FORCE: {"color": PURPLE, "marker": "P", "linestyle": "-."},
    DISPLACEMENT: {"color": ORANGE, "marker": "X", "linestyle": ":"},
    FEM: {"color": BLACK, "marker": "D", "linestyle": "-."},
}
_REFERENCE = {"color": BLACK, "linewidth": 2.0, "linestyle": "--"}
_SHADES = {
    3: "#9ecae1", 4: "#6baed6", 5: "#4292c6", 6: "#0072B2", 8: "#08519c", 10: "#08306b",
}  # fmt: skip


def _line(ax: Axes, run: pd.DataFrame, column: str, label: str, look: dict[str, Any]) -> None:
    every = max(1, len(run) // 8)
    ax.plot(1e3 * run["time [s]"], run[column], label=label, markevery=every, **look)


def _with_reference(history: pd.DataFrame) -> pd.DataFrame:
    """Every run's ``twist off [rad]``: its twist less that of the finest elements."""
    twist = _finest_twist(history)
    there = history["time [s]"].round(6).map(twist)
    return history.assign(**{"twist off [rad]": history["twist [rad]"] - there})


def _finest_twist(history: pd.DataFrame) -> dict[float, float]:
    finest_run = select(usual(history), label=FEM, cells=finest(history))
    return dict(zip(finest_run["time [s]"].round(6), finest_run["twist [rad]"], strict=True))


def histories_figure(history: pd.DataFrame, table: pd.DataFrame, stem: Path) -> Path:
    """Twist and height over time: lattices of the paper's H1, methods on one lattice."""
    figure, axes = panels(3, 2, width=4.4, height=2.5)
    history = _with_reference(usual(history))
    cells, most = common_lattice(table), finest(history)
    known = {ms: outside.twist(ms) for ms in outside.INSTANTS}
    elements = _finest_twist(history)
    there = {ms: elements.get(round(1e-3 * ms, 6), float("nan")) for ms in known}
    marks = {
        "twist [rad]": [known[ms].value for ms in known],
        "twist off [rad]": [known[ms].value - there[ms] for ms in known],
    }
    for row, (column, name) in enumerate(
        (("twist [rad]", "twist of the top [rad]"),
         ("twist off [rad]", "twist less that of finest B-bar [rad]"),
         ("height [m]", "height of the top's centre [m]"))
    ):  # fmt: skip
        left, right = axes[row]
        for number, run in select(history, label=H1).groupby("cells"):
            look = {"color": _SHADES.get(int(number), BLUE)}
            _line(left, run, column, f"{H1}, {lattice(int(number))}", look)
        for label in LOOKS:
            run = select(history, label=label, cells=cells)
            if len(run):
                _line(right, run, column, f"{label}, {lattice(cells)}", LOOKS[label])
        run = select(history, label=FEM, cells=most)
        _line(left, run, column, f"{FEM}, {lattice(most)} (finest)", _REFERENCE)
        for ax in (left, right):
            if column in marks:
                ax.plot(list(known), marks[column], "x", color=BLACK, markersize=7,
                        label=outside.NAME, zorder=5)  # fmt: skip
            ax.set(xlabel="time [ms]", ylabel=name)
    axes[0, 0].set_title("paper's H1 by lattice")
    axes[0, 1].set_title(f"methods at {lattice(cells)}")
    # Methods that make energy leave the picture; their values are in the table.
    for ax in axes[1]:
        ax.set_ylim(-0.25, 0.25)
    for ax in axes[2]:
        ax.set_ylim(5.8, 6.12)
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def energy_figure(history: pd.DataFrame, table: pd.DataFrame, stem: Path) -> Path:
    """The ledger of one run, energy kept by method, and the rest over the step."""
    figure, axes = panels(1, 3, width=3.6, height=3.0)
    cells = common_lattice(table)
    run = select(usual(history), label=H1, cells=cells)
    energy = run["total_energy [J]"].iloc[0]
    parts = {
        "kinetic": run["kinetic_energy [J]"],
        "strain, deviatoric": run["deviatoric_energy [J]"],
        "strain, volumetric": run["volumetric_energy [J]"],
        "dissipated by D(p)": -run["dissipation_p [J]"],
        "dissipated by D(J)": -run["dissipation_J [J]"],
    }
    axes[0, 0].stackplot(
        1e3 * run["time [s]"], [100.0 * part / energy for part in parts.values()],
        labels=list(parts), colors=["#6baed6", "#c6dbef", GREEN, ORANGE, VERMILION],
    )  # fmt: skip
    axes[0, 0].set(
        title=f"{H1}, {lattice(cells)}", xlabel="time [ms]", ylabel="share of E0 [%]", ylim=(0, 104)
    )
    for label in LOOKS:
        one = select(usual(history), label=label, cells=cells)
        if len(one):
            total = one["total_energy [J]"]
            kept = one.assign(share=100.0 * total / total.iloc[0])
            _line(axes[0, 1], kept, "share", label, LOOKS[label])
    axes[0, 1].set(
        title=f"energy kept at {lattice(cells)}", xlabel="time [ms]", ylabel="E / E0 [%]",
        ylim=(95.0, 106.0),
    )  # fmt: skip
    curves = []
    for label in (H1, H6, TOOLKIT, NO_TAU_P):
        rest = rest_by_step(table, label)
        curves.append(Curve(label, rest.index.tolist(), rest.tolist(), LOOKS[label]))
    convergence_panel(
        axes[0, 2], curves, title="4x19x4, tau in seconds kept", x_label="CFL number",
        y_label="largest |rest| / E0", slopes=(2, 3),
    )  # fmt: skip
    marks = [0.075, 0.15, 0.3, 0.6]
    axes[0, 2].xaxis.set_major_locator(FixedLocator(marks))
    axes[0, 2].set_xticklabels([f"{cfl:g}" for cfl in marks])
    outside_legend(figure, axes.flat, columns=5)
    return save_figure(figure, stem)


def accuracy_figure(table: pd.DataFrame, stem: Path) -> Path:
    """Distance of positions and difference of pressures from the finest elements, over spacing."""
    figure, axes = panels(1, 3, width=3.4, height=3.0)
    part = usual(table)
    for ax, column, name in (
        (axes[0, 0], "position_rms", "rms distance of positions [m]"),
        (axes[0, 1], "pressure_rms", "relative rms difference of pressure"),
        (axes[0, 2], "mean_rms", "relative rms difference of mean pressure"),
    ):
        curves = []
        for label in (H1, H6, TOOLKIT, LITERAL, FEM):
            run = select(part, label=label)
            spacing = (1.0 / run["cells"]).tolist()
            curves.append(Curve(label, spacing, run[column].tolist(), LOOKS[label]))
        convergence_panel(ax, curves, x_label="spacing [m]", y_label=name, slopes=(1, 2))
    axes[0, 0].set_title("positions at 0.1 s")
    axes[0, 1].set_title("pressure at 0.1 s, Y > 0.5 m")
    axes[0, 2].set_title("its mean over the next 10 ms")
    outside_legend(figure, axes.flat, columns=5)
    return save_figure(figure, stem)
