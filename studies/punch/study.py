"""Nearly incompressible, pressed: is the pressure clean, and is the shape right?  The punch test.

``python -m studies.punch`` runs [Lee2017] section 8.2 (Figs. 9 to 12): displacement SPH,
{p,F,H,J} with and without the SUPG terms, H1 and H6, tau_p from 0 to 0.2 dt, the operator as
printed and the consistent one, beside B-bar finite elements on the same lattices and finer ones,
in both readings of a sentence the paper leaves open: the velocity is an initial value, or held.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from sphsolid.errors import require
from studies.harness.cases import Case
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.punch.cases import COMPARED, PRESSES
from studies.punch.methods import (
    DISPLACEMENT,
    FEM,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    LABELS,
    METHODS,
    TAU_P,
    TOOLKIT,
    WIDE,
    WIDE_NO_TAU_P,
    toolkit,
    whole_tau_F,
    without_tau_F,
)
from studies.punch.report import report
from studies.punch.tables import tables

#: Twice the time of the paper's comparison: its Fig. 12 goes on.
END = 0.03
READINGS = ("initial", "held")
#: Run with both operators on the coarsest lattice; the others with the consistent one alone.
BOTH_OPERATORS = (
    DISPLACEMENT, GALERKIN, H6_NO_TAU_P, H6, H1, TOOLKIT, *map(whole_tau_F, TAU_P),
    WIDE_NO_TAU_P, WIDE,
)  # fmt: skip
FINER = (FEM, DISPLACEMENT, H6_NO_TAU_P, H6, H1, TOOLKIT)
#: Run to the end on the finer lattice too, and on still finer ones.
LONG = (FEM, H1)
#: What a step costs beside one of {p,F,J} H1.
_WORK = {"-": 0.7, "H1": 1.0, "H6": 2.2}


def _case(
    options: argparse.Namespace,
    press: str,
    method: str,
    cells: int,
    operator: str = "Consistent",
    until: float = END,
) -> Case:
    operator = "-" if method == FEM else operator
    refined = cells / options.cells
    words = [press, method, operator, f"1/{cells}"]
    # Figures 10 and 12 of the paper are drawn on the coarsest lattice, Fig. 11 also on the next.
    times = [0.005, 0.01, 0.015, 0.02, 0.025, 0.03] if refined == 1 else [COMPARED]
    drawn = method in LABELS and refined <= 2 and press in READINGS
    cost = refined**4.0 * _WORK[METHODS[method].secondary] * until / END
    cost *= (2.5 if press.startswith("held") else 1.0) * (2.0 if METHODS[method].wide else 1.0)
    key = " ".join(word for word in words if word != "-")
    return Case(
        key,
        "studies.punch.cases:run_case",
        {
            "key": key,
            "press": press,
            "method": method,
            "operator": operator,
            "cells": cells,
            "until": until,
            "shots": str(options.out / "shots"),
            "shot_times": [t for t in times if t <= until] if drawn else [],
            "label": LABELS.get(method, method),
        },
        cost,
    )


def _coarse(options: argparse.Namespace) -> Iterator[Case]:
    """The paper's smaller lattice."""
    until = COMPARED if options.quick else END
    for press in READINGS:
        yield _case(options, press, FEM, options.cells, until=until)
        for method in BOTH_OPERATORS:
            for operator in ("Consistent", "Literal"):
                spare = METHODS[method].wide or method in map(whole_tau_F, TAU_P)
                if not (options.quick and (spare or (operator == "Literal" and method != H1))):
                    yield _case(options, press, method, options.cells, operator, until)
        for tau_p in TAU_P:
            if not options.quick or tau_p in (0.0, 0.1):
                yield _case(options, press, without_tau_F(tau_p), options.cells, until=until)
            if toolkit(tau_p) != TOOLKIT and (not options.quick or tau_p == 0.0):
                yield _case(options, press, toolkit(tau_p), options.cells, until=until)


def _fine(options: argparse.Namespace) -> Iterator[Case]:
    """The paper's larger lattice, finer ones, and readings that nobody chose."""
    double, triple, quadruple = (n * options.cells for n in (2, 3, 4))
    for method in FINER:
        yield _case(options, "initial", method, double)
        # Late steps of the held block are short: its cells are flat.
        yield _case(options, "held", method, double, until=END if method in LONG else COMPARED)
    for press in READINGS:
        yield _case(options, press, H1, double, "Literal", until=COMPARED)
    for method in LONG:
        yield _case(options, "initial", method, quadruple, until=COMPARED)
        yield _case(options, "held", method, triple, until=COMPARED)
        for press in PRESSES:
            if press not in READINGS:
                yield _case(options, press, method, options.cells)
        yield _case(options, "initial, top face only", method, double)


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run; see :data:`studies.punch.methods.METHODS`."""
    require(options.cells >= 10, f"--cells {options.cells}: the block needs at least 10 per metre")
    listed = list(_coarse(options))
    if not options.quick:
        listed += _fine(options)
    for cells in (options.cells,) if options.quick else (options.cells, 2 * options.cells):
        for tau_p in (0.0, 0.1):
            key = f"cost 1/{cells}, tau_p {tau_p:g}"
            arguments = {"key": key, "tau_p": tau_p, "cells": cells}
            listed.append(Case(key, "studies.punch.cost:run_case", arguments, 1.5))
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel."""
    small = argparse.Namespace(**vars(options) | {"cells": 10})
    return [
        _case(small, "initial", method, 10, operator, until=5.0e-4)
        for method, operator in (
            (FEM, "-"), (DISPLACEMENT, "Consistent"), (GALERKIN, "Literal"), (H6, "Consistent"),
            (TOOLKIT, "Consistent"), (WIDE, "Consistent"),
        )
    ]  # fmt: skip


def summary(tables: Tables) -> str:
    """Printed at the end."""
    columns = [
        "press", "method", "operator", "lattice", "survived", "folded", "top_low", "top_high",
        "profile_same", "noise_mean", "energy_kept", "steps", "cpu_s",
    ]  # fmt: skip
    return tables["table"][columns].to_string(
        index=False, float_format=lambda value: f"{value:.4g}"
    )


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--cells``: the coarsest lattice."""
    parser.add_argument(
        "--cells", type=int, default=20,
        help="cells per metre of the coarsest lattice (default 20: the paper's 21x11x3)",
    )  # fmt: skip


STUDY = Study(
    name="punch",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    arguments=arguments,
    warm_up=warm_up,
    description="The punch test of Lee et al. (2017): SUPG-SPH, displacement SPH and B-bar FEM.",
)
