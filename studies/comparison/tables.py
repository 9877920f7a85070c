"""The tables: equal particles, equal error, hard cases, and what they are made from."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from studies.comparison.contenders import BY_NAME, ELEMENTS, PAPERS_ORDER
from studies.comparison.cost import step_seconds
from studies.comparison.runs import column_case, punch_case
from studies.engine.case import Row
from studies.engine.results import Tables
from studies.measures import folding
from studies.measures.order import last_order
from studies.measures.tables import select
from studies.pareto.iso_error import envelope, iso_error
from studies.stability.judgement import SOUND, judge
from studies.twisting_column.outside import twist_error

#: The column of the paper: angular velocity [rad/s] and Poisson's ratio.
OMEGA, NU = 105.0, 0.495
#: Lattices [cells a metre] on which methods are compared at equal particles: on that of the column
#: quadratic elements have as many nodes as the others.
CUBE_AT, COLUMN_AT, PUNCH_AT = 8, 4, 20
#: Cells a metre of the B-bar elements against which the top of the punch is judged.
PUNCH_FINE = 40
RUN = [
    "case", "scene", "method", "cells", "particles", "applicable", "survived", "diverged_at",
    "where", "why", *folding.COLUMNS, "steps", "end_time", "energy_kept", "energy_gain", "J_min",
    "J_max", "unseen_rms", "inside_out", "noise", "noise_end", "pressure_1", "pressure_99",
    "answer", "answer_is", "omega", "nu", "height", "twist_20", "twist_40", "twist_60", "twist_80",
    "twist_100", "low", "high", "wall_s", "cpu_s",
]  # fmt: skip
CUBE = [
    "method", "scene", "cells", "particles", "steps", "survived", *folding.COLUMNS, "momentum",
    "stress",
]  # fmt: skip
COST = ["method", "cells", "particles", "step_s", "window_steps", "repeats"]
SPIN = ["method", "survived", *folding.COLUMNS, "linear_drift", "angular_drift"]
#: Errors at which particles and costs are compared: scene, column of the errors, error.
EQUAL = (
    ("cube", "momentum", 0.01), ("cube", "stress", 0.03), ("column", "twist_error", 0.03),
)  # fmt: skip
MEASURES = {
    "cube_p": "cube momentum", "cube_P": "cube stress", "twist_error": "column twist",
    "top_error": "punch top",
}  # fmt: skip


#: Which of them a run whose positions folded has no right to.
FOLDED = {"twist_error": "column_folded", "top_error": "punch_folded"}


def tables(rows: list[Row]) -> Tables:
    """``table``: a row a method at equal particles; the others as their names say."""
    cube, cost = _of(rows, "cube", CUBE), _of(rows, "cost", COST)
    runs = judged(with_errors(_of(rows, "run", RUN)))
    cube["seconds"] = _seconds(cube, cost)
    runs["seconds"] = _seconds(runs, cost)
    table = equal_particles(cube, runs, cost)
    return {
        "table": table, "cube": cube, "runs": runs, "cost": cost, "spin": _of(rows, "spin", SPIN),
        "equal_error": equal_error(cube, runs), "merit": merit(table), "orders": orders(cube),
        "history": _of(rows, "instant", ["case", "method", "time"]),
    }  # fmt: skip


def _of(rows: Sequence[Row], kind: str, columns: Sequence[str]) -> pd.DataFrame:
    """Rows of one kind, with ``columns`` first whether or not any row has them."""
    found = pd.DataFrame([row for row in rows if row["kind"] == kind])
    others = [] if kind != "instant" else [n for n in found if n not in (*columns, "kind")]
    return found.reindex(columns=[*columns, *others])


def _seconds(runs: pd.DataFrame, cost: pd.DataFrame) -> list[float]:
    """Steps times what a step costs in the common timing [s]."""
    return [
        float(row["steps"] * step_seconds(cost, row["method"], row["particles"]))
        for row in runs.to_dict("records")
    ]


def with_errors(runs: pd.DataFrame) -> pd.DataFrame:
    """``twist_error``: of the paper's column, the largest at 20, 40, .. 100 ms against CalculiX.

    ``top_error`` [m]: of the punch, how far the lowest or the highest point of the top is at 15 ms
    from that of the finest B-bar elements.  Both are nan where there is nothing to compare.
    """
    papers = (runs["omega"] == OMEGA) & (runs["nu"] == NU)
    twist = [
        twist_error(row) if own else math.nan
        for own, (_, row) in zip(papers, runs.iterrows(), strict=True)
    ]
    finest = select(runs, scene="punch", method=ELEMENTS.name).sort_values("cells").tail(1)
    finest = finest[finest["cells"] > PUNCH_AT]
    off = pd.Series(math.nan, runs.index)
    for end in ("low", "high") if len(finest) else ():
        off = np.fmax(off, (runs[end].astype(float) - float(finest[end].iloc[0])).abs())
    of_itself = runs.index.isin(finest.index)
    return runs.assign(twist_error=twist, top_error=off.where(~of_itself))


def judged(runs: pd.DataFrame) -> pd.DataFrame:
    """With ``verdict`` and, in ``why``, its reason; B-bar on the same lattice has the answer."""
    own = select(runs, method=ELEMENTS.name, survived=True)
    right = dict(zip(own["case"], own["answer"], strict=True))
    found = [
        judge({"clumping": 0.0} | row, right.get(row["case"], math.nan))
        for row in runs.to_dict("records")
    ]
    return runs.assign(
        verdict=[verdict for verdict, _ in found], why=[why for _, why in found]
    )


def equal_particles(
    cube: pd.DataFrame, runs: pd.DataFrame, cost: pd.DataFrame
) -> pd.DataFrame:
    """One row a method on the lattices where everybody was run."""
    rows = []
    column, press = column_case(OMEGA, NU, COLUMN_AT), punch_case(PUNCH_AT)
    for name in BY_NAME:
        large = select(cube, method=name, scene="manufactured", cells=CUBE_AT)
        linear = select(cube, method=name, scene="linear", cells=CUBE_AT)
        twisted, pressed = (select(runs, method=name, case=case) for case in (column, press))
        if not (len(large) or len(twisted) or len(pressed)):
            continue
        timed = select(cost, method=name).sort_values("particles").tail(1)
        lost = 1.0 - twisted["energy_kept"]
        rows.append({
            "method": name, "cube_p": _one(large["momentum"]), "cube_P": _one(large["stress"]),
            "cube_p_linear": _one(linear["momentum"]), "cube_P_linear": _one(linear["stress"]),
            "twist_error": _one(twisted["twist_error"]), "energy_lost": _one(lost),
            "noise": _one(twisted["noise"]), "inside_out": _one(twisted["inside_out"]),
            "column": _word(twisted["verdict"]), "column_s": _one(twisted["seconds"]),
            "top_error": _one(pressed["top_error"]), "punch_noise": _one(pressed["noise"]),
            "punch_lost": _one(1.0 - pressed["energy_kept"]),
            "punch_inside_out": _one(pressed["inside_out"]), "punch": _word(pressed["verdict"]),
            "column_folded": bool(folding.has_folded(twisted).any()),
            "punch_folded": bool(folding.has_folded(pressed).any()),
            "sound": _counted(select(runs, method=name)["verdict"] == SOUND),
            "ns_particle": 1.0e9 * _one(timed["step_s"] / timed["particles"]),
        })  # fmt: skip
    return pd.DataFrame(rows, columns=None if rows else ["method", *MEASURES])


def _one(values: pd.Series) -> float:
    return float(values.iloc[0]) if len(values) else math.nan


def _counted(hold: pd.Series[bool]) -> str:
    return f"{int(hold.sum())} of {len(hold)}"


def _word(values: pd.Series) -> str:
    return str(values.iloc[0]) if len(values) else "not run"


def equal_error(cube: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Particles and seconds at which each method has an error, between its lattices.

    ``how``: interpolated, or where it was not; a lattice counts with the largest error of it and
    of all finer ones.  Runs that diverged or folded have no error.
    """
    rows = []
    large = select(cube, scene="manufactured").assign(scene="cube")
    twisted = papers_column(runs)
    for scene, measure, asked in EQUAL:
        table = large if scene == "cube" else twisted
        for name in BY_NAME:
            own = select(table, method=name).sort_values("particles")
            if len(own) < 2:
                continue
            error = own[measure].astype(float).where(folding.sound(own))
            costs = {key: own[key].astype(float).tolist() for key in ("particles", "seconds")}
            found = iso_error(error.tolist(), costs, asked)
            best = float(envelope(error.to_numpy(float))[-1])
            rows.append(
                {"scene": scene, "measure": measure, "asked": asked, "method": name,
                 "how": found.how, **found.costs, "finest": best if np.isfinite(best) else math.nan}
            )  # fmt: skip
    columns = ["scene", "measure", "asked", "method", "how", "particles", "seconds", "finest"]
    return pd.DataFrame(rows, columns=columns)


def papers_column(runs: pd.DataFrame) -> pd.DataFrame:
    """The runs of the column of the paper, on every lattice."""
    return select(runs, omega=OMEGA, nu=NU)


def orders(cube: pd.DataFrame) -> pd.DataFrame:
    """The slope of the last refinement of the cube: a row a method.

    Columns ``p_linear, P_linear, p_manufactured, P_manufactured`` and ``cells``, the finest.
    """
    rows = []
    for name in dict.fromkeys(cube["method"]):
        own = select(cube, method=name, survived=True)
        row: Row = {"method": name, "cells": own["cells"].max()}
        for (scene, runs), (letter, word) in itertools.product(
            own.groupby("scene", sort=False), (("p", "momentum"), ("P", "stress"))
        ):
            if len(runs) >= 2:
                row[f"{letter}_{scene}"] = last_order(1.0 / runs["cells"], runs[word])
        if len(row) > 2:
            rows.append(row)
    slopes = [f"{letter}_{scene}" for scene in ("linear", "manufactured") for letter in "pP"]
    return pd.DataFrame(rows, columns=["method", "cells", *slopes])


def merit(table: pd.DataFrame) -> pd.DataFrame:
    """The order of the methods that the paper compares, by each measure, and whether it is its.

    Equal ones of the paper may come in either order; a run that folded comes last.
    """
    rank = {name: number for number, group in enumerate(PAPERS_ORDER) for name in group}
    rows = []
    for column, words in MEASURES.items():
        own = table[table["method"].isin(rank) & table[column].notna()]
        if len(own) < 2:
            continue
        folded = own[FOLDED[column]].astype(bool) if column in FOLDED else own[column] < 0.0
        error = own[column].mask(folded, math.inf).sort_values()
        found = own["method"][error.index].tolist()
        ordered = [rank[name] for name in found]
        listed = [
            f"{name} {f'{value:.2g}' if value < math.inf else '(folded)'}"
            for name, value in zip(found, error, strict=True)
        ]
        rows.append(
            {"measure": words, "found": " < ".join(listed),
             "as_published": ordered == sorted(ordered)}
        )  # fmt: skip
    return pd.DataFrame(rows, columns=["measure", "found", "as_published"])
