"""What it takes to set up a cloud: ``python -m studies.set_up [--cells 16 32 64]``.

Disordered cubes (every particle moved by at most a fifth of the spacing), each operator solved
anew, nothing read from the disk, and once more from the disk.  A table is printed and written to
``reports/set_up/table.csv`` with the run's conditions beside it; growth is the exponent of the
time in the number of particles.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd

import sphsolid as sph
from sphsolid.cloud import Cloud, OperatorKind, build_cloud, consistency_report, operator_cache
from sphsolid.compiled import threads
from sphsolid.defaults import default_h_over_dx
from sphsolid.errors import InputError, require
from sphsolid.geometry import Box
from studies.harness.provenance import describe_run

#: Box(jitter=j) moves by at most j/2 of the spacing a component.
JITTER = 0.4
OPERATORS: dict[str, OperatorKind] = {
    "Consistent": sph.Consistent(),
    "SummationByParts": sph.SummationByParts(),
}


def built(cells: int, operator: OperatorKind) -> tuple[Cloud, float]:
    """A cloud and the seconds it took, mesh excluded."""
    mesh = Box(jitter=JITTER, seed=1).mesh(1.0 / cells)
    started = time.perf_counter()
    h_over_dx = default_h_over_dx(mesh, operator)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=h_over_dx, operator=operator
    )
    return cloud, time.perf_counter() - started


def row(cells: int, operator: OperatorKind) -> dict[str, Any]:
    """One line of the table: solved, then read back."""
    with (
        tempfile.TemporaryDirectory() as folder,
        mock.patch.object(operator_cache, "cache_base", return_value=Path(folder)),
    ):
        cloud, solved = built(cells, operator)
        _, read = built(cells, operator)
    report = consistency_report(cloud, 1.0)
    return {
        "operator": operator.name, "cells": cells, "particles": cloud.size,
        "neighbours": cloud.kinematic.mean_neighbours, "iterations": cloud.iterations,
        "change": cloud.change, "C0": report.C0, "C1": report.C1, "D0": report.D0,
        "SBP": report.SBP, "seconds": solved, "seconds_again": read,
    }  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Print and write the table."""
    parser = argparse.ArgumentParser(prog="python -m studies.set_up", description=__doc__)
    parser.add_argument("--cells", type=int, nargs="+", default=[16, 32, 64])
    parser.add_argument("--operators", nargs="+", choices=OPERATORS, default=list(OPERATORS))
    parser.add_argument("--out", type=Path, default=Path("reports/set_up"))
    options = parser.parse_args(arguments)
    try:
        require(min(options.cells) >= 4, f"--cells {min(options.cells)}: give at least 4")
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    started = time.perf_counter()
    operators = [OPERATORS[name] for name in options.operators]
    for operator in operators:  # Compiles, so that no line below does.
        built(6, operator)
    rows: list[dict[str, Any]] = []
    options.out.mkdir(parents=True, exist_ok=True)
    for operator in operators:
        for cells in sorted(options.cells):
            found = row(cells, operator)
            before = next((r for r in reversed(rows) if r["operator"] == operator.name), None)
            found["growth"] = (
                np.log(found["seconds"] / before["seconds"])
                / np.log(found["particles"] / before["particles"])
                if before
                else np.nan
            )
            rows.append(found)
            table = pd.DataFrame(rows)
            table.to_csv(options.out / "table.csv", index=False)
            print(table.tail(1).to_string(index=False, header=len(rows) == 1), flush=True)
    run = describe_run(
        study="set_up", argv=list(arguments or sys.argv[1:]), mode="full", jobs=1,
        threads=threads(), wall_s=time.perf_counter() - started, cases=len(rows), failed=0,
        resumed=0,
    )  # fmt: skip
    (options.out / "run.json").write_text(json.dumps(run, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
