"""Pressure on the front of the block, and its noise over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from studies.harness.results import Results
from studies.pictures.face import draw_face
from studies.punch_cloud.bodies import HEXAHEDRA, WIDEST
from studies.punch_cloud.cases import DEFAULT, NO_TAU_P, NONE, TETRAHEDRA
from studies.report.plotting import (
    BLACK,
    BLUE,
    GREEN,
    PURPLE,
    SKY,
    VERMILION,
    outside_legend,
    panels,
    save_figure,
)

LOOKS: dict[tuple[str, str], tuple[str, dict[str, Any]]] = {
    ("lattice", DEFAULT): ("lattice, H1", {"color": BLACK}),
    (HEXAHEDRA, DEFAULT): ("disordered hexahedra, H1", {"color": BLUE}),
    (WIDEST, DEFAULT): ("the same, widest edge", {"color": BLUE, "linestyle": ":"}),
    ("points", DEFAULT): ("points, no mesh, A1", {"color": VERMILION}),
    ("filled", DEFAULT): ("filled surface, A1", {"color": GREEN}),
    ("points", TETRAHEDRA): ("points, no mesh, T1", {"color": PURPLE}),
    ("points", NO_TAU_P): ("points, A1, τ_p = 0", {"color": SKY}),
    (HEXAHEDRA, NO_TAU_P): ("hexahedra, H1, τ_p = 0", {"color": SKY, "linestyle": "--"}),
    ("points", NONE): ("points, no stabilisation", {"color": "0.6"}),
    (HEXAHEDRA, NONE): ("hexahedra, no stabilisation", {"color": "0.6", "linestyle": "--"}),
}
_SHOWN = (
    ("lattice", DEFAULT), (HEXAHEDRA, DEFAULT), ("points", DEFAULT), ("filled", DEFAULT),
    ("points", TETRAHEDRA), ("points", NONE),
)  # fmt: skip


def pressure_figure(results: Results, shots: Path, cells: int, stem: Path) -> Path:
    """Front of the block at the end for the first seed, one range of colours."""
    runs = results.tables["runs"]
    limits = _limits(runs, cells)
    figure, axes = panels(2, 3, width=3.3, height=2.2)
    drawn: Any = None
    for ax, name in zip(axes.flat, _SHOWN, strict=True):
        ax.set_title(LOOKS[name][0])
        found = _of(runs, *name, cells)
        path = shots / f"{found['key'].iloc[0]}.npz" if len(found) else shots / "nothing"
        if path.exists():
            drawn = draw_face(ax, path, across=(0, 2), limits=limits, colour_map="RdBu_r")
        else:
            ax.text(0.5, 0.5, "lost or not run", ha="center", va="center")
    if drawn is not None:
        bar = figure.colorbar(drawn, ax=axes.ravel().tolist(), shrink=0.8, extend="both")
        bar.set_label("pressure (tension positive) [Pa]")
    return save_figure(figure, stem)


def _limits(runs: pd.DataFrame, cells: int) -> tuple[float, float]:
    usual = runs[(runs["cells"] == cells) & (runs["stabilisation"] == DEFAULT)]
    size = float(usual[["p_low", "p_high"]].abs().max().max()) if len(usual) else 1.0
    return -size, size


def noise_figure(results: Results, stem: Path) -> Path:
    """Noise over time for each lattice: mean over the seeds."""
    history = results.tables["history"]
    levels = sorted(history["cells"].unique())
    figure, axes = panels(1, len(levels), width=3.8, height=3.0)
    for ax, cells in zip(axes.flat, levels, strict=True):
        for name, (label, look) in LOOKS.items():
            mine = _of(history, *name, cells)
            if len(mine):
                mean = mine.groupby("time")["noise"].mean()
                ax.plot(1e3 * mean.index, mean, label=label, **look)
        ax.set(title=f"{cells} cells a metre", xlabel="time [ms]", ylabel="pressure noise [-]")
        ax.set_ylim(bottom=0.0)
    outside_legend(figure, axes.flat, columns=1 + len(levels))
    return save_figure(figure, stem)


def _of(table: pd.DataFrame, cloud: str, stabilisation: str, cells: int) -> pd.DataFrame:
    return table[
        (table["cloud"] == cloud) & (table["stabilisation"] == stabilisation)
        & (table["cells"] == cells)
    ]  # fmt: skip
