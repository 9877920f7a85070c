"""Do codes that share nothing with ours agree with it?  ``python -m studies.outside``.

CalculiX solves the scenes from decks that are written from them: columns, a vibration, the L-shaped
block, the punch and a swinging beam.  Where it is not installed, or with ``--codes ours``, its
figures are those that an earlier run left.  Figures of particle codes stand beside ours.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from studies.engine.case import Case, Row
from studies.engine.results import Tables
from studies.engine.sources import ROOT
from studies.engine.study import Study
from studies.methods import B_BAR, PACKAGE, TAYLOR_HOOD, Method
from studies.outside import claims as judged
from studies.outside.calculix import installed
from studies.outside.figures import FIGURES, main_quantity
from studies.outside.problems import (
    PROBLEMS,
    VIBRATION_NU,
    VIBRATION_OURS,
    VIBRATION_OUTSIDE,
    Beam,
    Column,
    Problem,
    frequency_name,
)
from studies.outside.runs import (
    OURS,
    OUTSIDE,
    frequency_ours,
    frequency_outside,
    run_ours,
    run_outside,
    started,
)
from studies.outside.sequences import CALCULIX, column_reference, comparison

METHODS = (PACKAGE, B_BAR, TAYLOR_HOOD)
#: Figures of CalculiX that stand where none are made now, and figures of others.
STORED = ROOT / "reports" / "outside" / "calculix.csv"
PUBLISHED = Path(__file__).with_name("published.csv")
#: The column whose table ``studies.twisting_column`` reads.
REFERENCE = Column(0.495)
VALUE = ["quantity", "value"]


def methods_for(problem: Problem, level: int) -> Sequence[Method]:
    """Which of ours solve a level: elements of 27 nodes need an even number of cells."""
    return METHODS[:2] if isinstance(problem, Beam) or level % 2 else METHODS


def outside_cases(quick: bool) -> Iterator[Case]:
    """Runs of CalculiX; the short form has the coarsest mesh of what takes seconds."""
    for nu in VIBRATION_NU[:1] if quick else VIBRATION_NU:
        for level in VIBRATION_OUTSIDE[:2] if quick else VIBRATION_OUTSIDE:
            key = f"CalculiX, {frequency_name(nu)}, {level}"
            yield Case(key, frequency_outside, {"nu": nu, "level": level}, 1e-3 * level**3)
    for problem in PROBLEMS:
        if quick and not isinstance(problem, Beam):
            continue
        for level in problem.outside[:1] if quick else problem.outside:
            key = f"CalculiX, {problem.name}, {level}"
            cost = 10.0 * (level / problem.outside[0]) ** 3
            yield Case(key, run_outside, {"problem": problem, "level": level}, cost)


def our_cases(quick: bool) -> Iterator[Case]:
    """Our runs: all levels, or in short the coarsest of the vibration and the beam."""
    for nu in VIBRATION_NU[:1] if quick else VIBRATION_NU:
        for level in VIBRATION_OURS[:1] if quick else VIBRATION_OURS:
            for method in METHODS[:2] if quick else METHODS:
                given = {"nu": nu, "method": method, "level": level}
                key = f"{method.name}, {frequency_name(nu)}, {level}"
                yield Case(key, frequency_ours, given, 1e-3 * level**4)
    for problem in PROBLEMS:
        if quick and not isinstance(problem, Beam):
            continue
        for level in problem.ours[:1] if quick else problem.ours:
            for method in methods_for(problem, level):
                given = {"problem": problem, "method": method, "level": level}
                cost = 60.0 * (level / problem.ours[-1]) ** 4
                yield Case(f"{method.name}, {problem.name}, {level}", run_ours, given, cost)


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """What the command line asks for and the machine can do."""
    listed = list[Case]()
    if options.codes != "ours" and installed():
        listed += outside_cases(options.quick)
    if options.codes != "outside":
        listed += our_cases(options.quick)
    return listed


def tiny(options: argparse.Namespace) -> Sequence[Case]:
    """Runs that compile the kernels of every method, with both laws."""
    if options.codes == "outside":
        return []
    return [
        Case(f"{method.name}, {problem.name}, start", started,
             {"problem": problem, "method": method, "level": 4})
        for problem in (REFERENCE, PROBLEMS[-2]) for method in methods_for(problem, 4)
    ]  # fmt: skip


def tables(rows: list[Row]) -> Tables:
    """``table``: limits beside each other; ``calculix`` and ``ours``: a row a run and quantity.

    ``particles``: figures of other particle codes beside ours; ``column_reference``: a table for
    ``studies.twisting_column``.  Runs of CalculiX that were not made now are those of
    :data:`STORED`.
    """
    ours = _frame(rows, "ours", [*OURS, *VALUE])
    calculix = with_stored(_frame(rows, "calculix", [*OUTSIDE, *VALUE]))
    table = comparison(calculix, ours)
    return {
        "table": table,
        "calculix": calculix,
        "ours": ours,
        "particles": beside_particles(ours, calculix),
        "column_reference": column_reference(calculix, REFERENCE.name),
    }


def with_stored(made: pd.DataFrame, stored: Path = STORED) -> pd.DataFrame:
    """``made`` now, and of an earlier table the runs that were not."""
    if not stored.exists():
        return made
    before = pd.read_csv(stored)[list(made.columns)]
    run = ["problem", "level", "step_ms"]
    now = set(made[run].fillna(0.0).itertuples(index=False, name=None))
    again = [row in now for row in before[run].fillna(0.0).itertuples(index=False, name=None)]
    kept = before[~np.array(again, dtype=bool)]
    both = [frame for frame in (kept, made) if len(frame)]
    if not both:
        return made
    order = ["problem", "level"]
    return pd.concat(both).sort_values(order, kind="stable", ignore_index=True)


def beside_particles(ours: pd.DataFrame, calculix: pd.DataFrame) -> pd.DataFrame:
    """Rows of :data:`PUBLISHED`, then the same quantities by CalculiX and by us, by points."""
    published = pd.read_csv(PUBLISHED, comment="#")
    wanted = published[["problem", "quantity"]].drop_duplicates()
    columns = ["problem", "quantity", "code", "points", "low", "high", "source"]
    parts = [published[columns]]
    for frame, code in ((calculix, None), (ours, "method")):
        own = wanted.merge(frame, on=["problem", "quantity"])
        if len(own):
            own = own.assign(
                code=CALCULIX if code is None else own[code],
                points=own["level"] * (2 if code is None else 1) + 1,
                low=own["value"], high=own["value"], source="this study",
            )  # fmt: skip
            parts.append(own[columns])
    both = pd.concat(parts, ignore_index=True)
    return both.sort_values(["problem", "quantity"], kind="stable", ignore_index=True)


def _frame(rows: list[Row], of: str, columns: Sequence[str]) -> pd.DataFrame:
    return pd.DataFrame([row for row in rows if row["of"] == of], columns=list(columns))


def words(tables: Tables) -> Mapping[str, Any]:
    """The version of CalculiX, thresholds, and the parts of the tables that are printed."""
    calculix, table = tables["calculix"], tables["table"]
    runs = calculix.drop(columns=VALUE).drop_duplicates()
    problems = calculix["problem"].drop_duplicates()
    main = {(problem, main_quantity(calculix, problem)) for problem in problems}
    is_main = [pair in main for pair in zip(table["problem"], table["quantity"], strict=True)]
    return {
        "main": table[is_main],
        "versions": ", ".join(sorted(set(calculix["version"].astype(str)))) or "none",
        "runs": runs, "judged": judged, "explained": judged.explained(tables),
        "cylinder": judged.of_the_clamp(tables),
    }  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--codes``: both, ours alone (CalculiX from an earlier run's table), or CalculiX alone."""
    parser.add_argument(
        "--codes", choices=("both", "ours", "outside"), default="both",
        help="what is run (default both; CalculiX only where it is installed)",
    )  # fmt: skip


STUDY = Study(
    name="outside",
    cases=cases,
    tables=tables,
    claims=judged.claims,
    figures=FIGURES,
    words=words,
    text=Path(__file__).with_name("report.md"),
    arguments=arguments,
    warm_up=tiny,
    description="Scenes by CalculiX and figures of particle codes, beside ours.",
)
