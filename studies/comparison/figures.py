"""Curves of errors, histories and costs, and which runs are sound, with every method."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.comparison.contenders import AGREEING, CONTENDERS, DEFAULT, Contender
from studies.comparison.pictures import PICTURES
from studies.comparison.runs import column_case, punch_case
from studies.comparison.tables import COLUMN_AT, NU, OMEGA, PUNCH_AT, PUNCH_FINE
from studies.engine.plotting import Curve, convergence_panel, outside_legend, panels
from studies.engine.results import Results
from studies.measures.folding import sound
from studies.measures.tables import select
from studies.stability.judgement import overview

_TITLES = {"linear": "linear limit", "manufactured": "large strain"}
_FIELDS = ("momentum", "stress")


def look(one: Contender, **more: Any) -> dict[str, Any]:
    """The line of a method; the default is drawn over all others."""
    own = one.cube.look | {"linewidth": 1.1, "markersize": 4.5}
    if one == DEFAULT:
        own |= {"linewidth": 2.2, "zorder": 5}
    if one.cube.line == ":":
        own |= {"markerfacecolor": "white"}
    return own | more


def cube(results: Results) -> Figure:
    """Fig. 5 of the paper with every method: largest component errors over spacing."""
    table = results.tables["cube"]
    figure, axes = panels(2, 2, width=3.7, height=3.3)
    for column, scene in enumerate(_TITLES):
        for row, word in enumerate(_FIELDS):
            curves = []
            for one in CONTENDERS:
                own = select(table, scene=scene, method=one.name)
                if len(own):
                    h = [1.0 / cells for cells in own["cells"]]
                    curves.append(Curve(one.cube.label, h, own[word].tolist(), look(one)))
            convergence_panel(
                axes[row, column], curves, title=f"{_TITLES[scene]}: {word}",
                x_label="spacing h [m]" if row else "",
                y_label="" if column else "relative L2 error [-]",
            )  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return figure


def _over_time(
    ax: Axes, results: Results, case: str, column: str, factor: float = 1.0
) -> None:
    history = select(results.tables["history"], case=case)
    for number, one in enumerate(CONTENDERS):
        run = select(history, method=one.name).iloc[1:]
        if len(run):
            # Markers of neighbours at different records, so that none hides another.
            every = (2 * number % 12, 14)
            ax.plot(
                1.0e3 * run["time"], factor * run[column], label=one.cube.label, markevery=every,
                **look(one),
            )  # fmt: skip


def histories(results: Results) -> Figure:
    """Twist, energy and noise of the paper's column, and energy and noise of the punch."""
    figure, axes = panels(2, 2, width=3.7, height=3.0)
    column, press = column_case(OMEGA, NU, COLUMN_AT), punch_case(PUNCH_AT)
    for ax, case, name, words, factor, limits in (
        (axes[0, 0], column, "twist", "twist of the top [rad]", 1.0, (0.0, 7.5)),
        (axes[0, 1], column, "energy", "energy kept [%]", 100.0, (50.0, 115.0)),
        (axes[1, 0], press, "low", "lowest point of the top [m]", 1.0, (0.38, 0.51)),
        (axes[1, 1], press, "energy", "energy kept [%]", 100.0, (50.0, 115.0)),
    ):  # fmt: skip
        _over_time(ax, results, case, name, factor)
        ax.set(title=case, xlabel="time [ms]", ylabel=words, ylim=limits)
    outside_legend(figure, axes.flat, columns=3)
    return figure


def cost_of_error(results: Results) -> Figure:
    """Error over seconds in the common timing: left and below is better."""
    figure, axes = panels(1, 3, width=3.0, height=3.2)
    cubes = select(results.tables["cube"], scene="manufactured")
    runs = results.tables["runs"]
    columns = runs[(runs["omega"] == OMEGA) & (runs["nu"] == NU)]
    for ax, table, error, title in (
        (axes[0, 0], cubes, "momentum", "cube, large strain: momentum"),
        (axes[0, 1], cubes, "stress", "cube, large strain: stress"),
        (axes[0, 2], columns, "twist_error", "column: twist"),
    ):
        for one in CONTENDERS:
            own = select(table, method=one.name).sort_values("particles")
            own = own[sound(own)]
            if len(own):
                ax.plot(own["seconds"], own[error], label=one.cube.label, **look(one))
        ax.set(xscale="log", yscale="log", title=title, xlabel="seconds of steps, one thread")
    axes[0, 0].set_ylabel("relative error [-]")
    outside_legend(figure, axes.flat, columns=3)
    return figure


def hard(results: Results) -> Figure:
    """Every method on every run in time: sound, of no use, or diverged."""
    runs = results.tables["runs"]
    names = [one.name for one in CONTENDERS]
    ours = runs[runs["method"].isin(names) & (runs["case"] != punch_case(PUNCH_FINE))]
    # The finest columns are of a few methods, and none of them fails there.
    run_by = ours.groupby("case")["method"].transform("nunique")
    ours = ours[run_by > min(len(AGREEING), run_by.max() - 1)]
    order = ours["method"].map(names.index)
    # Methods are the rows: there are more of them than cases.
    turned = ours.iloc[order.argsort(kind="stable")].rename(
        columns={"case": "method", "method": "case"}
    )
    return overview(turned, {case: case.replace(", nu", ",\nnu") for case in ours["case"].unique()})


FIGURES: dict[str, Any] = {
    "cube": cube, "histories": histories, "cost_of_error": cost_of_error, "hard": hard,
} | {name: picture.draw for name, picture in PICTURES.items()}  # fmt: skip

