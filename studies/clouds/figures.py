"""Figures of the study of clouds, each made from its tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from studies.clouds.tables import unvaried
from studies.convergence.figures import select
from studies.report.plotting import (
    BLUE,
    GREEN,
    VERMILION,
    Curve,
    convergence_panel,
    outside_legend,
    panels,
    save_figure,
)

LOOKS: dict[str, dict[str, Any]] = {
    "Literal": {"color": VERMILION, "marker": "o", "markerfacecolor": "white"},
    "Consistent": {"color": BLUE, "marker": "s"},
    "SummationByParts": {"color": GREEN, "marker": "D"},
}
_FIELDS = {"error_p": "momentum", "error_P": "stress"}
_ACROSS = 4


def orders_figure(levels: pd.DataFrame, scene: str, formulation: str, stem: Path) -> Path:
    """Largest component error over spacing by operator: a pair of panels a cloud; ``stem``."""
    shown = select(unvaried(levels), scene=scene, family="A+B+C=0", formulation=formulation)
    clouds = list(dict.fromkeys(shown["cloud"]))
    across = max(1, min(_ACROSS, len(clouds)))
    blocks = max(1, -(-len(clouds) // across))
    figure, axes = panels(2 * blocks, across, width=2.9, height=2.7)
    for place in range(blocks * across):
        block, column = divmod(place, across)
        for row, (name, field) in enumerate(_FIELDS.items()):
            ax = axes[2 * block + row, column]
            if place >= len(clouds):
                ax.set_axis_off()
                continue
            runs = select(shown, cloud=clouds[place])
            convergence_panel(
                ax,
                [
                    Curve(operator, part["h"].tolist(), part[name].tolist(), LOOKS[operator])
                    for operator, part in runs.groupby("operator", sort=False)
                ],
                title=f"{clouds[place]}: {field}",
                y_label="relative L2 error [-]" if column == 0 else "",
                x_label="spacing h [m]" if row == 1 else "",
            )
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def disorder_figure(levels: pd.DataFrame, stem: Path) -> Path:
    """Error at the level nearest 17^3 over the jitter, linear limit, {p,F}; gives ``stem``."""
    part = select(
        unvaried(levels), scene="linear", formulation="{p,F}", family="A+B+C=0", h=1.0 / 16.0
    )
    amount = {"lattice": 0.0} | {
        cloud: float(cloud.split()[1]) for cloud in part["cloud"] if cloud.startswith("jitter")
    }
    part = part[part["cloud"].isin(list(amount))]
    part = part.assign(jitter=[100.0 * amount[cloud] / 2.0 for cloud in part["cloud"]])
    figure, axes = panels(1, 2, width=3.4, height=2.9)
    for ax, (name, field) in zip(axes.flat, _FIELDS.items(), strict=True):
        for operator, runs in part.groupby("operator", sort=False):
            runs = runs.sort_values("jitter")
            ax.plot(runs["jitter"], runs[name], label=operator, **LOOKS[str(operator)])
        ax.set_yscale("log")
        ax.set(
            title=f"17^3, linear limit: {field}",
            xlabel="particles moved by up to [% of spacing]",
            ylabel="relative L2 error [-]",
        )
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def ledger_figure(ledger: pd.DataFrame, stem: Path) -> Path:
    """What the energy account leaves over, over the step; gives ``stem``."""
    figure, axes = panels(1, 1, width=3.8, height=3.0)
    ax = axes[0, 0]
    colours = {"TVD-RK2": BLUE, "position Verlet": VERMILION}
    for (cloud, integrator), runs in ledger.groupby(["cloud", "integrator"], sort=False):
        disorder = str(cloud).startswith("jitter")
        ax.plot(
            1.0e6 * runs["dt"], runs["rest"], label=f"{integrator}, {cloud}",
            color=colours[str(integrator)], marker="o" if disorder else "^",
            linestyle="-" if disorder else "--",
        )  # fmt: skip
    ends = ledger["dt"].min(), ledger["dt"].max()
    level = 0.5 * float(ledger["rest"].min()) / ends[0] ** 2
    ax.plot([1.0e6 * dt for dt in ends], [level * dt**2 for dt in ends], color="0.55",
            linestyle=":", linewidth=0.8, label="dt²")  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    ticks = sorted({round(1.0e6 * dt, 3) for dt in ledger["dt"]})
    ax.set_xticks(ticks, [f"{tick:.0f}" for tick in ticks], minor=False)
    ax.minorticks_off()
    ax.set(xlabel="time step [µs]", ylabel="largest rest / energy [-]",
           title="energy account, no stabilisation")  # fmt: skip
    outside_legend(figure, axes.flat, columns=2)
    return save_figure(figure, stem)
