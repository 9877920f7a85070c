"""The plate in colour, the ligament and the edge of the hole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from studies.harness.results import Results
from studies.pictures.face import draw_face
from studies.plate_with_hole.cases import FEM, RADIUS
from studies.report.plotting import (
    BLACK,
    BLUE,
    ORANGE,
    SKY,
    VERMILION,
    outside_legend,
    panels,
    save_figure,
)

#: (method, operator, mesh) -> label, line keywords.
LOOKS: dict[tuple[str, str], tuple[str, dict[str, Any]]] = {
    ("-", "hex"): ("B-bar, hexahedra", {"color": BLACK, "marker": "D"}),
    ("SummationByParts", "hex"): ("SPH, hexahedra", {"color": BLUE, "marker": "o"}),
    ("SummationByParts", "tet"): ("SPH, tetrahedra", {"color": VERMILION, "marker": "^"}),
    ("Consistent", "hex"): ("SPH Consistent, hexahedra", {"color": SKY, "marker": "s"}),
    ("Consistent", "tet"): ("SPH Consistent, tetrahedra", {"color": ORANGE, "marker": "v"}),
}
#: Hoop stress over the pull at the ends of the colours.
COLOURS = (-1.5, 3.5)


def plate_figure(results: Results, shots: Path, stem: Path) -> Path:
    """Front of the plate with the hoop stress, every run in plane strain that kept a picture."""
    table = results.tables["table"]
    shown = [
        (LOOKS[operator, mesh][0], shots / f"{row['key']}.npz")
        for operator, mesh in (("-", "hex"), ("SummationByParts", "hex"),
                               ("SummationByParts", "tet"))
        for _, row in _of(table, "plane_strain", operator, mesh).iterrows()
    ]  # fmt: skip
    shown = [(label, path) for label, path in shown if path.exists()]
    figure, axes = panels(1, max(1, len(shown)), width=2.9, height=2.7)
    drawn: Any = None
    for ax, (label, path) in zip(axes.flat, shown, strict=False):
        drawn = draw_face(ax, path, limits=COLOURS, colour_map="viridis")
        ax.set_title(label)
    if drawn is not None:
        _colour_bar(figure, axes, drawn)
    return save_figure(figure, stem)


def _colour_bar(figure: Figure, axes: NDArray[Any], drawn: Any) -> None:
    bar = figure.colorbar(drawn, ax=axes.ravel().tolist(), shrink=0.8)
    bar.set_label("hoop stress / pull [-]")


def line_figure(results: Results, stem: Path) -> Path:
    """Ligament (left), near the hole (middle) and ring of cells at the hole (right)."""
    table, ligament, ring, plane = (
        results.tables[name] for name in ("table", "ligament", "ring", "plane")
    )
    figure, axes = panels(1, 3, width=3.2, height=2.9)
    for ax in axes.flat[:2]:
        ax.plot(plane["X"], plane["stress"], color="0.6", linewidth=2.5, label="plane reference")
    for (operator, mesh), (label, look) in LOOKS.items():
        for key in _of(table, "plane_strain", operator, mesh)["key"]:
            # Particles on the line of a cloud of tetrahedra are at different heights: no line.
            style = {"linestyle": "none"} if mesh == "tet" else {"linewidth": 0.9}
            mine = ligament[ligament["key"] == key]
            for ax in axes.flat[:2]:
                ax.plot(mine["X"], mine["stress"], label=label, markersize=3.2, **look | style)
            around = ring[ring["key"] == key]
            if len(around):
                axes[0, 2].plot(
                    around["angle"], around["stress"], label=label, markersize=3.2,
                    **look | {"linewidth": 0.9},
                )  # fmt: skip
    y_label = "stress along Y / pull [-]"
    axes[0, 0].set(title="ligament, Y = 0", xlabel="X [m]", ylabel=y_label)
    axes[0, 1].set(title="ligament beside the hole", xlabel="X [m]", ylabel=y_label)
    axes[0, 1].set(xlim=(RADIUS - 0.002, 1.5 * RADIUS), ylim=(1.2, 3.7))
    axes[0, 2].set(
        title="middles of the cells at the hole", xlabel="angle from the X axis [deg]",
        ylabel="hoop stress / pull [-]",
    )  # fmt: skip
    outside_legend(figure, axes.flat, columns=3)
    return save_figure(figure, stem)


def _of(table: pd.DataFrame, thickness: str, operator: str, mesh: str) -> pd.DataFrame:
    named = table["operator"].where(table["method"] != FEM, "-")
    return table[
        (table["thickness"] == thickness) & (named == operator) & (table["mesh"] == mesh)
    ]
