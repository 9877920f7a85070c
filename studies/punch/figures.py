"""Curves and pictures of the punch test, the latter after Figs. 10 to 12 of the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sphsolid.look.colours import ColourRange
from sphsolid.look.frame import Absent
from sphsolid.look.panels import Layout
from sphsolid.look.scalars import CELL
from sphsolid.look.view import flat_view
from studies.engine.plotting import outside_legend, panels
from studies.engine.results import Results, Tables
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG, Method
from studies.pictures.picture import Panel, Picture, Plan
from studies.punch.claims import INDEPENDENT, TOLERANCE
from studies.punch.runs import (
    CLASSICAL,
    COMPARED,
    CONSISTENT,
    DEFAULTS,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    HELD,
    INITIAL,
    LITERAL,
    OWN_OPERATOR,
    READINGS,
    WIDE,
    WIDE_NO_TAU_P,
    WITH_TAU_F,
    WITHOUT_TAU_F,
    Reading,
)
from studies.punch.tables import elements, one_run

#: Ends of the colour bar [Pa], the same in every picture, so that they can be compared.
PRESSURE = 4.0e6
EARLY, LATE = (0.005, 0.01, COMPARED), (0.005, 0.01, 0.015, 0.02, 0.025, 0.03)
#: (a) to (d) of Fig. 10: particles alone, whose own values are shown.
FIG_10 = (CLASSICAL, GALERKIN, H6_NO_TAU_P, H6)
#: Methods whose frames are kept.
PICTURED = (*FIG_10, H1, PACKAGE, B_BAR)


def noise_figure(results: Results) -> Figure:
    """Noise over ``tau_p`` (above) and over time (below), both readings."""
    table = results.tables["table"]
    figure, axes = panels(2, 2, width=3.6, height=2.7)
    for column, reading in enumerate(READINGS):
        above, below = axes[:, column]
        for label, members, operator, look in _families():
            found = [(tau, one_run(table, reading, m, operator)) for tau, m in members.items()]
            points = [(tau, run["noise_mean"].iloc[0]) for tau, run in found if len(run)]
            if points:
                above.plot(*zip(*points, strict=True), label=label, **look)
        above.set(title=f"{reading.name}: mean of 0.5 to 15 ms", xlabel="tau_p / dt [-]")
        for method in (CLASSICAL, GALERKIN, H6_NO_TAU_P, H6, H1, SUPG, PACKAGE, B_BAR):
            _over_time(below, results, reading, method, "noise")
        below.set(title=f"{reading.name}: over time", xlabel="time [ms]")
        for ax in (above, below):
            ax.set(ylabel="pressure noise [-]")
            ax.set_ylim(bottom=0.0)
    outside_legend(figure, axes.flat, columns=2)
    return figure


def _families() -> Iterator[tuple[str, dict[float, Method], Any, dict[str, Any]]]:
    open_ones = {"markerfacecolor": "white"}
    paper = "paper, {p,F,J} H1"
    yield SUPG.name, DEFAULTS, CONSISTENT, SUPG.look
    yield f"{paper}, tau_F = dt", WITH_TAU_F, CONSISTENT, H1.look
    yield f"{paper}, tau_F = dt, as printed", WITH_TAU_F, LITERAL, H1.look | {"linestyle": ":"}
    yield f"{paper}, tau_F = 0", WITHOUT_TAU_F, CONSISTENT, H1.look | open_ones
    yield H6.name, {0.0: H6_NO_TAU_P, 0.1: H6}, CONSISTENT, H6.look
    yield WIDE.name, {0.0: WIDE_NO_TAU_P, 0.1: WIDE}, CONSISTENT, H6.look | open_ones


def _over_time(
    ax: Axes, results: Results, reading: Reading, method: Method, column: str
) -> None:
    run = one_run(results.tables["table"], reading, method)
    if len(run) == 0:
        return
    mine = select(results.tables["history"], key=run["key"].iloc[0])
    # At the start there is no pressure yet, and noise is a ratio of nothings.
    mine = mine[mine["time [s]"] > 0.0] if column == "noise" else mine
    look = method.look | {"markevery": 6, "markersize": 3.0}
    if method == GALERKIN:
        # The same as displacement SPH but for round-off: both must be seen.
        look |= {"linestyle": "none"}
    ax.plot(1e3 * mine["time [s]"], mine[column], label=method.name, **look)


def profile_figure(results: Results) -> Figure:
    """The edge of the top face at 15 ms, and where it is against the finest elements."""
    table, profile = results.tables["table"], results.tables["profile"]
    at = profile[np.isclose(profile["time"], COMPARED)]
    figure, axes = panels(2, 2, width=3.6, height=2.6)
    for column, reading in enumerate(READINGS):
        solids = elements(table, reading)
        if len(solids) == 0:
            continue
        reference = select(at, key=solids["key"].iloc[-1]).sort_values("X")
        above, below = axes[:, column]
        for edge in INDEPENDENT[reading.name]:
            above.axhline(edge, color="0.6", linewidth=0.8, linestyle="--")
        for method in (CLASSICAL, H6, H1, SUPG, PACKAGE, B_BAR):
            run = one_run(table, reading, method)
            mine = select(at, key=run["key"].iloc[0]).sort_values("X") if len(run) else at[:0]
            if len(mine):
                look = method.look | {"markersize": 2.6}
                above.plot(mine["x"], mine["z"], label=method.name, **look)
                there = np.interp(mine["X"], reference["X"], reference["z"])
                below.plot(mine["X"], 1e3 * (mine["z"] - there), label=method.name, **look)
        above.plot(
            reference["x"], reference["z"], color="0.5", linewidth=2.6, alpha=0.5,
            label=f"{B_BAR.name}, finest",
        )  # fmt: skip
        below.axhspan(-1e3 * TOLERANCE, 1e3 * TOLERANCE, color="0.9", zorder=0)
        above.set(
            title=f"{reading.name}, 15 ms (finest elements {solids['lattice'].iloc[-1]})",
            xlabel="x [m]", ylabel="height of the top edge [m]",
        )  # fmt: skip
        below.set(xlabel="X [m]", ylabel="height, less finest FEM [mm]")
    outside_legend(figure, axes.flat, columns=3)
    return figure


def height_figure(results: Results) -> Figure:
    """Why one instant is a poor measure: the lowest height over time, and refined."""
    table = results.tables["table"]
    figure, axes = panels(1, 3, width=3.0, height=2.7)
    over_time, energy, refined = axes.flat
    for method in (CLASSICAL, H6, H1, SUPG, PACKAGE, B_BAR):
        _over_time(over_time, results, INITIAL, method, "top_low [m]")
        _over_time(energy, results, INITIAL, method, "total_energy [J]")
        runs = select(table, press=INITIAL.name, method=method.name)
        runs = runs[runs["operator"] != LITERAL.name].sort_values("cells")
        if method != CLASSICAL and len(runs):
            refined.plot(1.0 / runs["cells"], runs["top_low"], label=method.name, **method.look)
    over_time.axvline(1e3 * COMPARED, color="0.6", linewidth=0.8, linestyle="--")
    over_time.set(title="initial", xlabel="time [ms]", ylabel="lowest height [m]")
    energy.set(title="initial", xlabel="time [ms]", ylabel="kinetic and strain energy [J]")
    refined.axhline(INDEPENDENT[INITIAL.name][0], color="0.6", linewidth=0.8, linestyle="--")
    refined.set(title="initial, 15 ms", xlabel="spacing [m]", ylabel="lowest height [m]")
    refined.set_xlim(left=0.0)
    outside_legend(figure, axes.flat, columns=3)
    return figure


def _panel(
    tables: Tables, reading: Reading, method: Method, time: float, operator: Any = CONSISTENT,
    *, level: int = 0, label: str = "",
) -> Panel | Absent:  # fmt: skip
    run = one_run(tables["table"], reading, method, operator, level)
    label = label or method.name.replace(", ", ",\n")
    if len(run) == 0 or run["until"].iloc[0] < time - 1e-9:
        return Absent(label, time)
    return Panel(label, run["key"].iloc[0], time)


def _evolution(reading: Reading, operator: Any, tables: Tables) -> Plan:
    return [[_panel(tables, reading, m, time, operator) for time in EARLY] for m in FIG_10]


def _comparison(tables: Tables) -> Plan:
    lattices = tables["table"].groupby("cells")["lattice"].first().tolist()
    shown = [(H6, 0), (H1, 0), (PACKAGE, 0), (B_BAR, 0), (H1, 1), (PACKAGE, 1), (B_BAR, 1)]
    return [
        [
            _panel(
                tables, reading, method, COMPARED, level=level,
                label=f"{method.name if method in OWN_OPERATOR else method.name.split()[-1]}\n"
                f"{lattices[level]}",
            )
            for reading in READINGS
        ]
        for method, level in shown if level < len(lattices)
    ]  # fmt: skip


def _sequence(reading: Reading, tables: Tables) -> Plan:
    return [[_panel(tables, reading, method, time) for method in (H1, B_BAR)] for time in LATE]


def _picture(plan: Callable[[Tables], Plan], field: str) -> Picture:
    colours = ColourRange(field, -PRESSURE, PRESSURE, (True, True))
    # Six pages of images: fine enough for the lines of the mesh, and not more.
    return Picture(plan, field, colours, flat_view(right="x", up="z"), layout=Layout(dpi=100))


#: Particles alone show what they have: a mean over cells would hide its fluctuations.
PICTURES = {
    "evolution_initial": _picture(partial(_evolution, INITIAL, CONSISTENT), "pressure"),
    "evolution_initial_printed": _picture(partial(_evolution, INITIAL, LITERAL), "pressure"),
    "evolution_held": _picture(partial(_evolution, HELD, CONSISTENT), "pressure"),
    "comparison": _picture(_comparison, CELL + "pressure"),
    "sequence_initial": _picture(partial(_sequence, INITIAL), CELL + "pressure"),
    "sequence_held": _picture(partial(_sequence, HELD), CELL + "pressure"),
}
