"""Pictures of the twisted column: the paper's Figs. 14 and 15 and the motion over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from studies.convergence.figures import select
from studies.pictures.colours import limits
from studies.pictures.panels import Layout, panel_figure
from studies.pictures.shots import CELL, Frame, ShotFolder
from studies.report.plotting import save_figure
from studies.twisting_column.cases import shot_key
from studies.twisting_column.methods import (
    DISPLACEMENT,
    FEM,
    H1,
    H6,
    LITERAL,
    PAPER_LATTICES,
    common_lattice,
    finest,
    lattice,
    usual,
)

END = 0.1
#: A panel: its heading, and label, cells and time [s] of the run it shows.
Panel = tuple[str, str, int, float]
PAPER = Layout(width=9.5, height=5.2)


def columns_picture(panels: Sequence[Panel], folder: ShotFolder, stem: Path) -> Path:
    """Surfaces side by side, pressure as means over cells, one colour bar; gives ``stem``."""
    row: list[Frame] = []
    for heading, label, cells, time in panels:
        row.append(replace(folder.load(shot_key(label, cells), time), label=heading))
    # A method without damping has pressures beyond all others: it must not set the colours.
    seen = [frame for frame, panel in zip(row, panels, strict=True) if panel[1] != DISPLACEMENT]
    colours = limits(seen, field=CELL + "pressure", percentile=98.0)
    return save_figure(panel_figure([row], colours=colours, layout=PAPER), stem)


def _ran(table: pd.DataFrame, panels: Sequence[Panel]) -> list[Panel]:
    part = usual(table)
    known = set(zip(part["label"], part["cells"], strict=True))
    return [panel for panel in panels if (panel[1], panel[2]) in known]


def lattices_picture(table: pd.DataFrame, out: Path) -> Path:
    """Fig. 14: the paper's lattices (the coarsest there are) with H6, then with H1, at 0.1 s."""
    numbers = sorted(set(select(usual(table), label=H1)["cells"]))[: len(PAPER_LATTICES)]
    asked = [
        (f"SUPG-SPH-{name}\n{lattice(cells)}", label, cells, END)
        for label, name in ((H6, "H6"), (H1, "H1"))
        for cells in numbers
    ]
    return columns_picture(_ran(table, asked), ShotFolder(out / "shots"), out / "lattices")


def methods_picture(table: pd.DataFrame, out: Path) -> Path:
    """Fig. 15: methods side by side at 0.1 s, the finest on the left and on the right."""
    cells = common_lattice(table)
    ultra, reference = finest(table, H1), finest(table)
    asked: list[Panel] = [
        (f"SUPG-SPH-H1\n{lattice(ultra)}", H1, ultra, END),
        (f"SUPG-SPH-H1\n{lattice(cells)}", H1, cells, END),
        (f"as printed\n{lattice(cells)}", LITERAL, cells, END),
        (f"displacement\nSPH {lattice(cells)}", DISPLACEMENT, cells, END),
        (f"B-bar FEM\n{lattice(cells)}", FEM, cells, END),
        (f"B-bar FEM\n{lattice(reference)}", FEM, reference, END),
    ]
    panels = _ran(table, list(dict.fromkeys(asked)))
    return columns_picture(panels, ShotFolder(out / "shots"), out / "methods")


def sequence_picture(table: pd.DataFrame, out: Path) -> Path:
    """The motion over time on the finest lattice of the paper's H1."""
    cells = int(select(usual(table), label=H1)["cells"].max())
    times = (0.0, 0.02, 0.04, 0.06, 0.08, END)
    asked = [(f"SUPG-SPH-H1, {lattice(cells)}", H1, cells, time) for time in times]
    return columns_picture(_ran(table, asked), ShotFolder(out / "shots"), out / "sequence")
