"""Where does each method break?  Hard cases in time, and the spectrum of one step.

``python -m studies.stability`` runs every method through twisting columns up to 300 rad/s and
nu = 0.4999, disordered columns, the punch, seeded modes and a pulled block, and computes the
growth of the fastest mode of one step over CFL, support and stabilisation.
"""

from __future__ import annotations

import argparse

from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.stability.hard_case_methods import METHODS, VARIANTS
from studies.stability.hard_cases import CASE_NAMES, hard_case_table, hard_case_warm_up, hard_cases
from studies.stability.report import report
from studies.stability.spectrum_scan import spectrum_cases, spectrum_tables, spectrum_warm_up
from studies.stability.verdicts import verdicts

PARTS = ("both", "hard", "spectrum")


def cases(options: argparse.Namespace) -> list[Case]:
    """The hard cases, then the spectra, or one of the two."""
    listed: list[Case] = []
    if options.part != "spectrum":
        listed += hard_cases(options.quick)
    if options.part != "hard":
        listed += spectrum_cases(options.quick)
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny cases of the parts that run."""
    listed: list[Case] = []
    if options.part != "spectrum":
        listed += hard_case_warm_up()
    if options.part != "hard":
        listed += spectrum_warm_up()
    return listed


def tables(rows: list[Row]) -> Tables:
    """``table``: the hard cases, judged; ``verdicts``; ``spectrum`` and ``spectrum_growth``."""
    hard = hard_case_table(rows)
    return {"table": hard, "verdicts": verdicts(hard, CASE_NAMES)} | spectrum_tables(rows)


def summary(tables: Tables) -> str:
    """Verdict of each claim, and how often each method was sound."""
    table = tables["table"]
    names = [method.name for method in (*METHODS, *VARIANTS)]
    ours = table[table["method"].isin(names)]
    counts = ours.groupby(["method", "verdict"], sort=False).size().unstack(fill_value=0)
    claims = [f"{row.verdict}: {row.claim}" for row in tables["verdicts"].itertuples()]
    return "\n".join([counts.to_string(), *claims])


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--part``: only one half of the study."""
    parser.add_argument("--part", choices=PARTS, default="both", help="default: %(default)s")


STUDY = Study(
    name="stability",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    arguments=arguments,
    warm_up=warm_up,
    description="Hard cases in time and the spectrum of one step, for every method.",
)
