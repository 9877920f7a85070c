"""Which method for which accuracy?  Error against cost of every formulation and element.

``python -m studies.pareto`` runs the swinging cube (manufactured, large strain) and the twisting
column, both at nu = 0.3 and 0.495, with every method of ``methods.py`` on several lattices; one
case at a time, errors on all threads, costs on one.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pandas as pd

from studies.harness.cases import Case
from studies.harness.front import Study
from studies.harness.provenance import cores
from studies.pareto.methods import (
    B_BAR,
    COMPARED,
    METHODS,
    OPTIONS,
    REFERENCES,
    Method,
    goes_finest,
)
from studies.pareto.report import report
from studies.pareto.scenes import (
    COLUMN,
    CUBE,
    END,
    FINEST_CUBE,
    LEVELS,
    QUICK_LEVELS,
    RATIOS,
    SCENES,
)
from studies.pareto.tables import tables
from studies.pareto.verdicts import sentence

#: CPU seconds of a timed window, and how many; the least counts.
WINDOW, REPEATS = 0.15, 5
QUICK_WINDOW, QUICK_REPEATS = 0.03, 3
#: Lattice on which options are compared, and that of the reference of the column.
OPTION_CELLS, QUICK_OPTION_CELLS = 16, 4
FINEST_REFERENCE, QUICK_REFERENCE = 16, 6
#: The short form has one method of each family but the dearest, and all options at nu = 0.3.
SHORT = ("{p,F} H1", "{p,F,J} H1", "{p,F} none", "{p,F,J} H1 TVD-RK2", B_BAR)


def _case(scene: str, nu: float, method: Method, cells: int, quick: bool, repeats: int) -> Case:
    on = method.lattice(cells)
    size = on**3 * (1.0 if scene == CUBE else 6.0)
    cost = 1e-3 * size * on * (5.0 if nu > 0.4 else 1.0) + 0.5 * bool(repeats)
    cost *= 3.0 if method.setting["stabilisation"] == "SUPG-H6" else 1.0
    return Case(
        f"{scene} nu {nu:g} {method.label} 1/{on}" + ("" if repeats else " reference"),
        "studies.pareto.cases:run_case",
        {
            "scene": scene, "nu": nu, "method": method.label, "cells": on, "until": END,
            "window_s": QUICK_WINDOW if quick else WINDOW, "repeats": repeats,
        },
        cost=cost,
    )  # fmt: skip


def _all(quick: bool) -> Iterator[Case]:
    repeats = QUICK_REPEATS if quick else REPEATS
    for scene in SCENES:
        for nu in RATIOS:
            for method in [METHODS[label] for label in SHORT] if quick else COMPARED:
                levels = (QUICK_LEVELS if quick else LEVELS)[scene]
                if scene == CUBE and not quick and goes_finest(method, nu):
                    levels = (*levels, FINEST_CUBE)
                for cells in levels:
                    yield _case(scene, nu, method, cells, quick, repeats)
    for nu in RATIOS:
        for method in [] if quick and nu > RATIOS[0] else OPTIONS:
            # At this lattice the others were run above.
            if method.label not in SHORT if quick else method not in COMPARED:
                cells = QUICK_OPTION_CELLS if quick else OPTION_CELLS
                yield _case(CUBE, nu, method, cells, quick, repeats)
        for label in REFERENCES:
            cells = QUICK_REFERENCE if quick else FINEST_REFERENCE
            yield _case(COLUMN, nu, METHODS[label], cells, quick, 0)


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run of the study."""
    return list(_all(options.quick))


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    tiny = []
    for method in COMPARED:
        for scene in SCENES:
            case = _case(scene, RATIOS[1], method, 2, True, 1)
            arguments = dict(case.arguments) | {"until": 2e-3, "window_s": 1e-3}
            tiny.append(Case(case.key, case.run, arguments))
    return tiny


def summary(tables: dict[str, pd.DataFrame]) -> str:
    """The ratios and the verdict, printed at the end."""
    lines = tables["ratios"].to_string(index=False, float_format=lambda value: f"{value:.3g}")
    stabilised = sentence(tables["ratios_stabilised"])
    return f"{lines}\n{sentence(tables['ratios'])}\nStabilised alone: {stabilised}"


def arguments(parser: argparse.ArgumentParser) -> None:
    """One case at a time: nothing may compete with a timing."""
    parser.set_defaults(jobs=1, threads=cores())


STUDY = Study(
    name="pareto",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,  # type: ignore[arg-type]
    arguments=arguments,
    warm_up=warm_up,
    description="Error against CPU time and memory of SPH and FEM on two scenes.",
)
