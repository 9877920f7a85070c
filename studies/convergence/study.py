"""Does the method converge, and at which order?  The swinging cube with every method.

``python -m studies.convergence`` runs {p,F}, {p,F,J} and {p,F,H,J} SUPG-SPH with H1 and H6
secondary particles and the ``Literal``, ``Consistent`` and ``Consistent(force)`` operators,
displacement-based SPH and the B-bar finite element, on the linear limit and on the manufactured
large-strain motion, in both families of exact solutions, and near incompressibility.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from sphsolid.errors import require
from studies.convergence.report import report
from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.report.order import order_table

COLUMNS = [
    "scene", "nu", "family", "method", "formulation", "secondary", "operator", "projection",
    "xi_F", "tau_p", "field", "component", "h", "particles", "steps", "error", "wall_s",
]  # fmt: skip
FAMILY = COLUMNS[:12]
SETTING = COLUMNS[:10]
SUPG_FORMULATIONS = ("{p,F}", "{p,F,J}", "{p,F,H,J}")
FAMILIES = ("A+B+C=0", "A=B=C")
#: The paper's factor of the time-integrated residual with H1 (Fig. 4).  The study's own runs use
#: none: it costs the stress near boundaries its order, which these rows show.
PAPER_XI_F = 0.1
#: Undeformed p-wave speed over s-wave speed: how many more steps a period takes.
_STEPS = {0.3: 1.0, 0.499: 11.5}


def _case(scene: str, family: str, cells: int, method: str, **changes: Any) -> Case:
    arguments: dict[str, Any] = {
        "scene": scene,
        "family": family,
        "poisson_ratio": 0.3,
        "method": method,
        "formulation": "-",
        "secondary": "-",
        "operator": "-",
        "projection": "local" if method == "SUPG-SPH" else "none",
        "xi_F": 0.0,
        "tau_p": 0.0,
        "cells": cells,
    } | changes
    words = [
        scene, f"nu {arguments['poisson_ratio']:g}", family, method,
        *(arguments[name] for name in ("formulation", "secondary", "operator")),
        f"1/{cells}",
    ]  # fmt: skip
    if method == "SUPG-SPH" and arguments["projection"] == "none":
        words.append("no projection")
    if arguments["xi_F"]:
        words.append(f"xi_F {arguments['xi_F']:g}")
    cost = cells**4 * _STEPS[arguments["poisson_ratio"]] * (0.55 if family == "A=B=C" else 1.0)
    cost *= {"H1": 1.0, "H6": 2.3, "-": 0.6}[arguments["secondary"]]
    cost *= 1.6 if scene == "manufactured" else 1.0
    key = " ".join(word for word in words if word != "-")
    return Case(key, "studies.convergence.cases:run_case", arguments, cost)


def _of_level(cells: int, quick: bool) -> Iterator[Case]:
    """All runs at ``h = 1/cells``, nu = 0.3."""
    for scene in ("linear", "manufactured"):
        for family in FAMILIES:
            for operator in ("Literal", "Consistent", "Consistent(force)"):
                for formulation in SUPG_FORMULATIONS:
                    for secondary in ("H1", "H6"):
                        # The short form keeps a cross of the full table, not all of it.
                        spare = formulation != "{p,F}" or secondary == "H6"
                        if quick and spare and (operator != "Consistent" or scene != "linear"):
                            continue
                        yield _case(
                            scene, family, cells, "SUPG-SPH", formulation=formulation,
                            secondary=secondary, operator=operator,
                        )  # fmt: skip
                if not quick:
                    yield _case(
                        scene, family, cells, "SUPG-SPH", formulation="{p,F}", secondary="H1",
                        operator=operator, xi_F=PAPER_XI_F,
                    )  # fmt: skip
            for operator in ("Literal", "Consistent"):
                yield _case(
                    scene, family, cells, "displacement SPH",
                    formulation="displacement", operator=operator,
                )  # fmt: skip
            yield _case(scene, family, cells, "B-bar FEM")
    for operator in ("Consistent", "Consistent(force)"):
        yield _case(
            "linear", "A+B+C=0", cells, "SUPG-SPH", formulation="{p,F}", secondary="H1",
            operator=operator, projection="none", xi_F=PAPER_XI_F,
        )  # fmt: skip
    yield _case(
        "linear", "A+B+C=0", cells, "SUPG-SPH", formulation="{p,F}", secondary="H1",
        operator="Literal(linear kernel)",
    )  # fmt: skip


def _nearly_incompressible(cells: int, secondary: Sequence[str]) -> Iterator[Case]:
    """The linear limit at nu = 0.499, where displacement methods lock or ring."""
    nu, family = {"poisson_ratio": 0.499}, "A+B+C=0"
    for points in secondary:
        for formulation in ("{p,F,J}", "{p,F,H,J}"):
            yield _case(
                "linear", family, cells, "SUPG-SPH", formulation=formulation, secondary=points,
                operator="Consistent", tau_p=0.1, **nu,
            )  # fmt: skip
    yield _case(
        "linear", family, cells, "displacement SPH", formulation="displacement",
        operator="Consistent", **nu,
    )  # fmt: skip
    yield _case("linear", family, cells, "B-bar FEM", **nu)


#: Cells per side of every level, and of the last one where none is named.
LEVELS = (4, 8, 16, 32, 64)
FINEST, FINEST_QUICK = 32, 16


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run of the study; finer levels come last, the front starts long ones first."""
    usual = FINEST_QUICK if options.quick else FINEST
    finest = usual if options.finest is None else options.finest
    require(finest in LEVELS, f"--finest {finest}: choose one of {list(LEVELS)}")
    levels = [cells for cells in LEVELS if cells <= finest]
    listed: list[Case] = []
    for cells in levels:
        listed += _of_level(cells, options.quick)
        if cells <= (8 if options.quick else 16):
            listed += _nearly_incompressible(cells, ("H1",) if options.quick else ("H1", "H6"))
        elif not options.quick:
            listed += _nearly_incompressible(cells, ("H1",))
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Three tiny runs that compile every kernel of the study."""
    sph = {"formulation": "{p,F,H,J}", "secondary": "H1", "operator": "Consistent", "tau_p": 0.1}
    return [
        _case("manufactured", "A=B=C", 2, "SUPG-SPH", **sph),
        _case("manufactured", "A=B=C", 2, "B-bar FEM"),
    ]


def tables(rows: list[Row]) -> Tables:
    """``table``: one row per run and component; ``orders``: one per refinement and component."""
    table = pd.DataFrame(rows, columns=COLUMNS)
    orders = order_table(table, by=FAMILY)
    return {"table": table, "orders": orders, "summary": summarise(table, orders)}


def summarise(table: pd.DataFrame, orders: pd.DataFrame) -> pd.DataFrame:
    """One row per method and scene: worst slope and worst error over the components."""
    rows = []
    if len(table) == 0:
        return pd.DataFrame(columns=SETTING)
    for key, group in orders.groupby(SETTING, sort=False, dropna=False):
        row = dict(zip(SETTING, key, strict=True))
        runs = table[(table[SETTING] == pd.Series(row)).all(axis=1)]
        row["h_finest"] = runs["h"].min()
        for field in ("p", "P"):
            part = group[group["field"] == field]
            row[f"slope_{field}_last"] = part["order_last"].min()
            row[f"slope_{field}_fitted"] = part["order_fitted"].min()
            errors = runs[runs["field"] == field].groupby("h")["error"].max()
            row[f"error_{field}_h16"] = errors.get(1.0 / 16.0)
            row[f"error_{field}_finest"] = errors.iloc[0]
        row["wall_s_finest"] = runs[runs["h"] == row["h_finest"]]["wall_s"].max()
        rows.append(row)
    return pd.DataFrame(rows)


def summary(tables: Tables) -> str:
    """The table printed at the end: errors at the finest level and the worst slopes."""
    frame = tables["summary"].drop(columns=["slope_p_fitted", "slope_P_fitted"])
    return frame.to_string(index=False, float_format=lambda value: f"{value:.3g}")


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--finest``: the last refinement."""
    parser.add_argument(
        "--finest", type=int, help="cells per side of the last level "
        f"(default {FINEST}, {FINEST_QUICK} with --quick)",
    )  # fmt: skip


STUDY = Study(
    name="convergence",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    arguments=arguments,
    warm_up=warm_up,
    description="Convergence of SUPG-SPH, displacement SPH and B-bar FEM on the swinging cube. "
    "With --cloud jitter:J, tet, hex:FILE, tet:FILE or points:FILE[,SURFACE]: all operators on "
    "that cloud instead (options: python -m studies.clouds --help).",
)
