"""The punch on points without a mesh: ``python -m studies.punch_cloud``.

The same block, once as disordered hexahedra with H1 and once as nothing but their vertices and a
surface, with secondary particles from agglomerated Delaunay cells; {p,F,J}, defaults, nu = 0.499,
the same smoothing length on both.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.results import Tables
from studies.punch_cloud.bodies import HEXAHEDRA, WIDEST
from studies.punch_cloud.cases import DEFAULT, NO_TAU_P, NONE, TETRAHEDRA
from studies.punch_cloud.report import report
from studies.punch_cloud.verdicts import verdicts
from studies.report import folding

#: Seeds of the disorder.
SEEDS = (1, 2, 3)
#: Clouds and stabilisations; the first two of ``points`` are compared with ``hexahedra``.
RUNS = (
    ("lattice", DEFAULT),
    (HEXAHEDRA, DEFAULT),
    (WIDEST, DEFAULT),
    ("points", DEFAULT),
    ("filled", DEFAULT),
    ("points", TETRAHEDRA),
    (HEXAHEDRA, NO_TAU_P),
    ("points", NO_TAU_P),
    (HEXAHEDRA, NONE),
    ("points", NONE),
)
_RUN = [
    "key", "cloud", "stabilisation", "cells", "seed", "method", "particles", "secondary", "noise",
    "noise_in_rows", "p_low", "p_high", "top_low", "top_high", "missed_momentum", "survived",
    "lost_at", "reason", *folding.COLUMNS, "steps", "setup_s", "wall_s",
]  # fmt: skip


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Both lattices of the paper and three seeds; the quick form has the smaller and one seed.

    On the larger one the runs for contrast have one seed too.
    """
    listed = []
    for cells in (20,) if options.quick else (20, 40):
        for cloud, stabilisation in RUNS:
            once = options.quick or cloud == "lattice" or (cells > 20 and stabilisation != DEFAULT)
            for seed in SEEDS[:1] if once else SEEDS:
                listed.append(_case(options, cloud, stabilisation, cells, seed, 0.015))
    return listed


def _case(
    options: argparse.Namespace,
    cloud: str,
    stabilisation: str,
    cells: int,
    seed: int,
    until: float,
) -> Case:
    key = f"{cloud}-{stabilisation}-{cells}-seed{seed}".replace(", ", "_").replace(" ", "_")
    arguments = {
        "key": key, "cloud": cloud, "stabilisation": stabilisation, "cells": cells, "seed": seed,
        "until": until, "shots": str(options.out / "shots"),
    }  # fmt: skip
    return Case(key, "studies.punch_cloud.cases:run_case", arguments, cost=(cells / 20.0) ** 4)


def warm_up(options: argparse.Namespace) -> Sequence[Case]:
    """Half a millisecond of each, which compiles every kernel."""
    made = []
    for cloud, stabilisation in RUNS:
        case = _case(options, cloud, stabilisation, 20, SEEDS[0], 5.0e-4)
        kept_out = {"shots": str(options.out / "partial")}
        made.append(Case(case.key, case.run, dict(case.arguments) | kept_out, cost=1.0))
    return made


def tables(rows: list[Row]) -> Tables:
    """``table``: a mean over the seeds for each cloud; ``runs``: every run; ``history``."""
    runs = pd.DataFrame([row for row in rows if row["kind"] == "run"]).reindex(columns=_RUN)
    history = pd.DataFrame(
        [row for row in rows if row["kind"] == "instant"]
    ).reindex(columns=["key", "cloud", "stabilisation", "cells", "seed", "time", "noise"])
    runs["against_H1"] = np.nan
    for index, run in runs.iterrows():
        same = runs["stabilisation"] == run["stabilisation"]
        if run["stabilisation"] == TETRAHEDRA:
            same = runs["stabilisation"] == DEFAULT
        h1 = runs[
            same & (runs["cloud"] == HEXAHEDRA) & (runs["cells"] == run["cells"])
            & (runs["seed"] == run["seed"])
        ]  # fmt: skip
        if len(h1) == 1 and run["cloud"] in ("points", "filled"):
            runs.loc[index, "against_H1"] = run["noise"] / h1["noise"].iloc[0] - 1.0
    grouped = runs.groupby(["cells", "cloud", "stabilisation"], sort=False)
    table = grouped.agg(
        method=("method", "first"),
        particles=("particles", "mean"),
        secondary=("secondary", "mean"),
        seeds=("seed", "count"),
        survived=("survived", "sum"),
        folded=("folded", "sum"),
        noise=("noise", "mean"),
        noise_in_rows=("noise_in_rows", "mean"),
        against_H1=("against_H1", "mean"),
        against_H1_low=("against_H1", "min"),
        against_H1_high=("against_H1", "max"),
        p_low=("p_low", "mean"),
        p_high=("p_high", "mean"),
        top_low=("top_low", "mean"),
        top_high=("top_high", "mean"),
        missed_momentum=("missed_momentum", "max"),
        setup_s=("setup_s", "mean"),
        wall_s=("wall_s", "mean"),
    ).reset_index()
    return {"table": table, "runs": runs, "history": history}


STUDY = Study(
    name="punch_cloud",
    cases=cases,
    tables=tables,
    report=report,
    summary=lambda found: verdicts(found).to_string(index=False),
    warm_up=warm_up,
    description="The punch on points without a mesh against H1 on the same points.",
)
