"""Is the method robust?  The twisting column of [Lee2017] section 8.3 with every method.

``python -m studies.twisting_column`` runs the column at nu = 0.495 and 105 rad/s to 0.1 s with the
paper's SUPG-SPH (H1 and H6), the package's defaults with {p,F,J} and {p,F}, the equations as
printed, the force alone consistent, displacement-based SPH and the B-bar finite element, on the
paper's lattices 4x19x4, 5x25x5 and 6x31x6 and on 11x61x11, H1, the defaults and the elements on
more, so that their twist has a limit; smaller steps for the energy ledger; nu = 0.499 too.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.twisting_column.compare import differences
from studies.twisting_column.methods import (
    DISPLACEMENT,
    FEM,
    H1,
    H6,
    KEPT,
    LITERAL,
    METHODS,
    NO_TAU_P,
    NU,
    PAPER_LATTICES,
    TOOLKIT,
    ULTRA_FINE,
    settings,
    usual_cfl,
)
from studies.twisting_column.report import report
from studies.twisting_column.summary import COLUMNS, RUN, quoted, summarise

#: Beside the paper's lattices and the ultra-fine one, so that a limit can be found.
ALSO = (6, 8, 12)
FINEST_FEM = 16
END = 0.1
#: Time [s] after the end over which pressures are averaged.
AVERAGE = 0.01
FRAMES = (0.0, 0.02, 0.04, 0.06, 0.08, 0.1)
MAIN = (H1, H6, TOOLKIT)
IN_SEQUENCE = (H1, TOOLKIT, FEM)
_ALSO_FINE = (*MAIN, NO_TAU_P, LITERAL, FEM)
_SHORT_FORM = (*MAIN, NO_TAU_P, LITERAL, DISPLACEMENT, FEM)


def _case(
    label: str,
    cells: int,
    shots: str,
    *,
    cfl: float | None = None,
    nu: float = NU,
    kept: bool = False,
) -> Case:
    """``kept``: the intrinsic times stay what they are at the usual step, in seconds."""
    usual = usual_cfl(label)
    chosen = usual if cfl is None else cfl
    method = settings(label, nu)
    if kept:
        shares = ("tau_F", "tau_p") if method["tau_unit"] == "dt" else ("tau_p",)
        method |= {name: method[name] * usual / chosen for name in shares}
    name = label + KEPT if kept else label
    words = [name, f"1/{cells}"]
    words += [f"CFL {chosen:g}"] if chosen != usual else []
    words += [f"nu {nu:g}"] if nu != NU else []
    pictured = chosen == usual and nu == NU
    frames = list(FRAMES) if label == H1 else [END]
    cost = cells**4 * {"H1": 1.0, "H6": 2.4, "-": 0.7}[str(method["secondary"])] * usual / chosen
    cost *= (0.01 / (1.0 - 2.0 * nu)) ** 0.5 * (0.5 if label == FEM else 1.0)
    return Case(
        " ".join(words),
        "studies.twisting_column.cases:run_case",
        method
        | {
            "label": name, "cells": cells, "cfl": chosen, "nu": nu, "until": END,
            "frames": frames if pictured else [], "shots": shots,
            "average": AVERAGE if chosen == usual else 0.0,
        },
        cost=cost,
    )  # fmt: skip


def _held(label: str) -> tuple[bool, ...]:
    """The paper's intrinsic times are those of the step, the package's ``tau_F`` of the mesh."""
    return (True,) if label in (TOOLKIT, NO_TAU_P) else (False, True)


def _full(shots: str) -> Iterator[Case]:
    for label in METHODS:
        for cells in PAPER_LATTICES:
            yield _case(label, cells, shots)
        if label in _ALSO_FINE:
            yield _case(label, ULTRA_FINE, shots)
    for label in IN_SEQUENCE:
        for cells in ALSO:
            yield _case(label, cells, shots)
    yield _case(FEM, FINEST_FEM, shots)
    for label in (*MAIN, NO_TAU_P):
        for share in (0.5, 0.25):
            for kept in _held(label):
                yield _case(label, 3, shots, cfl=share * usual_cfl(label), kept=kept)
    for label in (H1, TOOLKIT):
        for kept in _held(label):
            yield _case(label, 5, shots, cfl=0.5 * usual_cfl(label), kept=kept)
    for label, cells in ((H1, 5), (TOOLKIT, 5), (FEM, 5), (FEM, 12)):
        yield _case(label, cells, shots, nu=0.499)


def _quick(shots: str) -> Iterator[Case]:
    for label in _SHORT_FORM:
        yield _case(label, 3, shots)
    for label in IN_SEQUENCE:
        for cells in (*PAPER_LATTICES[1:], ALSO[0]):
            yield _case(label, cells, shots)
    for kept in (False, True):
        yield _case(H1, 3, shots, cfl=0.5 * usual_cfl(H1), kept=kept)


def cases(options: argparse.Namespace) -> list[Case]:
    """Every run of the study, and the timing of a step."""
    shots = (options.out / "shots").as_posix()
    listed = list((_quick if options.quick else _full)(shots))
    timing = {"cells": 5, "steps": 20, "rounds": 3 if options.quick else 15}
    listed.append(
        Case("cost of a step", "studies.twisting_column.cases:cost_case", timing, cost=500.0)
    )
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    tiny = []
    for label in METHODS:
        case = _case(label, 2, "")
        short = {"until": 2e-4, "frames": [], "average": 0.0}
        tiny.append(Case(case.key, case.run, dict(case.arguments) | short, 1.0))
    return tiny


def tables(rows: list[Row]) -> Tables:
    """``table`` a row a run; ``history`` a row a record; ``layers``, ``differences``, ``cost``."""

    def of(kind: str) -> list[Row]:
        return [
            {name: value for name, value in row.items() if name != "kind"}
            for row in rows
            if row["kind"] == kind
        ]

    runs, history = of("run"), pd.DataFrame(of("instant"))
    apart = pd.DataFrame(differences(runs), columns=None if runs else RUN)
    table = summarise(runs, history, apart) if runs else pd.DataFrame(columns=COLUMNS)
    return {
        "table": table,
        "history": history,
        "layers": pd.DataFrame(of("layer")),
        "differences": apart,
        "cost": pd.DataFrame(of("cost")),
    }


def summary(tables: Tables) -> str:
    """The table printed at the end, and the figures that README quotes."""
    shown = [
        "label", "cells", "cfl", "nu", "steps", "survived", "folded", "twist_100", "height_100",
        "energy_kept", "rest_largest", "noise_free_mean", "cpu_s",
    ]  # fmt: skip
    frame = tables["table"].reindex(columns=shown)
    listed = frame.to_string(index=False, float_format=lambda value: f"{value:.4g}")
    return f"{listed}\n\n{quoted(tables)}"


STUDY = Study(
    name="twisting_column",
    cases=cases,
    tables=tables,
    report=report,
    summary=summary,
    warm_up=warm_up,
    description="The twisting column with SUPG-SPH, displacement SPH and B-bar FEM.",
)
