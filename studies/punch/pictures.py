"""Pictures of the punch test: frames of methods over times, after Figs. 10 to 12 of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from studies.convergence.figures import select
from studies.harness.results import Results
from studies.pictures.colours import ColourRange
from studies.pictures.panels import Layout, panel_figure
from studies.pictures.shots import CELL, Absent, Frame, Lost, ShotFolder
from studies.pictures.view import flat_view
from studies.punch.cases import COMPARED
from studies.punch.methods import DISPLACEMENT, FEM, GALERKIN, H1, H6, H6_NO_TAU_P, LABELS
from studies.report.plotting import save_figure

#: Ends of the colour bar [Pa], the same in every picture, so that they can be compared.
PRESSURE = 4.0e6
#: What particles have, fluctuations and all: a mean over cells would hide them.
OWN = ColourRange("pressure", -PRESSURE, PRESSURE, (True, True))
#: The same of particles and elements: means over cells.
ALIKE = ColourRange(CELL + "pressure", -PRESSURE, PRESSURE, (True, True))
#: (a) to (d) of Fig. 10: particles alone, whose own values are shown.
FIG_10 = (DISPLACEMENT, GALERKIN, H6_NO_TAU_P, H6)
READINGS = ("initial", "held")


@dataclass(frozen=True)
class Nothing:
    """In the place of a picture whose runs were not made."""


def one_run(
    table: pd.DataFrame, press: str, method: str, operator: str = "Consistent", level: int = 0
) -> pd.DataFrame:
    """The row of a run, or none; ``level`` 0 is the coarsest lattice, 1 the next."""
    operator = "-" if method == FEM else operator
    levels = sorted(table["cells"].unique())
    if level >= len(levels):
        return table.iloc[:0]
    return select(
        table, press=press, method=method, operator=operator, cells=levels[level]
    ).head(1)


def _frame(
    results: Results,
    press: str,
    method: str,
    time: float,
    operator: str = "Consistent",
    *,
    level: int = 0,
    label: str = "",
) -> Frame:
    run = one_run(results.tables["table"], press, method, operator, level)
    label = label or LABELS[method]
    if len(run) == 0 or run["until"].iloc[0] < time - 1e-9:
        return Absent(label=label, time=time)
    found = ShotFolder(results.out / "shots").load(run["key"].iloc[0], time)
    if isinstance(found, Lost):
        return Lost(label=label, time=time, lost_at=found.lost_at)
    return replace(found, label=label)


def _save(
    grid: Sequence[Sequence[Frame]], stem: Path, colours: ColourRange = ALIKE
) -> Path | Nothing:
    """Draw; nothing where most panels would be empty, as in the short form."""
    frames = [frame for row in grid for frame in row]
    if 2 * sum(isinstance(frame, Absent) for frame in frames) >= len(frames):
        return Nothing()
    figure = panel_figure(
        grid,
        colours=colours,
        view=flat_view(right="x", up="z"),
        layout=Layout(width=7.2, height=8.5),
    )
    return save_figure(figure, stem)


def evolution_picture(results: Results, press: str, operator: str, stem: Path) -> Path | Nothing:
    """After Fig. 10: particle methods down, 5, 10 and 15 ms across; gives ``stem``."""
    grid = [
        [_frame(results, press, method, time, operator) for time in (0.005, 0.01, COMPARED)]
        for method in FIG_10
    ]
    return _save(grid, stem, OWN)


def comparison_picture(results: Results, stem: Path) -> Path | Nothing:
    """After Fig. 11: H6 and H1 at 15 ms, H1 and finite elements on the finer lattice too."""
    table = results.tables["table"]
    lattices = [
        table[table["cells"] == cells]["lattice"].iloc[0]
        for cells in sorted(table["cells"].unique())[:2]
    ]
    shown = [(H6, 0), (H1, 0), (FEM, 0), (H1, 1), (FEM, 1)]
    grid = [
        [
            _frame(
                results, press, method, COMPARED, level=level,
                label=f"{LABELS[method].splitlines()[0]}\n{lattices[level]}",
            )
            for press in READINGS
        ]
        for method, level in shown
        if level < len(lattices)
    ]  # fmt: skip
    return _save(grid, stem)


def sequence_picture(results: Results, press: str, stem: Path) -> Path | Nothing:
    """After Fig. 12: H1 and finite elements, 5 to 30 ms; gives ``stem``."""
    times = (0.005, 0.01, 0.015, 0.02, 0.025, 0.03)
    grid = [[_frame(results, press, method, time) for method in (H1, FEM)] for time in times]
    return _save(grid, stem)
