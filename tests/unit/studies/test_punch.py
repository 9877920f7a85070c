"""The punch study on a lattice of 11x6x2 points: rows, tables, document, a run that is lost."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from studies.harness.cases import ROOT
from studies.harness.results import Results
from studies.pictures.shots import Lost, Shot, ShotFolder
from studies.punch import cases as punch_cases
from studies.punch import cost as punch_cost
from studies.punch import study as punch
from studies.punch import tables as punch_tables
from studies.punch.methods import DISPLACEMENT, FEM, GALERKIN, H1, H6, METHODS, TOOLKIT, toolkit
from studies.report.document import Document, Figure

CELLS = 10


def _rows(shots: Path, press: str, method: str, until: float = 0.015, cells: int = CELLS):
    operator = "-" if method == FEM else "Consistent"
    return punch_cases.run_case(
        key=f"{press} {method} {cells}", press=press, method=method, operator=operator,
        cells=cells, until=until, shots=str(shots), shot_times=[0.005, 0.01, 0.015],
        label=method,
    )  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Five methods, three of them in both readings, to 15 ms, as the front would hand them on."""
    out = tmp_path_factory.mktemp("punch")
    rows = [
        row
        for press, methods in (
            ("initial", (FEM, DISPLACEMENT, GALERKIN, H6, H1)), ("held", (FEM, H6, H1)),
        )
        for method in methods
        for row in _rows(out / "shots", press, method)
    ]
    rows += _rows(out / "shots", "initial", FEM, cells=2 * CELLS)
    rows += punch_cost.run_case(key="cost", tau_p=0.1, cells=CELLS, repeats=2, work=1e3)
    run = json.loads((ROOT / "reports" / "convergence" / "run.json").read_text())
    return Results(out, punch.tables(rows), pd.DataFrame(), run)


def _one(results: Results, press: str, method: str) -> pd.Series:
    table = results.tables["table"]
    found = table[(table["press"] == press) & (table["method"] == method)]
    return found.sort_values("cells").iloc[0]


def test_every_run_has_a_row_with_all_that_was_measured(results: Results) -> None:
    table = results.tables["table"]
    assert len(table) == 9
    assert set(table["lattice"]) == {"11x6x2", "21x11x3"}
    assert table["survived"].all()
    held = table[table["press"] == "held"]
    assert held[punch_tables.MEASURED].drop(columns="noise_late").notna().all(axis=None)
    # The punch goes down at 10 m/s, whoever computes it.
    np.testing.assert_allclose(held["top_low"], 0.5 - 10.0 * punch_cases.COMPARED, atol=1e-9)


def test_finite_elements_differ_from_themselves_by_nothing(results: Results) -> None:
    row = _one(results, "held", FEM)
    assert row["profile_same"] == row["profile_finest"] == row["top_rms"] == 0.0


def test_the_distance_over_time_is_of_the_worse_end_of_the_range(results: Results) -> None:
    history = results.tables["history"]
    frames = [
        history[history["key"] == f"held {method} {CELLS}"].set_index("time [s]")["top_high [m]"]
        for method in (H1, FEM)
    ]
    apart = (frames[0].to_numpy() - frames[1].to_numpy())[1:]
    # The punch holds the lower end, so all the difference is in the upper one.
    expected = np.sqrt(np.mean(apart**2))
    assert _one(results, "held", H1)["top_rms"] == pytest.approx(expected, rel=1e-9)
    assert expected > 1e-4


def test_heights_are_compared_with_the_finest_elements_point_by_point(results: Results) -> None:
    profile, coarse = results.tables["profile"], _one(results, "initial", H1)
    at = profile[np.isclose(profile["time"], 0.015)].set_index("X")
    ours = at[at["key"] == coarse["key"]]["z"]
    fine = at[at["key"] == f"initial {FEM} {2 * CELLS}"]["z"]
    expected = (ours - fine.to_numpy()[::2]).abs().max()
    assert coarse["profile_finest"] == pytest.approx(expected, rel=1e-12)
    assert coarse["profile_same"] != pytest.approx(expected, rel=1e-3)


def test_displacement_sph_is_the_unstabilised_mixed_method(results: Results) -> None:
    a, b = (_one(results, "initial", method) for method in (DISPLACEMENT, GALERKIN))
    assert a["top_low"] == pytest.approx(b["top_low"], abs=1e-5)
    assert a["energy_D_p"] == b["energy_D_p"] == 0.0


def test_the_energy_account_closes(results: Results) -> None:
    table = results.tables["table"]
    supg = table[table["method"].isin([H1, H6])]
    total = supg["energy_kept"] - supg[
        ["energy_D_p", "energy_D_J", "energy_projection", "energy_rest"]
    ].sum(axis=1)
    # What is kept, less all works, is what was supplied: nothing is missing from the table.
    np.testing.assert_allclose(total, 1.0, rtol=1e-9)
    assert (supg["energy_D_p"] < 0.0).all()


def test_the_momentum_of_the_body_is_what_floor_and_punch_gave(results: Results) -> None:
    row = _one(results, "held", H1)
    history = results.tables["history"]
    mine = history[history["key"] == row["key"]].sort_values("time [s]")
    change = mine["linear_momentum_z [kg m/s]"].iloc[[0, -1]].diff().iloc[-1]
    assert change == pytest.approx(row["floor_impulse"] + row["press_impulse"], rel=1e-9)


def test_the_document_shows_frames_and_curves(results: Results) -> None:
    document = punch.STUDY.report(results)
    assert isinstance(document, Document)
    figures = [b for section in document.sections for b in section.blocks if isinstance(b, Figure)]
    names = {figure.path.name for figure in figures}
    assert {"noise", "profile", "height", "comparison", "evolution_initial_consistent"} <= names
    # Nothing ran with the operator as printed, nor to 30 ms: no page of empty panels.
    assert not any("literal" in name or "sequence" in name for name in names)
    for figure in figures:
        assert figure.file("png").stat().st_size > 5_000


def test_a_lost_run_is_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def reckless(scene, *, method, operator, cells):
        return sph.Simulation(scene, spacing=1.0 / cells, formulation=sph.PFJ(), cfl=3.0)

    monkeypatch.setattr(punch_cases, "simulation", reckless)
    rows = _rows(tmp_path, "initial", H1)
    table = punch.tables(rows)["table"]
    lost = table.iloc[0]
    assert not lost["survived"]
    assert 0.0 < lost["lost_at"] < 0.015
    assert lost["lost_where"].endswith("m")
    assert lost["reason"]
    assert np.isnan(lost["top_low"])
    assert lost["J_min"] > 0.0
    assert isinstance(ShotFolder(tmp_path).load(f"initial {H1} {CELLS}", 0.015), Lost)


def test_frames_are_kept_at_the_times_asked_for(results: Results) -> None:
    shots = ShotFolder(results.out / "shots").load_all(f"held {H6} {CELLS}")
    assert [shot.time for shot in shots] == pytest.approx([0.005, 0.01, 0.015])
    assert all(isinstance(shot, Shot) and shot.label == H6 for shot in shots)


def test_the_full_study_covers_what_the_paper_shows(tmp_path: Path) -> None:
    options = argparse.Namespace(quick=False, cells=20, out=tmp_path)
    listed = punch.cases(options)
    assert len({case.key for case in listed}) == len(listed)
    runs = [case.arguments for case in listed if case.run.endswith("punch.cases:run_case")]
    assert {run["press"] for run in runs} == set(punch_cases.PRESSES)
    assert {run["method"] for run in runs} == set(METHODS)
    assert {run["cells"] for run in runs} == {20, 40, 60, 80}
    with pytest.raises(InputError, match="at least 10"):
        punch.cases(argparse.Namespace(quick=True, cells=2, out=tmp_path))


def test_the_default_row_is_what_the_package_does_by_itself() -> None:
    scene = punch_cases.punch()
    sims = [
        punch_cases.simulation(scene, method=name, operator="Consistent", cells=CELLS)
        for name in (TOOLKIT, toolkit(0.2), H1)
    ]
    bare = sph.Simulation(scene, spacing=1.0 / CELLS, formulation=sph.PFJ())
    assert sims[0].identity() == bare.identity()
    assert sims[1].stabilisation == replace(bare.stabilisation, tau_p=0.2)
    assert sims[1].integrator == bare.integrator
    assert sims[2].integrator == sph.TVDRK2()
    stated = METHODS[TOOLKIT]
    assert stated.tau_unit == "h/c_p"
    assert (sph.OfMesh(stated.tau_F), stated.xi_F, sph.OfStep(stated.tau_p)) == (
        bare.stabilisation.tau_F, bare.stabilisation.xi_F, bare.stabilisation.tau_p,
    )  # fmt: skip


def test_wide_support_is_the_cubic_spline_of_two_spacings() -> None:
    scene = punch_cases.punch()
    wide = [name for name, method in METHODS.items() if method.wide]
    sim = punch_cases.simulation(scene, method=wide[0], operator="Consistent", cells=CELLS)
    assert sim.cloud.smoothing == sph.CubicSpline()
    assert sim.cloud.smoothing.support * sim.cloud.h == pytest.approx(2.0 / CELLS)
    narrow = punch_cases.simulation(scene, method=H6, operator="Consistent", cells=CELLS)
    assert replace(METHODS[wide[0]], wide=False, tau_p=0.1) == METHODS[H6]
    assert narrow.cloud.h < sim.cloud.h
