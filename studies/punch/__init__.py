"""Nearly incompressible, pressed: is the pressure clean, and is the shape right?  The punch test.

``python -m studies.punch`` runs [Lee2017] section 8.2 (Figs. 9 to 12): displacement SPH, {p,F,H,J}
with and without the SUPG terms, H1 and H6, tau_p from 0 to 0.2 dt, the operator as printed and the
consistent one, beside the package default and B-bar finite elements on the same lattices and finer
ones, in both readings of a sentence the paper leaves open: the velocity is an initial value, or
held.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from sphsolid import PFJ
from sphsolid.cloud.operator import OperatorKind
from sphsolid.defaults import default_cfl, default_integrator, default_supg
from sphsolid.errors import require
from sphsolid.scenes import punch
from studies.engine.study import Case, Study, Tables
from studies.measures.folding import has_folded
from studies.measures.tables import select
from studies.methods import B_BAR, PACKAGE, SUPG, Method, said
from studies.pictures.picture import keeping
from studies.punch.claims import INDEPENDENT, PAIRS, TOLERANCE, claims
from studies.punch.figures import (
    LATE,
    PICTURED,
    PICTURES,
    height_figure,
    noise_figure,
    profile_figure,
)
from studies.punch.runs import (
    BOTH_OPERATORS,
    CLASSICAL,
    COMPARED,
    CONSISTENT,
    DEFAULTS,
    FINER,
    GALERKIN,
    H1,
    H6,
    LITERAL,
    OTHERS,
    OWN_OPERATOR,
    READINGS,
    TAU_P,
    WIDE,
    WIDE_NO_TAU_P,
    WITH_TAU_F,
    WITHOUT_TAU_F,
    Reading,
    run_case,
    run_cost,
)
from studies.punch.tables import tables

#: Twice the time of the paper's comparison: its Fig. 12 goes on.
END = 0.03
#: Run to the end on the finer lattice too, and on still finer ones.
LONG = (B_BAR, H1, PACKAGE)
#: What a step costs beside one with H1.
_WORK = dict.fromkeys((B_BAR, PACKAGE, CLASSICAL, GALERKIN), 0.7) | {
    method: 4.4 if method in (WIDE, WIDE_NO_TAU_P) else 2.2
    for pair in PAIRS.values() for method in pair if H6.name in method.name
}  # fmt: skip


def _case(
    options: argparse.Namespace,
    reading: Reading,
    method: Method,
    cells: int,
    operator: OperatorKind = CONSISTENT,
    until: float = END,
) -> Case:
    refined = cells / options.cells
    # Figures 10 and 12 of the paper are drawn on the coarsest lattice, Fig. 11 also on the next.
    times = LATE if refined == 1 else (COMPARED,)
    drawn = method in PICTURED and refined <= 2 and reading in READINGS
    cost = refined**4.0 * _WORK.get(method, 1.0) * until / END
    cost *= 2.5 if reading.name.startswith("held") else 1.0
    given = None if method in OWN_OPERATOR else operator
    words = [reading.name, method.name, "" if given is None else given.name, f"1/{cells}"]
    key = " ".join(filter(None, words))
    arguments = {
        "key": key, "reading": reading, "method": method,
        "operator": given, "cells": cells, "until": until,
        "shots": str(options.out / "shots"),
        "shot_times": tuple(t for t in times if t <= until) if drawn else (),
    }  # fmt: skip
    return Case(key, run_case, arguments, cost)


def _coarse(options: argparse.Namespace) -> Iterator[Case]:
    """The paper's smaller lattice."""
    until = COMPARED if options.quick else END
    spare = (WIDE, WIDE_NO_TAU_P, *WITH_TAU_F.values())
    for reading in READINGS:
        for method in OWN_OPERATOR:
            yield _case(options, reading, method, options.cells, until=until)
        for method in BOTH_OPERATORS:
            for operator in (CONSISTENT, LITERAL):
                short = method not in spare and (operator == CONSISTENT or method == H1)
                if short or not options.quick:
                    yield _case(options, reading, method, options.cells, operator, until)
        for tau_p in TAU_P:
            if not options.quick or tau_p in (0.0, 0.1):
                yield _case(options, reading, WITHOUT_TAU_F[tau_p], options.cells, until=until)
            if DEFAULTS[tau_p] != SUPG and (not options.quick or tau_p == 0.0):
                yield _case(options, reading, DEFAULTS[tau_p], options.cells, until=until)


def _fine(options: argparse.Namespace) -> Iterator[Case]:
    """The paper's larger lattice, finer ones, and readings that nobody chose."""
    initial, held = READINGS
    double, triple, quadruple = (n * options.cells for n in (2, 3, 4))
    for method in FINER:
        yield _case(options, initial, method, double)
        # Late steps of the held block are short: its cells are flat.
        yield _case(options, held, method, double, until=END if method in LONG else COMPARED)
    for reading in READINGS:
        yield _case(options, reading, H1, double, LITERAL, until=COMPARED)
    for method in LONG:
        yield _case(options, initial, method, quadruple, until=COMPARED)
        yield _case(options, held, method, triple, until=COMPARED)
        for reading in OTHERS:
            yield _case(options, reading, method, options.cells)
        yield _case(options, OTHERS[0], method, double)


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run, and the timings."""
    require(options.cells >= 10, f"--cells {options.cells}: the block needs at least 10 per metre")
    listed = list(_coarse(options))
    if not options.quick:
        listed += _fine(options)
    for cells in (options.cells,) if options.quick else (options.cells, 2 * options.cells):
        for tau_p in (0.0, 0.1):
            key = f"cost 1/{cells}, tau_p {tau_p:g}"
            arguments = {"key": key, "tau_p": tau_p, "cells": cells}
            listed.append(Case(key, run_cost, arguments, 1.5))
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel."""
    small = argparse.Namespace(**vars(options) | {"cells": 10})
    return [
        _case(small, READINGS[0], method, 10, operator, until=5.0e-4)
        for method, operator in (
            (B_BAR, CONSISTENT), (PACKAGE, CONSISTENT), (CLASSICAL, CONSISTENT),
            (GALERKIN, LITERAL), (H6, CONSISTENT), (SUPG, CONSISTENT), (WIDE, CONSISTENT),
        )
    ]  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--cells``: the coarsest lattice."""
    parser.add_argument(
        "--cells", type=int, default=20,
        help="cells per metre of the coarsest lattice (default 20: the paper's 21x11x3)",
    )  # fmt: skip


def words(tables: Tables) -> Mapping[str, Any]:
    """The runs in the units of the report, and what SUPG leaves to the package."""
    table, chosen = tables["table"], default_supg(PFJ(), punch().material)
    integrator = default_integrator()
    runs = table.assign(
        low_MPa=1e-6 * table["pressure_1"],
        high_MPa=1e-6 * table["pressure_99"],
        rms_mm=1e3 * table["top_rms"],
        same_mm=1e3 * table["profile_same"],
        finest_mm=1e3 * table["profile_finest"],
        operator=table["operator"].fillna("").replace(CONSISTENT.name, ""),
    )
    readings = [reading.name for reading in (*READINGS, *OTHERS)]
    return {
        "by_reading": {n: part for n in readings if len(part := runs[runs["press"] == n])},
        "diverged": runs[~runs["survived"].astype(bool)],
        "folded": runs[has_folded(runs)],
        "lattice": _coarsest(table),
        "pictures": {name: each.is_worth_drawing(tables) for name, each in PICTURES.items()},
        "end": END,
        "compared": COMPARED,
        "independent": INDEPENDENT,
        "tolerance": TOLERANCE,
        "default": PACKAGE.name,
        "default_operator": _operator_of_default(table),
        "package": {
            "integrator": integrator.name,
            "cfl": default_cfl(integrator),
            "weighting": "self-adjoint" if chosen.is_self_adjoint else "printed",
            "tau_F": said(chosen.tau_F),
            "xi_F": chosen.xi_F,
            "tau_p": said(chosen.tau_p),
        },
    }


def _operator_of_default(table: pd.DataFrame) -> str:
    runs = select(table, method=PACKAGE.name)
    return str(runs["operator"].iloc[0]) if len(runs) else "not run"


def _coarsest(table: pd.DataFrame) -> str:
    return str(table.sort_values("cells")["lattice"].iloc[0]) if len(table) else "none"


STUDY = Study(
    name="punch",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"noise": noise_figure, "profile": profile_figure, "height": height_figure}
    | {name: picture.draw for name, picture in PICTURES.items()},
    text=Path(__file__).parent.with_suffix(".md"),
    words=words,
    arguments=arguments,
    keep=keeping(list(PICTURES.values())),
    warm_up=warm_up,
    description="The punch test of Lee et al. (2017): SUPG-SPH, the package default, displacement "
    "SPH and B-bar FEM.",
)
