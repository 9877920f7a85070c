"""Heat maps of the hard cases: one a method (cases by step), and all at the usual step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from studies.report.plotting import panels, save_figure
from studies.stability.hard_case_judgement import ABSENT, LOST, SOUND, USELESS, cell_text

COLOURS = {SOUND: "#9fd8c0", USELESS: "#f6cf7a", LOST: "#d9765c", ABSENT: "#ececec"}
_ORDER = list(COLOURS)
#: Methods in one figure of panels: more would be too small to read.
PER_FIGURE = 4


def _draw(
    ax: Axes, table: pd.DataFrame, rows: Sequence[str], columns: Sequence[str], across: str,
    size: float,
) -> None:  # fmt: skip
    """``rows`` are cases, ``columns`` values of ``across``; colour is the verdict."""
    code = np.full((len(rows), len(columns)), -1.0)
    for _, row in table.iterrows():
        if row["case"] in rows and row[across] in columns:
            i, j = list(rows).index(row["case"]), list(columns).index(row[across])
            code[i, j] = _ORDER.index(row["verdict"])
            ax.text(j, i, cell_text(row.to_dict()), ha="center", va="center", size=size)
    colours = ListedColormap(["#ffffff", *COLOURS.values()])
    norm = BoundaryNorm(np.arange(-1.5, len(_ORDER)), colours.N)
    ax.imshow(code, cmap=colours, norm=norm, aspect="auto")
    ax.set_yticks(range(len(rows)), rows)
    ax.set_xticks(range(len(columns)), columns)
    ax.set_xticks(np.arange(0.5, len(columns) - 1), minor=True)
    ax.set_yticks(np.arange(0.5, len(rows) - 1), minor=True)
    ax.grid(visible=False, which="major")
    ax.grid(which="minor", color="white", linewidth=1.0)
    ax.tick_params(which="both", length=0)
    ax.tick_params(axis="both", labelsize=size + 0.7)
    for side in ax.spines.values():
        side.set_visible(False)


def _save(figure: object, stem: Path) -> Path:
    handles = [Patch(facecolor=colour, label=name) for name, colour in COLOURS.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)  # type: ignore[attr-defined]
    return save_figure(figure, stem)  # type: ignore[arg-type]


def overview(
    table: pd.DataFrame, out: Path, *, name: str, methods: Sequence[str], title: str
) -> Path:
    """All cases against ``methods`` at the usual step."""
    part = table[(table["step"] == "usual") & table["method"].isin(methods)]
    rows = list(dict.fromkeys(part["case"]))
    shown = [method for method in methods if method in set(part["method"])]
    figure, axes = panels(1, 1, width=7.4, height=1.6 + 0.21 * len(rows))
    ax = axes[0, 0]
    _draw(ax, part, rows, shown, "method", 6.2)
    ax.set_xticks(range(len(shown)), shown, rotation=40, ha="left", rotation_mode="anchor")
    ax.xaxis.tick_top()
    ax.set_xlabel(title)
    return _save(figure, out / name)


def maps_of_methods(table: pd.DataFrame, out: Path, methods: Sequence[str]) -> list[Path]:
    """One panel a method: cases by step, :data:`PER_FIGURE` panels a figure."""
    shown = [method for method in methods if method in set(table["method"])]
    paths = []
    for number, start in enumerate(range(0, len(shown), PER_FIGURE)):
        group = shown[start : start + PER_FIGURE]
        rows = list(dict.fromkeys(table["case"]))
        figure, axes = panels(1, len(group), width=7.4 / len(group), height=0.9 + 0.19 * len(rows))
        for place, (ax, method) in enumerate(zip(axes.flat, group, strict=True)):
            part = table[table["method"] == method]
            steps = {f"CFL {cfl:.2g}": cfl for cfl in sorted(set(part["cfl"]))}
            part = part.assign(label=[f"CFL {cfl:.2g}" for cfl in part["cfl"]])
            _draw(ax, part, rows, list(steps), "label", 6.2)
            ax.set_title(method.replace(", ", ",\n"), fontsize=7.5)
            if place:
                ax.set_yticklabels([])
        paths.append(_save(figure, out / f"hard_cases_{number + 1}"))
    return paths
