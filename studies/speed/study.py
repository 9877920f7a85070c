"""What does a step cost?  Nanoseconds per particle-step, memory and set-up, each run alone.

``python -m studies.speed`` times whole steps (both Runge-Kutta stages, time-step control,
boundary conditions) on the swinging cube.  Timings are minima of repeats on a shared machine:
compare the rows of one run, not runs of different days.
"""

from __future__ import annotations

import argparse
from typing import Any

import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Results, Study
from studies.harness.provenance import cores
from studies.harness.results import Tables
from studies.report.document import Document, Paragraph, Section, Table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

COLUMNS = [
    "solver", "cloud", "storage", "formulation", "secondary", "tau_p", "particles", "threads",
    "ns_per_particle_step", "bytes_per_particle", "setup_s",
]  # fmt: skip
_METHODS = [
    ("SUPG-SPH", "{p,F}", "H1", 0.0),
    ("SUPG-SPH", "{p,F,J}", "H1", 0.0),
    ("SUPG-SPH", "{p,F,J}", "H1", 0.1),
    ("SUPG-SPH", "{p,F,H,J}", "H1", 0.1),
    ("SUPG-SPH", "{p,F}", "H6", 0.0),
    ("displacement SPH", "displacement", "-", 0.0),
    ("B-bar FEM", "-", "-", 0.0),
]


def _case(method: tuple[str, str, str, float], cells: int, threads: int, jitter: float) -> Case:
    solver, formulation, secondary, tau_p = method
    arguments: dict[str, Any] = {
        "solver": solver,
        "formulation": formulation,
        "secondary": secondary,
        "tau_p": tau_p,
        "jitter": jitter,
        "cells": cells,
        "threads": threads,
    }
    words = [solver, formulation, secondary, f"tau_p {tau_p:g}", f"1/{cells}"]
    words += [f"jitter {jitter:g}" if jitter else "lattice", f"{threads} thread(s)"]
    key = " ".join(word for word in words if word != "-")
    return Case(key, "studies.speed.cases:run_case", arguments, 1.0 + (cells / 32) ** 3)


def cases(options: argparse.Namespace) -> list[Case]:
    """Every method at 33^3 on one and all threads; the full form adds 65^3 and disorder."""
    counts = sorted({1, options.threads})
    listed = [_case(method, 32, n, 0.0) for method in _METHODS for n in counts]
    if not options.quick:
        listed += [_case(_METHODS[0], 32, n, 0.2) for n in counts]
        listed += [_case(method, 64, options.threads, 0.0) for method in _METHODS[:2]]
        listed.append(_case(_METHODS[-1], 64, options.threads, 0.0))
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    return [_case(_METHODS[3], 2, options.threads, 0.0), _case(_METHODS[-1], 2, options.threads, 0)]


def tables(rows: list[Row]) -> Tables:
    """``table``: one row per timing."""
    return {"table": pd.DataFrame(rows, columns=COLUMNS)}


def report(results: Results) -> Document:
    """A document of one table."""
    return Document(
        title="What a step costs",
        subtitle=subtitle(results.run),
        abstract=(
            "Whole steps on the swinging cube, minimum of repeats. A particle-step holds both "
            "stages of TVD-RK2, projection and time-step control; an element-step of the finite "
            "element reference is one force evaluation of central differences at about twice the "
            "step. Accuracy for the cost is the subject of another study."
        ),
        sections=[
            Section(
                "Timings",
                [
                    Paragraph(
                        "Bytes a particle count the arrays alive during the run; set-up seconds "
                        "hold the neighbour search, the operators and the correction."
                    ),
                    Table(
                        "Cost per particle-step (per element-step for FEM).",
                        results.tables["table"],
                        formats={
                            "ns_per_particle_step": ".0f",
                            "bytes_per_particle": ".0f",
                            "setup_s": ".1f",
                            "tau_p": "g",
                        },
                        headings={
                            "ns_per_particle_step": "ns / step",
                            "bytes_per_particle": "B / particle",
                            "setup_s": "set-up s",
                            "secondary": "sec.",
                        },
                    ),
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


def arguments(parser: argparse.ArgumentParser) -> None:
    """Timings run one at a time with all cores."""
    parser.set_defaults(jobs=1, threads=cores())


STUDY = Study(
    name="speed",
    cases=cases,
    tables=tables,
    report=report,
    arguments=arguments,
    warm_up=warm_up,
    description="Cost of a step of every method; each timing runs alone.",
)
