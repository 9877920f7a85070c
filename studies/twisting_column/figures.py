"""Figures of the twisting column: curves made from the study's tables, pictures from its frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from sphsolid.look.panels import Layout
from studies.engine.plotting import (
    BLACK,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    Curve,
    convergence_panel,
    outside_legend,
    panels,
)
from studies.engine.results import Results, Tables
from studies.measures.tables import select
from studies.methods import Method
from studies.pictures.picture import Panel, Percentile, Picture, Plan
from studies.twisting_column import outside
from studies.twisting_column.claims import residual_by_step
from studies.twisting_column.methods import (
    CLASSICAL,
    DEFAULT,
    FEM,
    H1,
    H6,
    LITERAL,
    NO_TAU_P,
    PAPER_LATTICES,
    PLAIN,
    SHOWN,
    common_lattice,
    finest_of,
    usual,
)
from studies.twisting_column.outside import has_limit, twist_sequence
from studies.twisting_column.runs import END, INSTANTS, lattice, shot_key

#: Percentiles 1 and 99 of the pressure [Pa] at 0.1 s at the centroids of an independent explicit
#: Q1-P0 hexahedral code, 12x72x12 cells.
INDEPENDENT_PRESSURE = (-2.05e6, 1.83e6)
_MPA = 1.0e-6
#: Where on the axis of ``h^2`` [m^2] the limits are, side by side about it.
_LIMITS = -0.012


def _line(ax: Axes, run: pd.DataFrame, column: str, label: str, look: dict[str, Any]) -> None:
    every = max(1, len(run) // 8)
    ax.plot(1e3 * run["time [s]"], run[column], label=label, markevery=every, **look)


def twist_by_lattice(results: Results) -> Figure:
    """Signed error of the twist over ``h^2``; at the left edge the limit and how well it is known.

    Nothing is hidden by a logarithm: where a line crosses zero a lattice is right by chance.
    """
    figure, axes = panels(1, 2, width=4.2, height=3.1)
    runs = usual(results.tables["table"])
    methods = [one for one in (H1, H6, DEFAULT, PLAIN, LITERAL, FEM) if has_limit(runs, one.name)]
    for ax, ms in zip(axes.flat, (60, 100), strict=True):
        known = outside.twist(ms)
        share = 100.0 * known.within / known.value
        ax.axhspan(-share, share, color="0.85", label=outside.NAME, zorder=0)
        ax.axhline(0.0, color="0.5", linewidth=0.7)
        cells: set[int] = set()
        for number, method in enumerate(methods):
            found = twist_sequence(runs, method.name, ms)
            cells |= set(found.cells)
            h2 = 1.0 / np.array(found.cells) ** 2
            ax.plot(h2, 100.0 * found.errors, label=method.name, **method.look)
            # Side by side, left of no spacing: limits of several methods are near each other.
            ax.errorbar(
                2.0 * _LIMITS * (1 + number) / (1 + len(methods)), 100.0 * found.limit_error,
                100.0 * found.limit.within / known.value, capsize=2.0, color=method.colour,
                marker=method.marker,
            )  # fmt: skip
        marks = sorted(cells & {3, 4, 5, 6, 10})
        ax.xaxis.set_major_locator(FixedLocator([_LIMITS, *(1.0 / n**2 for n in marks)]))
        ax.set_xticklabels(["limit", *(f"1/{n}" for n in marks)])
        ax.axvline(0.0, color="0.5", linewidth=0.7)
        ax.set(title=f"{ms} ms", xlabel="spacing [m], to scale in its square",
               ylabel="error of the twist [%]")  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return figure


def histories(results: Results) -> Figure:
    """Twist and height over time: lattices of the paper's H1, methods on one lattice."""
    figure, axes = panels(3, 2, width=4.4, height=2.5)
    history = usual(results.tables["history"]).copy()
    cells, most = common_lattice(results.tables["table"]), finest_of(history, FEM.name)
    finest = select(history, method=FEM.name, cells=most)
    there = dict(zip(finest["time [s]"].round(6), finest["twist [rad]"], strict=True))
    history["off"] = history["twist [rad]"] - history["time [s]"].round(6).map(there)
    known = np.array([outside.twist(ms).value for ms in INSTANTS])
    marks = {
        "twist [rad]": known,
        "off": known - [there.get(round(1e-3 * ms, 6), np.nan) for ms in INSTANTS],
    }
    lattices = sorted(set(select(history, method=H1.name)["cells"]))
    for (column, name), (left, right) in zip(
        (("twist [rad]", "twist of the top [rad]"),
         ("off", "twist less finest B-bar [rad]"),
         ("height [m]", "height of the top [m]")), axes, strict=True,
    ):  # fmt: skip
        for number, n in enumerate(lattices):
            run = select(history, method=H1.name, cells=n)
            # From light to dark as the lattice gets finer.
            look = {"color": H1.colour, "alpha": (number + 1.0) / len(lattices)}
            _line(left, run, column, f"paper's H1 by lattice: {lattice(int(n))}", look)
        for method in SHOWN:
            run = select(history, method=method.name, cells=cells)
            if len(run):
                _line(right, run, column, f"{method.name}, {lattice(cells)}", method.look)
        reference = {"color": FEM.colour, "linewidth": 2.0, "linestyle": "--"}
        run = select(history, method=FEM.name, cells=most)
        _line(left, run, column, f"{FEM.name}, {lattice(most)} (finest)", reference)
        for ax in (left, right):
            if column in marks:
                ax.plot(INSTANTS, marks[column], "x", color=BLACK, markersize=7,
                        label=outside.NAME, zorder=5)  # fmt: skip
            ax.set(xlabel="time [ms]", ylabel=name)
    axes[0, 0].set_title("paper's H1 by lattice")
    axes[0, 1].set_title(f"methods at {lattice(cells)}")
    # Methods that make energy leave the picture; their values are in the table.
    for row, window in ((1, (-0.25, 0.25)), (2, (5.8, 6.12))):
        for ax in axes[row]:
            ax.set_ylim(*window)
    outside_legend(figure, axes.flat, columns=2)
    return figure


def energy(results: Results) -> Figure:
    """The energy budget of one run, energy kept by method, and the residual over the step."""
    figure, axes = panels(1, 3, width=3.6, height=3.0)
    table, history = results.tables["table"], usual(results.tables["history"])
    cells = common_lattice(table)
    run = select(history, method=H1.name, cells=cells)
    start = run["total_energy [J]"].iloc[0]
    parts = {
        "kinetic": run["kinetic_energy [J]"],
        "strain, deviatoric": run["deviatoric_energy [J]"],
        "strain, volumetric": run["volumetric_energy [J]"],
        "dissipated by D(p)": -run["dissipation_p [J]"],
        "dissipated by D(J)": -run["dissipation_J [J]"],
    }
    axes[0, 0].stackplot(
        1e3 * run["time [s]"], [100.0 * part / start for part in parts.values()],
        labels=list(parts), colors=[SKY, PURPLE, GREEN, ORANGE, VERMILION],
    )  # fmt: skip
    axes[0, 0].set(
        title=f"{H1.name}, {lattice(cells)}", xlabel="time [ms]", ylabel="share of E0 [%]",
        ylim=(0, 104),
    )  # fmt: skip
    for method in SHOWN:
        one = select(history, method=method.name, cells=cells)
        if len(one):
            total = one["total_energy [J]"]
            kept = one.assign(share=100.0 * total / total.iloc[0])
            _line(axes[0, 1], kept, "share", method.name, method.look)
    axes[0, 1].set(
        title=f"energy kept at {lattice(cells)}", xlabel="time [ms]", ylabel="E / E0 [%]",
        ylim=(95.0, 106.0),
    )  # fmt: skip
    curves = []
    for method in (H1, H6, DEFAULT, PLAIN, NO_TAU_P):
        residual = residual_by_step(table, method.name)
        curves.append(Curve(method.name, list(residual.index), list(residual), method.look))
    convergence_panel(
        axes[0, 2], curves, title="4x19x4, tau in seconds kept", x_label="CFL number",
        y_label="largest |residual| / E0", slopes=(2, 3),
    )  # fmt: skip
    marks = [0.075, 0.15, 0.3, 0.6]
    axes[0, 2].xaxis.set_major_locator(FixedLocator(marks))
    axes[0, 2].set_xticklabels([f"{cfl:g}" for cfl in marks])
    outside_legend(figure, axes.flat, columns=4)
    return figure


def accuracy(results: Results) -> Figure:
    """Distance of positions and difference of pressures from the finest elements, over spacing."""
    figure, axes = panels(1, 3, width=3.4, height=3.0)
    runs = usual(results.tables["table"])
    for ax, column, title, name in (
        (axes[0, 0], "position_rms", "positions at 0.1 s", "rms distance of positions [m]"),
        (axes[0, 1], "pressure_rms", "pressure at 0.1 s, Y > 0.5 m", "relative rms difference"),
        (axes[0, 2], "mean_rms", "its mean over the next 10 ms", "relative rms difference"),
    ):
        curves = []
        for method in (H1, H6, DEFAULT, PLAIN, LITERAL, FEM):
            run = select(runs, method=method.name)
            curves.append(Curve(method.name, 1.0 / run["cells"], run[column], method.look))
        convergence_panel(ax, curves, title=title, x_label="spacing [m]", y_label=name)
    outside_legend(figure, axes.flat, columns=3)
    return figure


def percentiles(results: Results) -> Figure:
    """Percentiles 1 and 99 at 0.1 s over the number of cells, by where they are taken."""
    figure, axes = panels(1, 4, width=2.7, height=3.0)
    runs = usual(results.tables["table"])
    for ax, (column, title) in zip(axes.flat, (
        ("pressure_", "where the law is evaluated"),
        ("pressure_cells_", "at cell centroids"),
        ("pressure_free_", "at centroids, Y > 0.5 m"),
        ("pressure_mean_", "there, mean over 100 .. 110 ms"),
    ), strict=True):  # fmt: skip
        for method in (H1, H6, DEFAULT, PLAIN, FEM):
            run = select(runs, method=method.name).sort_values("cells")
            for share in (1, 99):
                name = method.name if share == 1 else "_"
                ax.plot(run["cells"], _MPA * run[f"{column}{share}"], label=name, **method.look)
        for value in INDEPENDENT_PRESSURE:
            ax.axhline(_MPA * value, color=BLACK, linewidth=0.7, linestyle=(0, (1, 2)))
        ax.set(title=title, xlabel="cells per metre", ylim=(-4.0, 5.5))
    axes[0, 0].set_ylabel("1st and 99th percentile [MPa]")
    outside_legend(figure, axes.flat, columns=4)
    return figure


def profile(results: Results) -> Figure:
    """Mean, least and largest pressure of each layer of cells at 0.1 s, over the height."""
    figure, axes = panels(1, 2, width=4.0, height=3.6)
    layers = usual(results.tables["layers"])
    reference, most = finest_of(layers, FEM.name), finest_of(layers, H1.name)
    coarse = 5 if 5 in set(select(layers, method=H1.name)["cells"]) else 3
    for ax, cells in zip(axes.flat, (coarse, most), strict=True):
        for method, number, width in ((FEM, reference, 2.0), (FEM, cells, 0.9), (H1, cells, 1.3)):
            run = select(layers, method=method.name, cells=number).sort_values("Y [m]")
            if len(run) == 0 or (width == 0.9 and number == reference):
                continue
            look = {"color": method.colour, "linewidth": width}
            ax.plot(_MPA * run["pressure_mean [Pa]"], run["Y [m]"], **look,
                    label=f"{method.name}, {lattice(number)}")  # fmt: skip
            for end in ("min", "max"):
                look |= {"linestyle": ":", "linewidth": 0.5 * width}
                ax.plot(_MPA * run[f"pressure_{end} [Pa]"], run["Y [m]"], **look)
        ax.set(
            title=f"{lattice(cells)}: mean (full), extremes (dotted)", xlabel="pressure [MPa]",
            ylabel="height Y [m]", xlim=(-5.0, 8.0), ylim=(0.0, 6.0),
        )  # fmt: skip
    outside_legend(figure, axes.flat, columns=2)
    return figure


def noise(results: Results) -> Figure:
    """High-frequency share of the pressure above the clamp over time, by tau_p and lattice."""
    figure, axes = panels(1, 2, width=4.0, height=3.0)
    history = usual(results.tables["history"])
    coarse = 5 if 5 in set(select(history, method=PLAIN.name)["cells"]) else 3
    finest = finest_of(history, PLAIN.name, NO_TAU_P.name)
    for ax, cells in zip(axes.flat, (coarse, finest), strict=True):
        for method in (H1, H6, DEFAULT, PLAIN, NO_TAU_P, FEM):
            run = select(history, method=method.name, cells=cells).iloc[1:]
            if len(run):
                _line(ax, run, "noise_free", method.name, method.look)
        ax.set(title=lattice(cells), xlabel="time [ms]", ylim=(0.0, None))
    axes[0, 0].set_ylabel("pressure noise, Y > 0.5 m [-]")
    outside_legend(figure, axes.flat, columns=3)
    return figure


def _row(tables: Tables, asked: Sequence[tuple[str, Method, int, float]]) -> Plan:
    """Panels side by side of what was run: a heading, and method, cells and time [s] of a run."""
    runs = usual(tables["table"])
    known = set(zip(runs["method"], runs["cells"], strict=True))
    # Without damping pressures are beyond all others: they must not set the colours.
    return [[
        Panel(heading, shot_key(method.name, cells), time, sets_colours=method != CLASSICAL)
        for heading, method, cells, time in asked if (method.name, cells) in known
    ]]  # fmt: skip


def lattices(tables: Tables) -> Plan:
    """Fig. 14: the paper's lattices (the coarsest there are) with H6, then with H1, at 0.1 s."""
    runs = usual(tables["table"])
    numbers = sorted(set(select(runs, method=H1.name)["cells"]))[: len(PAPER_LATTICES)]
    return _row(tables, [
        (f"paper, {name}\n{lattice(cells)}", method, cells, END)
        for method, name in ((H6, "H6"), (H1, "H1")) for cells in numbers
    ])  # fmt: skip


def methods(tables: Tables) -> Plan:
    """Fig. 15: methods side by side at 0.1 s, the finest on the left and on the right."""
    table = tables["table"]
    cells, ultra = common_lattice(table), finest_of(table, H1.name)
    reference = finest_of(table, FEM.name)
    asked = [
        (f"paper, H1\n{lattice(ultra)}", H1, ultra, END),
        (f"paper, H1\n{lattice(cells)}", H1, cells, END),
        (f"package\ndefault {lattice(cells)}", DEFAULT, cells, END),
        (f"self-adjoint\nSUPG {lattice(cells)}", PLAIN, cells, END),
        (f"as printed\n{lattice(cells)}", LITERAL, cells, END),
        (f"displacement\nSPH {lattice(cells)}", CLASSICAL, cells, END),
        (f"B-bar FEM\n{lattice(cells)}", FEM, cells, END),
        (f"B-bar FEM\n{lattice(reference)}", FEM, reference, END),
    ]
    return _row(tables, list(dict.fromkeys(asked)))


def sequence(tables: Tables) -> Plan:
    """The motion over time on the finest lattice of the paper's H1."""
    cells = finest_of(tables["table"], H1.name)
    times = (0.0, 0.02, 0.04, 0.06, 0.08, END)
    return _row(tables, [(f"paper, H1, {lattice(cells)}", H1, cells, t) for t in times])


PICTURES = {
    plan.__name__: Picture(plan, colours=Percentile(98.0), layout=Layout(width=9.5, height=5.2))
    for plan in (lattices, methods, sequence)
}
CURVES = (twist_by_lattice, histories, energy, accuracy, percentiles, profile, noise)
FIGURES = {curve.__name__: curve for curve in CURVES} | {
    name: picture.draw for name, picture in PICTURES.items()
}
