"""What it takes to set up a cloud: ``python -m studies.set_up [--cells 16 32 64]``.

Disordered cubes (every particle moved by at most a fifth of the spacing): each operator solved
anew, nothing read from the disk, and once more from the disk.  One case runs at a time, since the
table is of times.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd

from sphsolid import Consistent, SummationByParts, WendlandC2
from sphsolid.cloud import Cloud, OperatorKind, build_cloud, consistency_report, operator_cache
from sphsolid.defaults import default_h_over_dx
from sphsolid.errors import require
from sphsolid.geometry import Box
from studies.engine.study import Case, Row, Study, Tables, run_study

#: Box(jitter=j) moves by at most j/2 of the spacing a component.
JITTER = 0.4
OPERATORS = {each.name: each for each in (Consistent(), SummationByParts())}
LEAST, CELLS, QUICK = 4, (16, 32, 64), (8, 16)
COLUMNS = ["operator", "cells", "particles", "neighbours", "iterations", "change", "C0", "C1",
           "D0", "SBP", "seconds", "seconds_again"]  # fmt: skip


def cases(options: argparse.Namespace) -> list[Case]:
    """Every operator at every size."""
    sizes = sorted(options.cells or (QUICK if options.quick else CELLS))
    require(sizes[0] >= LEAST, f"--cells {sizes[0]}: give at least {LEAST}")
    return [
        Case(f"{name} 1/{cells}", set_up, {"operator": OPERATORS[name], "cells": cells}, cells**3)
        for name in options.operators for cells in sizes
    ]  # fmt: skip


def built(cells: int, operator: OperatorKind) -> tuple[Cloud, float]:
    """A cloud and the seconds it took, mesh excluded."""
    mesh = Box(jitter=JITTER, seed=1).mesh(1.0 / cells)
    started = time.perf_counter()
    h_over_dx = default_h_over_dx(mesh, operator)
    cloud = build_cloud(mesh, smoothing=WendlandC2(), h_over_dx=h_over_dx, operator=operator)
    return cloud, time.perf_counter() - started


def set_up(*, operator: OperatorKind, cells: int) -> list[Row]:
    """One row: solved, then read back."""
    built(6, operator)  # Compiles, so that what is timed does not.
    with (
        tempfile.TemporaryDirectory() as folder,
        mock.patch.object(operator_cache, "cache_base", return_value=Path(folder)),
    ):
        cloud, solved = built(cells, operator)
        _, read = built(cells, operator)
    report = consistency_report(cloud, 1.0)
    values = (
        operator.name, cells, cloud.size, cloud.mean_neighbours, cloud.iterations,
        cloud.change, report.C0, report.C1, report.D0, report.SBP, solved, read,
    )  # fmt: skip
    return [dict(zip(COLUMNS, values, strict=True))]


def tables(rows: list[Row]) -> Tables:
    """``growth``: exponent of the time in the number of particles, from the size before."""
    table = pd.DataFrame(rows, columns=COLUMNS)
    size, seconds = (
        np.log(table[name]).groupby(table["operator"]).diff() for name in ("particles", "seconds")
    )
    return {"table": table.assign(growth=seconds / size)}


def words(tables: Tables) -> Mapping[str, Any]:
    """How far particles are moved, and from how many on an operator is kept."""
    return {"moved": JITTER / 2.0, "kept": operator_cache.LEAST_PARTICLES}


def arguments(parser: argparse.ArgumentParser) -> None:
    """``--cells``, ``--operators``; one case at a time unless ``--jobs`` says otherwise."""
    parser.add_argument("--cells", type=int, nargs="+")
    parser.add_argument("--operators", nargs="+", choices=OPERATORS, default=list(OPERATORS))
    parser.set_defaults(jobs=1)


STUDY = Study(
    name="set_up", cases=cases, tables=tables, words=words, arguments=arguments,
    text=Path(__file__).with_suffix(".md"), warm_up=lambda options: [],
    description="Times and residuals of the set-up of disordered cubes.",
)  # fmt: skip

if __name__ == "__main__":
    run_study(STUDY)
