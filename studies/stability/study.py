"""Where does each method break?  Hard cases in time, and the spectrum of one step.

``python -m studies.stability`` runs every method through twisting columns up to 300 rad/s and
nu = 0.4999, longer ones from nu = 0.3 on, disordered columns, the punch, seeded modes, a pulled
block, a free vibration and a short pulse, and computes the growth of the fastest mode of one step
over CFL, support and stabilisation.
"""

from __future__ import annotations

import argparse

import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.stability.hard_case_methods import DEFAULTS, METHODS, VARIANTS
from studies.stability.hard_cases import CASE_NAMES, hard_case_table, hard_case_warm_up, hard_cases
from studies.stability.report import report
from studies.stability.spectrum_scan import spectrum_cases, spectrum_tables, spectrum_warm_up
from studies.stability.verdicts import NO, PARTLY, UNKNOWN, YES, verdicts
from studies.stability.waves import wave_cases, wave_tables, wave_verdicts

FIRST = (NO, PARTLY, UNKNOWN, YES)
PARTS = ("both", "hard", "spectrum")


def cases(options: argparse.Namespace) -> list[Case]:
    """The hard cases, then the spectra, or one of the two."""
    listed: list[Case] = []
    if options.part != "spectrum":
        listed += hard_cases(options.quick) + wave_cases(options.quick)
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
    """``table``: the hard cases, judged; ``verdicts``; ``vibration``, ``pulse``; the spectrum's."""
    hard, waves = hard_case_table(rows), wave_tables(rows)
    said = pd.concat([verdicts(hard, CASE_NAMES), wave_verdicts(waves)], ignore_index=True)
    # What does not hold comes first.
    said = said.sort_values("verdict", key=lambda v: v.map(FIRST.index), kind="stable")
    return {"table": hard, "verdicts": said} | waves | spectrum_tables(rows)


def summary(tables: Tables) -> str:
    """Verdict of each claim, and how often each method was sound."""
    table = tables["table"]
    names = [method.name for method in (DEFAULTS, *METHODS, *VARIANTS)]
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
