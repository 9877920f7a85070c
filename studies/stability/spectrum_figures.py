"""Heat maps of the growth over h/dx and CFL, and the limits of every variant."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

from sphsolid.defaults import default_cfl
from studies.report.plotting import (
    BLUE,
    GREEN,
    ORANGE,
    VERMILION,
    outside_legend,
    panels,
    save_figure,
)
from studies.stability.spectrum_cases import INTEGRATORS
from studies.stability.spectrum_growth import LIMITS

#: Of the bases, in their order, and how far apart they are drawn.
COLOURS = (BLUE, GREEN, ORANGE, VERMILION)
SHIFTS = (-0.24, -0.08, 0.08, 0.24)
#: Added before the logarithm: growth below it is round-off.
FLOOR = 1.0e-8
BODY_TITLES = {
    "free": "free block",
    "clamped": "clamped block",
    "rollers": "rollers on three faces",
    "interior": "interior (plane waves)",
}


def growth_maps(growth: pd.DataFrame, out: Path) -> Path | None:
    """``spectrum_map``: ``log10(max |g| - 1)`` over CFL and h/dx, a row of panels a body.

    Lines: tenfold in 1000 and in 50 steps.  ``None`` where no map was computed.
    """
    table = growth[growth["scan"] == "map"]
    if len(table) == 0:
        return None
    methods = list(dict.fromkeys(table["base"]))
    bodies = [body for body in BODY_TITLES if body in set(table["body"])]
    figure, axes = panels(len(bodies), len(methods), width=3.1, height=2.7)
    image: Any = None
    for row, body in zip(axes, bodies, strict=True):
        for ax, method in zip(row, methods, strict=True):
            part = table[(table["body"] == body) & (table["base"] == method)]
            image = _map(ax, part, f"{method}\n{BODY_TITLES[body]}")
    bar = figure.colorbar(image, ax=axes.ravel().tolist(), shrink=0.8, extend="both")
    bar.set_label("log10(max |g| - 1)   [-]")
    return save_figure(figure, out / "spectrum_map")


def _map(ax: Axes, part: pd.DataFrame, title: str) -> Any:
    value = part.pivot_table(index="h_over_dx", columns="cfl", values="max_g")
    excess = np.log10(np.maximum(value.to_numpy(float) - 1.0, 0.0) + FLOOR)
    places = np.arange(len(value.index))
    edges = np.concatenate([places - 0.5, [len(places) - 0.5]])
    cfl = value.columns.to_numpy(float)
    step = 0.5 * float(np.min(np.diff(cfl))) if len(cfl) > 1 else 0.05
    cfl_edges = np.concatenate([[cfl[0] - step], 0.5 * (cfl[1:] + cfl[:-1]), [cfl[-1] + step]])
    image = ax.pcolormesh(cfl_edges, edges, excess, cmap=_colours(), vmin=-8.0, vmax=0.0)
    if min(excess.shape) > 1:
        levels = [np.log10(LIMITS[name] - 1.0) for name in ("slow", "fast")]
        lines: dict[str, Any] = {"colors": "black", "linewidths": [0.8, 1.6], "linestyles": "solid"}
        ax.contour(cfl, places, excess, levels, **lines)
    ax.set_yticks(places, [f"{h:g}" for h in value.index])
    ax.set(title=title, xlabel="CFL [-]", ylabel="h/dx [-]")
    ax.grid(False)
    return image


def _colours() -> ListedColormap:
    from matplotlib import colormaps

    return ListedColormap(colormaps["viridis"](np.linspace(0.05, 1.0, 16)))


def limits_figure(limits: pd.DataFrame, out: Path) -> Path | None:
    """``spectrum_limits``: CFL limits of every variant on a free block; ``None`` without rows."""
    table = limits[~limits["scan"].isin(["map", "larger", "limits"]) & (limits["body"] == "free")]
    if len(table) == 0:
        return None
    variants = list(dict.fromkeys(table["variant"]))
    bases = list(dict.fromkeys(table["base"]))
    figure, axes = panels(1, 1, width=6.4, height=max(2.4, 0.3 * len(variants)))
    ax = axes[0, 0]
    for base, colour, shift in zip(bases, COLOURS, SHIFTS, strict=False):
        part = table[table["base"] == base]
        y = np.array([variants.index(variant) for variant in part["variant"]]) + shift
        ax.hlines(y, part["cfl_slow"], part["cfl_fast"], color=colour, linewidth=1.0)
        ax.plot(part["cfl_slow"], y, "o", color=colour, markerfacecolor="white", markersize=4.0,
                label=f"{base}: tenfold in 1000 steps")  # fmt: skip
        ax.plot(part["cfl_fast"], y, "s", color=colour, markersize=3.0,
                label=f"{base}: tenfold in 50 steps")  # fmt: skip
    ax.set_yticks(range(len(variants)), variants)
    ax.set(title=BODY_TITLES["free"], xlabel="CFL limit [-]", xlim=(-0.03, 1.05))
    ax.set_ylim(len(variants) - 0.4, -0.6)
    outside_legend(figure, [ax], columns=2)
    return save_figure(figure, out / "spectrum_limits")


def default_limits_figure(limits: pd.DataFrame, out: Path) -> Path:
    """``default_limits``: slow and fast limit over Poisson's ratio, a panel an integrator.

    ``limits`` is the table of the default settings; dotted: the default CFL number.
    """
    integrators = list(dict.fromkeys(limits["integrator"]))
    figure, axes = panels(1, len(integrators), width=2.5, height=2.4)
    ratios = sorted(set(limits["nu"]))
    for ax, integrator in zip(axes[0], integrators, strict=True):
        mine = limits[limits["integrator"] == integrator].sort_values("nu")
        for (name, part), colour in zip(mine.groupby("formulation"), COLOURS, strict=False):
            place = [ratios.index(nu) for nu in part["nu"]]
            ax.plot(place, part["cfl_slow"], "o-", color=colour, markerfacecolor="white",
                    label=f"{name}: tenfold in 1000 steps")  # fmt: skip
            ax.plot(place, part["cfl_fast"], "s--", color=colour, markersize=3.0,
                    label=f"{name}: tenfold in 50 steps")  # fmt: skip
        ax.axhline(default_cfl(INTEGRATORS[integrator]), color="0.5", linewidth=0.8, linestyle=":")
        ax.set_xticks(range(len(ratios)), [f"{nu:g}" for nu in ratios], rotation=60)
        ax.set(title=integrator, xlabel="Poisson's ratio [-]", ylim=(0.0, 1.02))
    axes[0, 0].set_ylabel("CFL limit, free block [-]")
    outside_legend(figure, axes.flat, columns=2)
    return save_figure(figure, out / "default_limits")
