"""Are momenta and energy kept?  The tumbling L-shaped block and the spinning cube.

``python -m studies.conservation`` runs the second example of [Lee2017] section 8.1 (Figs. 6 to 8:
a free block kicked by two opposite tractions) with {p,F}, {p,F,J} and {p,F,H,J} SUPG-SPH, H1 and
H6, the operator as printed and the consistent one, with and without the angular-momentum
projection, and with B-bar finite elements on the same disordered mesh; and a spinning cube whose
momentum is known, where the energy ledger must close but for the time integrator.
"""

from __future__ import annotations

import argparse

import pandas as pd

from studies.conservation.report import report
from studies.conservation.runs import block_cases, cube_cases, short_form, tiny
from studies.conservation.verdicts import rest_orders, verdicts
from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables

_SETTING = [
    "group", "method", "formulation", "secondary", "operator", "weighting", "projection",
    "integrator", "spacing", "particles", "h_over_dx", "cfl", "tau_F", "tau_unit", "xi_F", "tau_p",
]  # fmt: skip
_OUTCOME = ["steps", "survived", "folded", "folded_at", "outcome", "lost_at", "why", "wall_s"]
COLUMNS = {
    "table": [
        *_SETTING, "jitter", "load", "until", *_OUTCOME, "linear", "linear_step", "angular_free",
        "angular_total", "angular_step", "impulse_gap", "L_x", "L_y", "L_z", "work", "energy_5",
        "energy_kept", "dissipated", "rest", "left_over", "noise", "pressure_1",
        "pressure_99", "J_min", "J_max",
    ],
    "cube": [
        *_SETTING, "spin", "turns", *_OUTCOME, "L_z", "energy_0", "linear_total", "linear_step",
        "angular_total", "angular_step", "rest", "rest_end", "left_over", "energy_kept",
        "dissipated", "projection_work",
    ],
    "history": [
        "key", "time", "L_x", "L_y", "L_z", "p_x", "p_y", "p_z", "linear", "angular", "kinetic",
        "deviatoric", "volumetric", "work", "projection", "dissipation", "rest", "noise",
    ],
    "cube_history": [
        "key", "turn", "kinetic", "strain", "total", "dissipation", "rest", "angular",
    ],
}  # fmt: skip
_KINDS = {
    ("run", "block"): "table", ("run", "cube"): "cube",
    ("history", "block"): "history", ("history", "cube"): "cube_history",
}  # fmt: skip


def cases(options: argparse.Namespace) -> list[Case]:
    """All runs, or a cross of them."""
    if options.quick:
        return list(short_form(options.out))
    return [*block_cases(options.out), *cube_cases()]


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs of both scenes by both solvers."""
    return list(tiny(options.out))


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a run of the block; ``cube``; histories; ``orders``; ``verdicts``."""
    made = {
        name: pd.DataFrame(
            [row for row in rows if _KINDS[row["kind"], row["scene"]] == name], columns=columns
        )
        for name, columns in COLUMNS.items()
    }
    orders = rest_orders(made["cube"])
    return made | {
        "orders": orders, "verdicts": verdicts(made["table"], made["cube"], orders),
    }  # fmt: skip


def summary(tables: Tables) -> str:
    """The verdicts."""
    return tables["verdicts"].drop(columns="where").to_string(index=False)


STUDY = Study(
    name="conservation",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    warm_up=warm_up,
    description="Momenta and energy of the L-shaped block and of the spinning cube.",
)
