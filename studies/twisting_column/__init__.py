"""Is the method robust?  The twisting column of [Lee2017] section 8.3 with every method.

``python -m studies.twisting_column`` runs the column at nu = 0.495 and 105 rad/s to 0.1 s with the
paper's SUPG-SPH (H1 and H6), the package default, self-adjoint SUPG and variants of it, the
equations as printed, the force alone consistent, displacement-based SPH and the B-bar finite
element, on the paper's lattices 4x19x4, 5x25x5 and 6x31x6 and on 11x61x11; H1, the default, SUPG
and the elements on more, so that their twist has a limit; with smaller steps for the energy budget;
and at nu = 0.499.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

import sphsolid as sph
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.defaults import default_supg
from sphsolid.errors import require
from sphsolid.recommendation import recommend_supg
from sphsolid.scenes import twisting_column
from studies.engine.study import Case, Row, Study, Tables
from studies.measures.tables import select
from studies.methods import Method, said
from studies.pictures.picture import keeping
from studies.twisting_column import claims as judged
from studies.twisting_column import outside
from studies.twisting_column.claims import quoted
from studies.twisting_column.compare import CLAMP, SHARES, differences
from studies.twisting_column.figures import FIGURES, INDEPENDENT_PRESSURE, PICTURES
from studies.twisting_column.methods import (
    CLASSICAL,
    DEFAULT,
    FEM,
    H1,
    H6,
    LITERAL,
    METHODS,
    NO_TAU_P,
    PAIRS,
    PAPER_LATTICES,
    PLAIN,
    RK3,
    SHOWN,
    ULTRA_FINE,
    in_seconds,
    usual,
)
from studies.twisting_column.runs import (
    AVERAGE,
    END,
    EVERY,
    NU,
    Column,
    cost_of_a_step,
    lattice,
    run_column,
    usual_cfl,
)

#: Beside the paper's lattices and the ultra-fine one, so that a limit can be found.
ALSO, FINEST_FEM, STIFFER = (6, 8, 12), 16, 0.499
IN_SEQUENCE = (H1, DEFAULT, PLAIN, FEM)
FRAMES = (0.0, 0.02, 0.04, 0.06, 0.08, END)
#: What tells runs apart.
RUN = ["method", "cells", "cfl", "nu", "kept"]


def pictured(method: Method, cells: int, **more: Any) -> Column:
    """A run at the usual step whose surface is kept."""
    return Column(method, cells, frames=FRAMES if method == H1 else (END,), **more)


def _smaller_steps(method: Method, cells: int, shares: Sequence[float]) -> Iterator[Column]:
    """The paper's intrinsic times are those of the step; self-adjoint SUPG has ``tau_F`` of the
    mesh, and the default none.
    """
    for share in shares:
        if method in (H1, H6):
            yield Column(method, cells, share)
        yield Column(in_seconds(method, 1.0 / share), cells, share, kept=True)


def columns(quick: bool) -> Iterator[Column]:
    """Every run of the study, or those of the short form."""
    if quick:
        for method in (H1, H6, DEFAULT, PLAIN, NO_TAU_P, LITERAL, CLASSICAL, FEM):
            yield pictured(method, PAPER_LATTICES[0])
        for method in IN_SEQUENCE:
            for cells in (*PAPER_LATTICES[1:], ALSO[0]):
                yield pictured(method, cells)
        yield from _smaller_steps(H1, 3, (0.5,))
        return
    for method in METHODS:
        for cells in PAPER_LATTICES:
            yield pictured(method, cells)
    for method in (H1, H6, DEFAULT, PLAIN, NO_TAU_P, LITERAL, FEM):
        yield pictured(method, ULTRA_FINE)
    for method in IN_SEQUENCE:
        for cells in ALSO:
            yield pictured(method, cells)
    yield pictured(FEM, FINEST_FEM)
    for method in (H1, H6, DEFAULT, PLAIN, NO_TAU_P):
        yield from _smaller_steps(method, 3, (0.5, 0.25))
    for method in (H1, DEFAULT, PLAIN):
        yield from _smaller_steps(method, 5, (0.5,))
    for method, cells in ((H1, 5), (DEFAULT, 5), (PLAIN, 5), (FEM, 5), (FEM, 12)):
        yield Column(method, cells, nu=STIFFER)


def case_of(column: Column, out: Path) -> Case:
    """The case of a run; its cost is a guess in parts of that of the finest."""
    weight = 2.4 if "H6" in column.method.name else 0.35 if column.method in (FEM, DEFAULT) else 1.0
    cost = column.cells**4 * weight / column.share * (0.01 / (1.0 - 2.0 * column.nu)) ** 0.5
    given = {"column": column, "shots": (out / "shots").as_posix()}
    return Case(column.key, run_column, given, cost)


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Every run of the study, and the timing of a step."""
    listed = [case_of(column, options.out) for column in columns(options.quick)]
    timed = (("none", H1.but(stabilisation=sph.NoStabilisation())), ("H1", H1), ("H6", H6))
    timing = {"methods": timed, "cells": 5, "steps": 20, "rounds": 3 if options.quick else 15}
    return [*listed, Case("cost of a step", cost_of_a_step, timing, 500.0)]


def tiny(options: argparse.Namespace) -> Sequence[Case]:
    """Runs that compile every kernel of the study."""
    return [case_of(Column(one, 2, until=2e-4, average=0.0), options.out) for one in METHODS]


def tables(rows: list[Row]) -> Tables:
    """``table`` a row a run; ``history`` a row a record; ``layers``, ``differences``, ``cost``."""

    def of(kind: str) -> list[Row]:
        own = [row for row in rows if row["of"] == kind]
        return [{name: value for name, value in row.items() if name != "of"} for row in own]

    runs = of("table")
    require(len(runs) > 0, "studies.twisting_column: no run finished")
    apart = pd.DataFrame(differences(runs, reference=FEM.name, pairs=PAIRS))
    grids = ["grid_x", "grid_pressure", "grid_mean"]
    table = pd.DataFrame(runs).drop(columns=grids, errors="ignore")
    means = {f"other_mean_{share} [Pa]": f"reference_mean_{share}" for share in SHARES}
    named = {"position_rms [m]": "position_rms"} | means
    known = apart[apart["other"] == FEM.name] if len(apart) else pd.DataFrame(columns=[*RUN])
    known = known.rename(columns=named)
    kept = [*RUN, "position_rms", "pressure_rms", "mean_rms", *means.values()]
    return {
        "table": table.merge(known.reindex(columns=kept), how="left", on=RUN),
        "history": pd.DataFrame(of("history")),
        "layers": pd.DataFrame(of("layers")),
        "differences": apart,
        "cost": pd.DataFrame(of("cost")),
    }


def words(tables: Tables) -> Mapping[str, Any]:
    """Constants, thresholds, and the parts of the tables that are printed."""
    table = tables["table"]
    table = table.assign(lattice=[lattice(int(cells)) for cells in table["cells"]])
    scene, runs = twisting_column(poisson_ratio=NU), usual(table)
    chosen = default_supg(recommend_supg(scene).formulation, scene.material)
    stepped = table[table["method"].isin(table[table["kept"].astype(bool)]["method"])]
    stepped = stepped[(stepped["nu"] == NU) & stepped["cells"].isin([3, 5])]
    pressures = {
        f"{name} {share} %": 1e-6 * runs[f"pressure_{kind}{share}"]
        for name, kind in (("points", ""), ("free", "free_"), ("mean", "mean_"))
        for share in (1, 99)
    }
    plain = select(table, method=PLAIN.name, cells=5)
    return {
        "runs": runs, "judged": judged, "outside": outside, "lattice": lattice, "chosen": chosen,
        "tau_F": said(chosen.tau_F), "tau_p": said(chosen.tau_p), "nu": NU, "stiffer": STIFFER,
        "package_cfl": usual_cfl(PLAIN), "three_cfl": usual_cfl(RK3),
        "support": 2.0 * table["h_over_dx"].dropna().iloc[0], "clamp": CLAMP,
        "records": round(END / EVERY), "average": AVERAGE, "every": EVERY,
        "steps_5": usual(plain)["steps"].tolist(),
        "independent": [1e-6 * value for value in INDEPENDENT_PRESSURE],
        "sequences": outside.sequence_frame(runs, [method.name for method in SHOWN]),
        "stepped": stepped.sort_values(["cells", "method", "cfl"], ascending=[True, True, False]),
        "pressures": runs.assign(**pressures, ringing_MPa=1e-6 * runs["ringing"]),
        "pressure_names": list(pressures), "nearer": select(table, nu=STIFFER),
        "clamped": runs.assign(
            largest=1e-6 * runs["reaction_y_largest"], end=1e-6 * runs["reaction_y_end"],
            torque=1e-6 * runs["torque_largest"],
        ),
        "planes": 6 * PAPER_LATTICES[-1] + 1,
        "crossing": 1.0e3 / reference_p_wave_speed(scene.material),
    }  # fmt: skip


STUDY = Study(
    name="twisting_column",
    cases=cases,
    tables=tables,
    claims=judged.claims,
    figures=FIGURES,
    keep=keeping(list(PICTURES.values())),
    words=words,
    text=Path(__file__).with_name("report.md"),
    summary=quoted,
    warm_up=tiny,
    description="The twisting column with SUPG-SPH, the package default, displacement SPH and "
    "B-bar FEM.",
)
