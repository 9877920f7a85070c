"""Heat maps of the hard cases: cases by method."""

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


def _draw(
    ax: Axes, table: pd.DataFrame, rows: Sequence[str], columns: Sequence[str], size: float
) -> None:
    """``rows`` are cases, ``columns`` methods; colour is the verdict."""
    code = np.full((len(rows), len(columns)), -1.0)
    for _, row in table.iterrows():
        if row["case"] in rows and row["method"] in columns:
            i, j = list(rows).index(row["case"]), list(columns).index(row["method"])
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
    """All cases against ``methods``."""
    part = table[table["method"].isin(methods)]
    rows = list(dict.fromkeys(part["case"]))
    shown = [method for method in methods if method in set(part["method"])]
    figure, axes = panels(1, 1, width=7.4, height=1.6 + 0.21 * len(rows))
    ax = axes[0, 0]
    _draw(ax, part, rows, shown, 6.2)
    ax.set_xticks(range(len(shown)), shown, rotation=40, ha="left", rotation_mode="anchor")
    ax.xaxis.tick_top()
    ax.set_xlabel(title)
    return _save(figure, out / name)
