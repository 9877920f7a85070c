"""Which consistent operator?  One choice changed at a time, on two scenes.

``python -m studies.operators`` asks of every variant the orders and errors of {p,F} SUPG-SPH-H1 on
the swinging cube (linear limit, both families) and, because an accurate operator that makes energy
is of no use, twist, energy and pressure range of {p,F,J} on the twisting column at nu = 0.495.
"""

from __future__ import annotations

import argparse
from typing import Any

import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Results, Study
from studies.harness.results import Tables
from studies.report.document import Document, Paragraph, Section, Table
from studies.report.order import order_table
from studies.report.standard_sections import subtitle, what_failed, what_was_run

DEFAULT: dict[str, Any] = {
    "use": "everywhere",
    "smoothing": "Wendland C2",
    "h_over_dx": 0.77,
    "exponent": 0.5,
    "gradient": "corrected_kernel",
    "layers": 2,
    "initial_strain": "compatible",
    "xi_F": 0.0,
}
VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "as printed": {"use": "nowhere"},
    "as printed, linear-kernel gradient": {"use": "nowhere", "gradient": "linear_kernel"},
    "as printed, support 1.4 dx": {"use": "nowhere", "h_over_dx": 0.7},
    "weights W^0": {"exponent": 0.0},
    "weights W^1": {"exponent": 1.0},
    "weights W^2": {"exponent": 2.0},
    "cubic spline": {"smoothing": "cubic spline"},
    "cubic spline, W^0": {"smoothing": "cubic spline", "exponent": 0.0},
    "cubic spline, W^1": {"smoothing": "cubic spline", "exponent": 1.0},
    "quintic spline": {"smoothing": "quintic spline", "h_over_dx": 0.51},
    "support 1.44 dx": {"h_over_dx": 0.72},
    "support 1.5 dx": {"h_over_dx": 0.75},
    "support 1.8 dx": {"h_over_dx": 0.9},
    "support 2 dx": {"h_over_dx": 1.0},
    "linear-kernel gradient": {"gradient": "linear_kernel"},
    "band of 4 layers": {"layers": 4},
    "xi_F = 0.05": {"xi_F": 0.05},
    "xi_F = 0.1": {"xi_F": 0.1},
    "given initial strain": {"initial_strain": "given"},
    "force only, given strain": {"use": "force", "initial_strain": "given"},
    "force only, compatible strain": {"use": "force"},
    "force only, given strain, xi_F = 0.1": {
        "use": "force", "initial_strain": "given", "xi_F": 0.1,
    },
}  # fmt: skip
FAMILIES = ("A+B+C=0", "A=B=C")
_SHORT_FORM = ("default", "cubic spline", "force only, given strain")


def cases(options: argparse.Namespace) -> list[Case]:
    """Cube at 1/8, 1/16 (and 1/32), column on 4x19x4 and 6x31x6, for every variant."""
    listed = []
    for variant, changes in VARIANTS.items():
        if options.quick and variant not in _SHORT_FORM:
            continue
        arguments = {"variant": variant} | DEFAULT | changes
        for cells in (8, 16) if options.quick else (8, 16, 32):
            for family in FAMILIES:
                listed.append(
                    Case(
                        f"cube {family} 1/{cells}: {variant}",
                        "studies.operators.cases:cube",
                        arguments | {"family": family, "cells": cells},
                        cost=cells**4 * (0.55 if family == "A=B=C" else 1.0) / 16**4,
                    )
                )
        for cells in (3,) if options.quick else (3, 5):
            listed.append(
                Case(
                    f"column 1/{cells}: {variant}",
                    "studies.operators.cases:column",
                    arguments | {"cells": cells},
                    cost=2.0 * (cells / 3) ** 4,
                )
            )
    return listed


def tables(rows: list[Row]) -> Tables:
    """``table``: a row per variant; ``errors``, ``orders`` and ``column`` the figures behind it."""
    cube = pd.DataFrame(
        [row for row in rows if row["scene"] == "cube"],
        columns=["scene", "variant", "family", "component", "h", "error", "wall_s"],
    )
    column = pd.DataFrame(
        [row for row in rows if row["scene"] == "column"],
        columns=["scene", "variant", "cells", "twist", "energy", "pressure_1", "pressure_99",
                 "wall_s"],
    )  # fmt: skip
    orders = order_table(cube, by=["variant", "family", "component"])
    return {
        "table": _table(cube, orders, column), "errors": cube, "orders": orders, "column": column,
    }  # fmt: skip


def _table(cube: pd.DataFrame, orders: pd.DataFrame, column: pd.DataFrame) -> pd.DataFrame:
    names = [
        "variant", "slope_p", "slope_P", "p_x_17", "P_xx_17", "twist_4x19x4", "energy_4x19x4",
        "twist_6x31x6", "energy_6x31x6", "pressure_99_6x31x6",
    ]  # fmt: skip
    rows = []
    for variant in VARIANTS:
        mine = orders[orders["variant"] == variant]
        at_17 = cube[
            (cube["variant"] == variant) & (cube["h"] == 1 / 16) & (cube["family"] == "A+B+C=0")
        ].set_index("component")["error"]
        if len(mine) == 0:
            continue
        momentum = mine["component"].str.startswith("p_")
        row: dict[str, Any] = {
            "variant": variant,
            "slope_p": mine[momentum]["order_last"].min(),
            "slope_P": mine[~momentum]["order_last"].min(),
            "p_x_17": at_17.get("p_x"),
            "P_xx_17": at_17.get("P_xx"),
        }
        for cells, lattice in ((3, "4x19x4"), (5, "6x31x6")):
            run = column[(column["variant"] == variant) & (column["cells"] == cells)]
            if len(run):
                row[f"twist_{lattice}"] = run["twist"].iloc[0]
                row[f"energy_{lattice}"] = run["energy"].iloc[0]
                row[f"pressure_99_{lattice}"] = run["pressure_99"].iloc[0]
        rows.append(row)
    return pd.DataFrame(rows, columns=names)


def warm_up(options: argparse.Namespace) -> list[Case]:
    """One tiny run of each scene."""
    arguments = {"variant": "default"} | DEFAULT
    return [
        Case("cube", "studies.operators.cases:cube",
             arguments | {"family": "A=B=C", "cells": 2}),
    ]  # fmt: skip


def report(results: Results) -> Document:
    """A document of one table and what it says."""
    return Document(
        title="Variants of the consistent operator",
        subtitle=subtitle(results.run),
        abstract=(
            "The consistent operator is the least change of the corrected gradient that satisfies "
            "the divergence theorem. Least in which weights, from which smoothing function, used "
            "where, and from which initial strain, are choices. Each is changed alone."
        ),
        sections=[
            Section(
                "Variants",
                [
                    Paragraph(
                        "Slopes: the worst component of the last refinement over both families of "
                        "the swinging cube (linear limit, {p,F} SUPG-SPH-H1). Errors at 17^3 in "
                        "family A+B+C=0. Column: {p,F,J} SUPG-SPH-H1, tau_p = 0.1 dt, nu = 0.495, "
                        "at 0.1 s; energy is the share of the initial energy still there (above "
                        "one: energy was made), a dash a run that failed. The default is the first "
                        "row; column runs start undeformed, so their initial strain is compatible "
                        "in every row."
                    ),
                    Table(
                        "One choice changed at a time.",
                        results.tables["table"],
                        formats={
                            "slope_p": ".2f", "slope_P": ".2f", "p_x_17": ".2e", "P_xx_17": ".2e",
                            "twist_4x19x4": ".3f", "energy_4x19x4": ".3f",
                            "twist_6x31x6": ".3f", "energy_6x31x6": ".3f",
                            "pressure_99_6x31x6": ".2e",
                        },
                        headings={
                            "slope_p": "slope p", "slope_P": "slope P",
                            "p_x_17": "p_x 17^3", "P_xx_17": "P_xx 17^3",
                            "twist_4x19x4": "twist [rad] 4x19x4", "energy_4x19x4": "E/E0 4x19x4",
                            "twist_6x31x6": "twist [rad] 6x31x6", "energy_6x31x6": "E/E0 6x31x6",
                            "pressure_99_6x31x6": "p 99 % [Pa] 6x31x6",
                        },
                    ),
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


STUDY = Study(
    name="operators",
    cases=cases,
    tables=tables,
    report=report,
    warm_up=warm_up,
    description="Variants of the consistent operator, one choice changed at a time.",
)
