"""``studies.speed``: rows, the machine's share, and every verdict on synthetic tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.compiled import set_threads, threads
from studies.harness.results import Results
from studies.report.document import Document
from studies.speed import cases, counting, study
from studies.speed.targets import targets

ROOT = Path(__file__).resolve().parents[3]
OPTIONS: dict[str, Any] = {
    "formulation": "{p,F,J}", "secondary": "H1", "weighting": "self-adjoint", "tau_p": 0.1,
    "projects": True, "integrator": "position Verlet", "jitter": 0.0, "cells": 3, "threads": 1,
}  # fmt: skip


@pytest.fixture(autouse=True)
def as_many_threads_after_as_before() -> Any:
    before = threads()
    yield
    set_threads(before)


def test_a_timing_makes_rows_tables_and_a_report(tmp_path: Path) -> None:
    rows = cases.sph_step(**OPTIONS, repeats_work=30.0)
    rows += cases.fem_step(element="B-bar FEM", cells=3, threads=1)
    rows.append({"kind": "machine", "threads": 1, "bandwidth": 8.0e9, "flops": 1.0e10})
    tables = study.tables(rows)
    step = tables["table"].iloc[0]
    assert step["ns_per_particle_step"] > 0.0
    assert step["bytes_per_particle"] > 100.0
    needs = max(step["traffic_per_particle"] / 8.0, step["flops_per_particle"] / 10.0)
    assert step["roofline_share"] == pytest.approx(needs / step["ns_per_particle_step"])
    names = tables["passes"]["pass"].tolist()
    assert names == [
        "gradient, projection, stress", "secondary points", "adjoint of the interpolation", "R_p",
        "D(J)", "D(p)", "divergence", "time step",
    ]  # fmt: skip
    run = json.loads((ROOT / "reports" / "convergence" / "run.json").read_text())
    document = study.report(Results(tmp_path, tables, pd.DataFrame(), run))
    assert isinstance(document, Document)


def test_passes_that_are_absent_are_not_listed() -> None:
    bare = cases.particles(**(OPTIONS | {"secondary": "-", "tau_p": 0.0}))
    names = [each.name for each in cases.passes(bare)]
    assert names == ["gradient, projection, stress", "divergence", "time step"]


def test_operations_are_counted_by_doing_them() -> None:
    material = sph.NeoHookean.from_young(young_modulus=1.0, poisson_ratio=0.3, density=1.0)
    # 9 products of F, 9 additions of products of H, the contraction's 17, and the scalars.
    both = counting.stress_operations(material, has_H=True, has_J=True)
    assert 27 + 17 < both < 100
    with_H = counting.stress_operations(material, has_H=False, has_J=True)
    assert with_H == both + 27, "nine times two products and a difference"
    assert counting.contraction_operations() == 17


PAPER = {"weighting": "as printed", "integrator": "TVD-RK2", "solver": "SUPG-SPH"}
MINE = {"weighting": "self-adjoint", "integrator": "position Verlet", "solver": "SUPG-SPH"}


def row(kind: dict[str, str], cloud: str, cells: int, count: int, ns: float) -> dict[str, Any]:
    common = {
        "formulation": "{p,F,J}", "secondary": "H1", "tau_p": 0.0, "projects": True,
        "bytes_per_particle": 1200.0, "cloud": cloud, "threads": count,
        "ns_per_particle_step": ns,
    }  # fmt: skip
    return common | {"particles": (cells + 1) ** 3} | kind


def synthetic(**changes: float) -> dict[str, pd.DataFrame]:
    value = {"paper": 300.0, "default": 250.0, "one": 600.0, "jitter": 700.0, "fem": 400.0}
    value |= changes
    rows = [
        row(PAPER, "lattice", 32, 2, value["paper"]),
        row(PAPER, "lattice", 32, 1, value["one"]),
        row(PAPER, "jitter 0.2", 32, 2, value["jitter"]),
        *(
            row(MINE, "lattice", cells, 2, value["default"] * factor)
            for cells, factor in ((22, 1.0), (32, 1.0), (64, 1.1), (100, 1.2))
        ),
        row(MINE, "lattice", 32, 2, value["fem"])
        | {"solver": "B-bar FEM", "particles": 32**3, "formulation": "-", "integrator": "-"},
    ]
    column = pd.DataFrame([{"integrator": "position Verlet", "cpu_ms_per_particle": 0.5}])
    start = pd.DataFrame([{"cold_s": 30.0, "warm_s": 2.0}])
    return {"table": pd.DataFrame(rows), "column": column, "start": start}


def test_targets_are_met_or_not_by_their_figures() -> None:
    met = targets(synthetic()).set_index("target")["met"]
    assert met.all()
    slow = targets(synthetic(paper=450.0, jitter=900.0, fem=600.0)).set_index("target")["met"]
    missed = set(slow.index[~slow.astype(bool)])
    assert missed == {
        "ns a particle-step, paper's step, lattice 33^3",
        "ns an element-step, B-bar 33^3",
        "ns a particle-step, paper's step, 20 % jitter 33^3",
        "2 threads over one, paper's step",
    }
    of_paper = " ".join(target for target in met.index if "paper" in target)
    assert "65^3" not in of_paper, "what was not run is left out"
