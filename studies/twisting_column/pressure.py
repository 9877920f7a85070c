"""Figures of the column's pressure: percentiles, profile over the height, noise."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from studies.convergence.figures import select
from studies.report.plotting import BLACK, BLUE, VERMILION, outside_legend, panels, save_figure
from studies.twisting_column.figures import LOOKS
from studies.twisting_column.methods import (
    FEM,
    H1,
    H6,
    NO_TAU_P,
    TOOLKIT,
    finest,
    finest_of,
    lattice,
    usual,
)
from studies.twisting_column.requirements import INDEPENDENT_PRESSURE

_WHERE = (
    ("pressure_", "where the law is evaluated"),
    ("pressure_cells_", "at cell centroids"),
    ("pressure_free_", "at centroids, Y > 0.5 m"),
    ("pressure_mean_", "there, mean over 100 .. 110 ms"),
)
_MPA = 1.0e-6


def percentiles_figure(table: pd.DataFrame, stem: Path) -> Path:
    """Percentiles 1 and 99 at 0.1 s over the number of cells, by where they are taken."""
    figure, axes = panels(1, 4, width=2.7, height=3.0)
    part = usual(table)
    for ax, (column, title) in zip(axes.flat, _WHERE, strict=True):
        for label in (H1, H6, TOOLKIT, FEM):
            run = select(part, label=label).sort_values("cells")
            for share in (1, 99):
                name = label if share == 1 else "_"
                ax.plot(run["cells"], _MPA * run[f"{column}{share}"], label=name, **LOOKS[label])
        for value in INDEPENDENT_PRESSURE:
            ax.axhline(_MPA * value, color=BLACK, linewidth=0.7, linestyle=(0, (1, 2)))
        ax.set(title=title, xlabel="cells per metre", ylim=(-4.0, 5.5))
    axes[0, 0].set_ylabel("1st and 99th percentile [MPa]")
    outside_legend(figure, axes.flat, columns=4)
    return save_figure(figure, stem)


def profile_figure(layers: pd.DataFrame, stem: Path) -> Path:
    """Mean, least and largest pressure of each layer of cells at 0.1 s, over the height."""
    figure, axes = panels(1, 2, width=4.0, height=3.6)
    reference = finest(layers)
    coarse = 5 if 5 in set(select(usual(layers), label=H1)["cells"]) else 3
    for ax, cells in zip(axes.flat, (coarse, finest(layers, H1)), strict=True):
        shown = ((FEM, reference, BLACK), (FEM, cells, VERMILION), (H1, cells, BLUE))
        for label, number, colour in shown:
            run = select(usual(layers), label=label, cells=number).sort_values("Y [m]")
            if len(run) == 0 or (colour == VERMILION and number == reference):
                continue
            Y = run["Y [m]"]
            ax.plot(_MPA * run["pressure_mean [Pa]"], Y, color=colour,
                    label=f"{label}, {lattice(number)}")  # fmt: skip
            for end in ("min", "max"):
                ax.plot(_MPA * run[f"pressure_{end} [Pa]"], Y, color=colour, linewidth=0.7,
                        linestyle=":")  # fmt: skip
        ax.set(
            title=f"{lattice(cells)}: mean (full), extremes (dotted)", xlabel="pressure [MPa]",
            ylabel="height Y [m]", xlim=(-5.0, 8.0), ylim=(0.0, 6.0),
        )  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def noise_figure(history: pd.DataFrame, stem: Path) -> Path:
    """High-frequency share of the pressure above the clamp over time, by tau_p and lattice."""
    figure, axes = panels(1, 2, width=4.0, height=3.0)
    coarse = 5 if 5 in set(select(usual(history), label=TOOLKIT)["cells"]) else 3
    for ax, cells in zip(axes.flat, (coarse, finest_of(history, TOOLKIT, NO_TAU_P)), strict=True):
        for label in (H1, H6, TOOLKIT, NO_TAU_P, FEM):
            run = select(usual(history), label=label, cells=cells).iloc[1:]
            if len(run):
                ax.plot(1e3 * run["time [s]"], run["noise_free"], label=label,
                        markevery=8, **LOOKS[label])  # fmt: skip
        ax.set(title=lattice(cells), xlabel="time [ms]", ylim=(0.0, None))
    axes[0, 0].set_ylabel("pressure noise, Y > 0.5 m [-]")
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)
