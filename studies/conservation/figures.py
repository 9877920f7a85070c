"""Figures of the conservation study, made from its tables and stored frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator

from sphsolid.errors import InputError
from studies.conservation.cases import LOAD_ENDS
from studies.conservation.runs import (
    CUBE,
    ELEMENTS,
    OPERATORS,
    PACKAGE,
    PAPER,
    SHOT_TIMES,
    block_case,
    cube_case,
)
from studies.pictures.colours import limits
from studies.pictures.panels import Layout, panel_figure
from studies.pictures.shots import CELL, Absent, Frame, ShotFolder
from studies.pictures.view import Around, angled_view
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

_COLOURS = {"Literal": VERMILION, "Consistent": BLUE}
_NAMES = {"Literal": "as printed", "Consistent": "consistent"}
_NOWHERE = Path()


def block_key(operator: str, projection: str = "local", spacing: float = PAPER["spacing"]) -> str:
    """Key of the run of the paper's setting with an operator."""
    group = "all" if projection == "local" else "no projection"
    changed = {"operator": operator, "projection": projection, "spacing": spacing}
    return block_case(_NOWHERE, group, PAPER | changed).key


def elements_key(spacing: float = PAPER["spacing"]) -> str:
    """Key of the finite element run."""
    return block_case(_NOWHERE, "elements", ELEMENTS | {"spacing": spacing}).key


def package_key(spacing: float = PAPER["spacing"]) -> str:
    """Key of the run with the defaults."""
    return block_case(_NOWHERE, "defaults", PACKAGE | {"spacing": spacing}).key


def momenta_figure(history: pd.DataFrame, stem: Path) -> Path:
    """Components of both momenta over time, the phase of the tractions shaded (as Fig. 7)."""
    figure, axes = panels(1, 2, width=3.6, height=2.9)
    left, right = axes[0]
    elements = history[history["key"] == elements_key()]
    for axis, colour in zip("xyz", (BLUE, VERMILION, GREEN), strict=True):
        for operator, style in (("Consistent", "-"), ("Literal", "--")):
            run = history[history["key"] == block_key(operator)]
            left.plot(
                run["time"], run[f"L_{axis}"] / 1e5, style, color=colour,
                label=f"{axis}, {_NAMES[operator]}",
            )  # fmt: skip
            right.plot(run["time"], run[f"p_{axis}"] / 1e-10, style, color=colour, linewidth=0.8)
        every = max(1, len(elements) // 16)
        left.plot(
            elements["time"][::every], elements[f"L_{axis}"][::every] / 1e5, "o", color=colour,
            markersize=3.2, markerfacecolor="white", label=f"{axis}, B-bar FEM",
        )  # fmt: skip
    left.set(ylabel="angular momentum [1e5 kg m²/s]", title="angular momentum about the origin")
    right.set(ylabel="linear momentum [1e-10 kg m/s]", title="linear momentum, SUPG-SPH")
    for ax in (left, right):
        _shade(ax)
    outside_legend(figure, [left], columns=3)
    return save_figure(figure, stem)


def _shade(axes: Axes) -> None:
    axes.axvspan(0.0, LOAD_ENDS, color="0.9", zorder=0)
    axes.text(
        0.5 * LOAD_ENDS, 0.98, "tractions", transform=axes.get_xaxis_transform(), ha="center",
        va="top", size=7.5, color="0.35",
    )  # fmt: skip
    axes.set(xlabel="time [s]")
    axes.set_xlim(left=0.0)


def drift_figure(history: pd.DataFrame, stem: Path) -> Path:
    """Angular momentum that no load gave, with and without the projection, on a log axis."""
    figure, axes = panels(1, 1, width=5.2, height=3.0)
    ax = axes[0, 0]
    curves: list[tuple[str, str, dict[str, Any]]] = []
    for operator in OPERATORS:
        for projection, style in (("none", "--"), ("local", "-")):
            what = "no projection" if projection == "none" else "projection"
            curves.append(
                (block_key(operator, projection), f"{_NAMES[operator]}, {what}",
                 {"color": _COLOURS[operator], "linestyle": style})
            )  # fmt: skip
    curves.append((package_key(), "package defaults", {"color": GREEN}))
    curves.append((elements_key(), "B-bar FEM", {"color": BLACK, "linestyle": ":"}))
    for key, label, look in curves:
        run = history[(history["key"] == key) & (history["time"] > 0.0)]
        # A drift of exactly nothing has no place on a log axis.
        ax.plot(run["time"], np.maximum(run["angular"], 1e-17), label=label, **look)
    ax.axhline(1e-12, color="0.5", linewidth=0.8, linestyle=(0, (1, 2)))
    ax.set(yscale="log", ylabel="|drift of L| / Σ V |x| |p|  [-]", ylim=(5e-18, 3e-2))
    _shade(ax)
    outside_legend(figure, [ax], columns=3)
    return save_figure(figure, stem)


_TERMS = (
    ("work", "work of the tractions", BLACK, "-"),
    ("kinetic", "kinetic energy", BLUE, "-"),
    ("deviatoric", "strain energy, deviatoric", VERMILION, "-"),
    ("volumetric", "strain energy, volumetric", ORANGE, "-"),
    ("dissipation", "dissipation D(p)", PURPLE, "--"),
    ("projection", "work of the projection", SKY, "--"),
    ("rest", "rest", GREEN, ":"),
)


def ledger_figure(history: pd.DataFrame, stem: Path) -> Path:
    """Every term of the energy ledger of the block, linear and logarithmic."""
    figure, axes = panels(2, 3, width=2.7, height=2.4)
    shown = [(f"operator {_NAMES[operator]}", block_key(operator)) for operator in OPERATORS]
    for j, (title, key) in enumerate([*shown, ("package defaults", package_key())]):
        run = history[history["key"] == key]
        for name, label, colour, style in _TERMS:
            for i in (0, 1):
                values = run[name] / 1e3 if i == 0 else np.maximum(np.abs(run[name]), 1e-4)
                axes[i, j].plot(run["time"], values, style, color=colour, label=label)
        axes[0, j].set(title=title, ylabel="energy [kJ]")
        axes[1, j].set(yscale="log", ylabel="|energy| [J]", ylim=(1e-4, 2e5))
        for i in (0, 1):
            _shade(axes[i, j])
    outside_legend(figure, [axes[0, 0]], columns=4)
    return save_figure(figure, stem)


def sequence_figure(out: Path, stem: Path, spacing: float) -> Path:
    """The block over time, pressure as means over cells: as printed, consistent, elements."""
    folder = ShotFolder(out / "shots")
    rows = [
        (block_key(operator, spacing=spacing), f"SUPG-SPH, {_NAMES[operator]}")
        for operator in OPERATORS
    ]
    rows += [(package_key(spacing), "SUPG-SPH, defaults"), (elements_key(spacing), "B-bar FEM")]
    grid = [[_frame(folder, key, label, t) for t in SHOT_TIMES] for key, label in rows]
    figure = panel_figure(
        grid,
        colours=limits(grid, field=CELL + "pressure", percentile=98.0),
        view=angled_view(up="y", azimuth=-35.0, elevation=18.0),
        window=Around(follow=True),
        layout=Layout(width=7.2, height=8.5),
    )
    return save_figure(figure, stem)


def _frame(folder: ShotFolder, key: str, label: str, time: float) -> Frame:
    try:
        frame = folder.load(key, time)
    except InputError:
        return Absent(label, time)
    # The heading of a row names the method only: all else is in the caption.
    return type(frame)(**(vars(frame) | {"label": label}))


def cube_figure(cube: pd.DataFrame, history: pd.DataFrame, stem: Path) -> Path:
    """Rest of the ledger against the CFL number, and energies over ten turns."""
    figure, axes = panels(1, 2, width=3.7, height=3.1)
    _rests(axes[0, 0], cube)
    _energies(axes[0, 1], cube, history)
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def _rests(ax: Axes, cube: pd.DataFrame) -> None:
    kept = cube[(cube["outcome"] == "kept") & (cube["left_over"] > 0.0)]
    looks = (
        ("defaults", "-", "package defaults", ORANGE, ("v", "<", ">")),
        ("ladder", "TVD-RK2", "two stages", BLUE, ("o", "s", "^")),
        ("methods", "SSP-RK3", "SSP-RK3", GREEN, ("*",)),
        ("methods", "position Verlet", "position Verlet", VERMILION, ("p",)),
        ("elements", "-", "B-bar", BLACK, ("D", "P", "X")),
    )
    for group, integrator, label, colour, markers in looks:
        runs = kept[(kept["group"] == group) & kept["formulation"].isin(["{p,F}", "-"])]
        runs = runs[(runs["integrator"] == integrator) | (integrator == "-")]
        for spacing, marker in zip(
            sorted(runs["spacing"].unique(), reverse=True), markers, strict=False
        ):
            part = runs[runs["spacing"] == spacing].sort_values("cfl")
            ax.plot(
                part["cfl"], part["left_over"], color=colour, marker=marker,
                label=f"{label}, h = 1/{1.0 / spacing:.0f}",
            )  # fmt: skip
    ladder = kept[kept["group"] == "ladder"]
    if len(ladder):
        at = np.array([ladder["cfl"].min(), ladder["cfl"].max()])
        low = ladder["left_over"].min() / 3.0
        for order, style in ((2, "--"), (3, ":")):
            ax.plot(
                at, low * (at / at[0]) ** order, style, color="0.6", linewidth=0.8,
                label=f"slope {order}",
            )  # fmt: skip
    ax.set(
        xscale="log", yscale="log", xlabel="CFL number [-]",
        ylabel="|rest + projection| / initial energy [-]", title="spinning cube, energy ledger",
    )  # fmt: skip
    # The ladders of both methods; those of the defaults lie between.
    marks = [0.075, 0.15, 0.3, 0.6]
    ax.xaxis.set_major_locator(FixedLocator(marks))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticklabels([f"{cfl:g}" for cfl in marks])


def _energies(ax: Axes, cube: pd.DataFrame, history: pd.DataFrame) -> None:
    ladder = cube[(cube["group"] == "ladder") & (cube["cfl"] == 0.3)]
    spacing = 0.125 if (ladder["spacing"] == 0.125).any() else 0.25
    methods = (
        ("SUPG-SPH", cube_case("ladder", CUBE | {"spacing": spacing}).key, "-"),
        ("B-bar", cube_case("elements", ELEMENTS | {"spacing": spacing}).key, "--"),
        (
            "SUPG-SPH, support 1.54 dx, h = 1/4",
            cube_case("support", CUBE | {"h_over_dx": 0.77}).key,
            ":",
        ),
    )
    for label, key, style in methods:
        run = history[history["key"] == key]
        only_total = style == ":"
        for name, colour in (("total", BLACK), ("kinetic", BLUE), ("strain", VERMILION)):
            if name == "total" or not only_total:
                ax.plot(
                    run["turn"], run[name], style, color=PURPLE if only_total else colour,
                    label=f"{label}, {name}",
                )  # fmt: skip
    ax.set(
        xlabel="turns at the initial speed [-]", ylabel="energy / initial energy [-]",
        title=f"energies, h = 1/{1.0 / spacing:.0f}, CFL 0.3 (B-bar 0.6)", ylim=(0.0, 1.45),
    )  # fmt: skip
