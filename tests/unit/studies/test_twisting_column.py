"""The twisting-column study: its comparisons, its verdicts on tables made up for them, its end."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.defaults import default_stabilisation
from sphsolid.scenes import twisting_column as column_scene
from studies.harness.results import Results, read_results
from studies.report.document_pdf import write_pdf
from studies.report.indicators import pressure_noise
from studies.report.plotting import style
from studies.twisting_column import cases, study
from studies.twisting_column.compare import centres, difference, kink, nodes
from studies.twisting_column.methods import (
    FEM,
    H1,
    H6,
    KEPT,
    LITERAL,
    LITERAL_H6,
    METHODS,
    NO_TAU_P,
    SELF_ADJOINT,
    THREE_STAGES,
    TOOLKIT,
    finest,
    lattice,
    usual_cfl,
)
from studies.twisting_column.requirements import extrapolated, requirements
from studies.twisting_column.summary import COLUMNS, clamp_torque
from studies.twisting_column.verdicts import IN_PART, NOT, REPRODUCED, UNDECIDED, claims


def grid_run(cells: int, lift: float = 0.0, factor: float = 1.0) -> dict[str, Any]:
    """A stretched column with a pressure that is linear in space."""
    X = np.stack(np.meshgrid(*nodes(cells), indexing="ij"), axis=-1)
    C = np.stack(np.meshgrid(*centres(cells), indexing="ij"), axis=-1)
    x = X * [1.0, 1.1, 1.0] + [0.0, lift, 0.0]
    pressure = factor * (2.0 + C[..., 1] - 0.5 * C[..., 0])
    fields = {"grid_x": x, "grid_pressure": pressure}
    fields["grid_mean"] = 2.0 * pressure
    return {"cells": cells} | {name: field.ravel().tolist() for name, field in fields.items()}


def test_linear_fields_on_two_lattices_are_the_same():
    found = difference(grid_run(3), grid_run(4))
    assert found["position_rms [m]"] == pytest.approx(0.0, abs=1e-12)
    assert found["pressure_rms"] == pytest.approx(0.0, abs=1e-12)


def test_a_difference_is_measured_in_metres_and_in_shares_of_the_reference():
    found = difference(grid_run(3, lift=0.02, factor=1.1), grid_run(4))
    assert found["position_rms [m]"] == pytest.approx(0.02)
    assert found["pressure_rms"] == pytest.approx(0.1)
    free = centres(3)[1] > cases.CLAMP
    exact = np.reshape(grid_run(3)["grid_pressure"], (3, 18, 3))[:, free]
    assert found["mean_rms"] == pytest.approx(0.1)
    assert found["other_mean_99 [Pa]"] == pytest.approx(2.0 * np.percentile(exact, 99))
    assert found["own_mean_99 [Pa]"] == pytest.approx(2.2 * np.percentile(exact, 99))


@pytest.mark.parametrize(("layer", "volumes"), [(0, 0.5), (18, 0.5), (7, 1.0)])
def test_a_distance_counts_by_the_volume_of_its_particle(layer, volumes):
    """Particles of a face stand for half of what those inside do."""
    moved = grid_run(3)
    x = np.reshape(moved["grid_x"], (4, 19, 4, 3))
    x[:, layer, :, 2] += 0.03
    moved["grid_x"] = x.ravel().tolist()
    found = difference(moved, grid_run(4))
    assert found["position_rms [m]"] == pytest.approx(0.03 * math.sqrt(volumes / 18.0))


def test_pressures_at_the_clamp_are_left_out():
    other = grid_run(3)
    C = np.stack(np.meshgrid(*centres(3), indexing="ij"), axis=-1)
    clamped = C[..., 1] <= cases.CLAMP
    assert clamped.any()
    spiked = dict(other)
    for name in ("grid_pressure", "grid_mean"):
        spiked[name] = (np.reshape(other[name], clamped.shape) + 50.0 * clamped).ravel().tolist()
    found = difference(spiked, grid_run(4))
    assert found["pressure_rms"] == pytest.approx(0.0, abs=1e-12)
    assert found["mean_rms"] == pytest.approx(0.0, abs=1e-12)
    # Just above it, a difference is one.
    lowest = C[..., 1] == C[..., 1][~clamped].min()
    spiked["grid_pressure"] = (
        np.reshape(other["grid_pressure"], clamped.shape) + 50.0 * lowest
    ).ravel().tolist()
    assert difference(spiked, grid_run(4))["pressure_rms"] > 1.0


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_fields_come_in_the_order_of_the_grid(solver):
    snapshot = solver(column_scene(), spacing=0.5).snapshot()
    J = 1.0 + 1e-3 * snapshot.stress_X @ [1.0, 2.0, 3.0]
    row = cases.fields_on_grid(replace(snapshot, J=J), 2)
    X = np.stack(np.meshgrid(*nodes(2), indexing="ij"), axis=-1)
    assert np.reshape(row["grid_x"], X.shape) == pytest.approx(X, abs=1e-7)
    C = np.stack(np.meshgrid(*centres(2), indexing="ij"), axis=-1)
    expected = 1e-3 * snapshot.material.kappa * (C @ [1.0, 2.0, 3.0])
    assert np.reshape(row["grid_pressure"], expected.shape) == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize(("zigzag", "seen"), [(0.0, 0.0), (0.1, 0.1)])
def test_a_kink_is_the_twist_that_alternates(zigzag, seen):
    X = np.stack(np.meshgrid(*nodes(3), indexing="ij"), axis=-1)
    layer = np.arange(19)
    angle = layer * 6.0 / 18.0 + zigzag * (-1.0) ** layer
    turned = (X[..., 0] + 1j * X[..., 2]) * np.exp(1j * angle)[None, :, None]
    x = np.stack([turned.real, X[..., 1], turned.imag], axis=-1)
    assert kink({"cells": 3, "grid_x": x.ravel().tolist()}) == pytest.approx(seen, abs=1e-12)


def test_noise_can_leave_the_clamp_out():
    snapshot = sph.Simulation(column_scene(), spacing=0.25).snapshot()
    height = snapshot.X[:, 1]
    spiked = replace(snapshot, J=1.0 + 1e-3 * height - 0.1 * (height == 0.0))
    assert pressure_noise(spiked) > 0.1
    assert pressure_noise(spiked, above=cases.CLAMP) == pytest.approx(0.0, abs=1e-9)
    assert pressure_noise(spiked, above=7.0) == 0.0


def test_layers_hold_mean_and_extremes():
    snapshot = fem.Simulation(column_scene(), spacing=0.5).snapshot()
    X = snapshot.stress_X
    rows = cases.layers(replace(snapshot, J=1.0 + 1e-3 * (X[:, 1] + X[:, 0])), 2)
    kappa = snapshot.material.kappa
    assert [row["Y [m]"] for row in rows] == pytest.approx(0.25 + 0.5 * np.arange(12))
    for row in rows:
        assert row["pressure_mean [Pa]"] == pytest.approx(1e-3 * kappa * row["Y [m]"])
        assert row["pressure_max [Pa]"] - row["pressure_min [Pa]"] == pytest.approx(5e-4 * kappa)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_turns_are_counted_whatever_the_sense(sense):
    true = np.linspace(0.0, 7.0, 40)
    seen = [math.remainder(sense * angle, 2.0 * math.pi) for angle in true]
    assert cases.unwrapped(np.array(seen)) == pytest.approx(true)


def test_torque_is_the_rate_of_the_angular_impulse():
    history = pd.DataFrame(
        {"time [s]": [0.0, 1.0, 3.0], "angular_impulse_y [kg m^2/s]": [0.0, -2.0, 4.0]}
    )
    assert clamp_torque(history) == pytest.approx([0.0, -2.0, 3.0])


def made_up() -> dict[str, pd.DataFrame]:
    """Tables on which every claim and every requirement holds."""
    rows = []
    for label, method in METHODS.items():
        cfl = usual_cfl(label)
        for cells in (3, 4, 5, 10, *((16,) if label == FEM else ())):
            row = dict.fromkeys(COLUMNS, 0.0) | dict(method)
            row |= {"label": label, "cells": cells, "cfl": cfl, "nu": 0.495, "survived": True}
            row |= {f"twist_{ms}": 5.93 for ms in (20, 40, 60, 80, 100)}
            row |= {"height_100": 6.01, "energy_kept": 0.99, "rest_largest": 3e-4}
            row |= {f"{kind}_mean_{s}": 1e4 * s for kind in ("pressure", "reference")
                    for s in (1, 50, 99)}  # fmt: skip
            row["position_rms"] = 0.1 / cells**2
            row["noise_free_mean"] = 0.4 if label == NO_TAU_P else 0.1
            rows.append(row)
            if label == TOOLKIT and cells == 3:
                for share in (0.5, 0.25):
                    kept = {"label": label + KEPT, "cfl": share * cfl}
                    rows.append(row | kept | {"rest_largest": 3e-4 * share**2})
    differences = [
        {"label": H6, "other": H1, "cells": cells, "cfl": 0.3, "nu": 0.495,
         "position_rms [m]": 0.001, "pressure_rms": 0.02}
        for cells in (3, 4, 5)
    ]  # fmt: skip
    cost = {"secondary": ["none", "H1", "H6"], "step_s": [1.0, 2.0, 7.0], "cells": 5}
    return {
        "table": pd.DataFrame(rows), "differences": pd.DataFrame(differences),
        "cost": pd.DataFrame(cost),
    }  # fmt: skip


def changed(column: str, value: Any, where: str = "table", **which: Any) -> list[str]:
    tables = made_up()
    frame = tables[where]
    chosen = np.ones(len(frame), dtype=bool)
    for name, wanted in which.items():
        chosen &= (frame[name] == wanted).to_numpy()
    assert chosen.any()
    if isinstance(value, bool):
        frame[column] = frame[column].astype(bool)
    frame.loc[chosen, column] = value
    return [one.verdict for one in claims(tables)]


def test_every_claim_can_be_reproduced():
    assert [one.verdict for one in claims(made_up())] == [REPRODUCED] * 6


@pytest.mark.parametrize(
    ("claim", "grade", "change"),
    [
        (0, IN_PART, ("pressure_rms", 0.3, "differences", {"cells": 4})),
        (0, NOT, ("position_rms [m]", 0.05, "differences", {"cells": 4})),
        (0, NOT, ("twist_60", 5.8, "table", {"label": H6, "cells": 5})),
        (1, IN_PART, ("position_rms", 0.02, "table", {"label": H1, "cells": 4})),
        (1, NOT, ("position_rms", 0.2, "table", {"label": H1, "cells": 10})),
        (2, IN_PART, ("pressure_mean_99", 2e6, "table", {"label": H1, "cells": 5})),
        (2, NOT, ("twist_80", 6.3, "table", {"label": H1, "cells": 5})),
        (2, NOT, ("height_100", 6.05, "table", {"label": H1, "cells": 5})),
        (3, IN_PART, ("height_100", 6.10, "table", {"label": H6, "cells": 3})),
        (3, NOT, ("twist_100", 5.5, "table", {"label": H6, "cells": 3})),
        (4, IN_PART, ("step_s", 4.0, "cost", {"secondary": "H6"})),
        (4, NOT, ("step_s", 2.5, "cost", {"secondary": "H6"})),
        (5, IN_PART, ("survived", False, "table", {"label": LITERAL_H6, "cells": 3})),
        (5, IN_PART, ("energy_kept", 1.02, "table", {"label": LITERAL, "cells": 3})),
        (5, NOT, ("twist_20", 6.5, "table", {"operator": "Literal"})),
    ],
)  # fmt: skip
def test_every_verdict_is_reachable(claim, grade, change):
    column, value, where, which = change
    grades = changed(column, value, where, **which)
    assert grades[claim] == grade
    assert grades.count(REPRODUCED) >= 4


def test_a_claim_without_its_runs_is_not_decided():
    tables = made_up()
    tables["table"] = tables["table"][tables["table"]["cells"].isin([5, 16])]
    tables["table"] = tables["table"][tables["table"]["label"].isin([FEM, TOOLKIT])]
    tables["differences"] = tables["differences"].iloc[:0]
    tables["cost"] = tables["cost"].iloc[:0]
    assert [one.verdict for one in claims(tables)] == [UNDECIDED] * 6


def test_requirements_are_met_and_missed():
    table = made_up()["table"]
    frame = requirements(table)
    assert set(frame["verdict"]) == {"met", "reported"}
    assert {what.split(",")[0].split(" against")[0] for what in frame["what"]} >= {
        "twist at 0.1 s", "energy kept at 0.1 s", "mean pressure noise",
        "largest |rest| of the ledger over E0", "order of |rest| in the step",
    }  # fmt: skip
    for column, value, which in (
        ("twist_100", 6.0, {"label": H1, "cells": 10}),
        ("energy_kept", 0.96, {"label": H6, "cells": 5}),
        ("rest_largest", 2e-3, {"label": TOOLKIT, "cells": 4}),
        ("rest_largest", 2e-4, {"label": TOOLKIT + KEPT, "cfl": 0.5 * usual_cfl(TOOLKIT)}),
        ("angular_drift", 1e-9, {"label": LITERAL, "cells": 4}),
        ("noise_free_mean", 0.3, {"label": TOOLKIT, "cells": 10}),
    ):
        worse = table.copy()
        chosen = np.all([worse[name] == wanted for name, wanted in which.items()], axis=0)
        worse.loc[chosen, column] = value
        assert "not met" in set(requirements(worse)["verdict"]), column


def test_lattices_have_the_names_of_the_paper():
    assert [lattice(cells) for cells in (3, 4, 5, 10)] == [
        "4x19x4", "5x25x5", "6x31x6", "11x61x11"
    ]  # fmt: skip
    assert finest(made_up()["table"]) == 16


def test_the_default_row_gives_nothing_but_the_formulation(monkeypatch):
    given: dict[str, Any] = {}

    def caught(scene, **options):
        given.update(options)

    monkeypatch.setattr(sph, "Simulation", caught)
    where = {"cells": 3, "nu": 0.495}
    cases.simulation(**METHODS[TOOLKIT], **where, cfl=usual_cfl(TOOLKIT))
    assert given == {"spacing": 1.0 / 3.0, "formulation": sph.PFJ()}
    given.clear()
    cases.simulation(**METHODS[H1], **where, cfl=usual_cfl(H1))
    assert given["integrator"] == sph.TVDRK2()
    assert given["cfl"] == 0.3
    assert given["stabilisation"].weighting == sph.AsPrinted()


@pytest.mark.parametrize("nu", [0.495, 0.499])
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_the_default_keeps_its_tau_F_in_seconds(nu, share):
    cfl = share * usual_cfl(TOOLKIT)
    case = study._case(TOOLKIT, 3, "", cfl=cfl, nu=nu, kept=share != 1.0)
    chosen = default_stabilisation(sph.PFJ(), column_scene(poisson_ratio=nu).material)
    assert sph.OfMesh(case.arguments["tau_F"]) == chosen.tau_F
    assert case.arguments["tau_unit"] == "h/c_p"
    assert case.arguments["weighting"] == SELF_ADJOINT
    assert case.arguments["tau_p"] == pytest.approx(0.1 / share)


def test_two_integrators_have_the_same_times_of_the_mesh():
    verlet, three = METHODS[TOOLKIT], METHODS[THREE_STAGES]
    assert three["integrator"] == "SSP-RK3"
    same = {"integrator"}
    assert {k: v for k, v in verlet.items() if k not in same} == {
        k: v for k, v in three.items() if k not in same
    }


def test_the_full_study_has_every_method_on_every_lattice_of_the_paper(tmp_path):
    listed = study.cases(argparse.Namespace(quick=False, out=tmp_path))
    seen = {
        (case.arguments["label"], case.arguments["cells"])
        for case in listed
        if case.arguments.get("nu") == 0.495
    }
    assert seen >= {(label, cells) for label in METHODS for cells in (3, 4, 5)}
    keys = [case.key for case in listed]
    assert len(set(keys)) == len(keys)
    kept = next(c.arguments for c in listed if c.key == f"{H1}{KEPT} 1/3 CFL 0.15")
    assert (kept["tau_F"], kept["tau_p"]) == (2.0, 0.2)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Results:
    """Three methods on 3x13x3 particles, elements on 4x19x4 too, in this process."""
    out: Path = tmp_path_factory.mktemp("column")
    listed = [study._case(label, 2, (out / "shots").as_posix()) for label in (H1, TOOLKIT, FEM)]
    listed.append(study._case(FEM, 3, (out / "shots").as_posix()))
    rows = [row for case in listed for row in cases.run_case(**case.arguments)]
    rows += cases.cost_case(cells=2, steps=3, rounds=2)
    run = read_results("convergence", Path(__file__).parents[3] / "reports" / "convergence").run
    failures = pd.DataFrame(columns=["key", "failure", "message", "wall_s"])
    return Results(out, study.tables(rows), failures, run)


def test_a_run_is_one_row_with_its_account_closed(tiny):
    table = tiny.tables["table"].set_index(["label", "cells"])
    assert len(table) == 4
    # One evaluation a step, and a longer one: the default is not slower than the paper's.
    assert table.loc[(TOOLKIT, 2), "steps"] < 0.5 * table.loc[(H1, 2), "steps"]
    assert table.loc[(TOOLKIT, 2), "rest_largest"] < 1e-3
    own = table.loc[(H1, 2)]
    assert own["survived"]
    assert own["end_time"] == 0.1
    # So few particles ring; the elements do not.
    assert table.loc[(FEM, 2), "rest_largest"] < 1e-3
    assert own["angular_drift"] < 1e-12
    works = own[["dissipation_p", "dissipation_J", "projection", "rest"]].sum()
    assert own["energy_kept"] == pytest.approx(1.0 + works, abs=1e-9)
    assert own["dissipation_p"] < 0.0
    # On three particles across the twist is right to a tenth.
    assert own["twist_100"] == pytest.approx(5.93, rel=0.1)
    assert np.isnan(table.loc[(FEM, 3), "position_rms"])
    assert 0.0 < own["position_rms"] < 0.3
    assert not {"grid_x", "grid_mean"} & set(tiny.tables["table"])
    assert table.loc[(FEM, 3), "ringing"] > 0.0
    assert own["pressure_mean_1"] < own["pressure_mean_50"] < own["pressure_mean_99"]


def test_a_mean_is_over_the_time_after_the_end():
    sim = fem.Simulation(column_scene(), spacing=0.5)
    sim.run(until=0.01)
    row = cases.mean_pressure(sim, 0.012, 2)
    assert sim.time == 0.012
    assert np.shape(row["grid_mean"]) == (2 * 12 * 2,)
    assert row["ringing"] > 0.0


def test_extrapolation_is_exact_for_second_order():
    table = made_up()["table"]
    rows = table["label"] == FEM
    table.loc[rows, "twist_100"] = 5.9 + 2.0 / table.loc[rows, "cells"] ** 2
    assert extrapolated(table, "twist_100") == pytest.approx(5.9)
    assert extrapolated(table[table["cells"] < 16], "twist_100") is None


def test_the_report_is_made_from_the_tables(tiny):
    with style():
        document = study.report(tiny)
    write_pdf(document, tiny.out / "report.pdf")
    assert (tiny.out / "report.pdf").stat().st_size > 50_000
    for name in ("histories", "energy", "accuracy", "percentiles", "profile", "noise",
                 "lattices", "methods", "sequence"):  # fmt: skip
        assert (tiny.out / f"{name}.png").stat().st_size > 10_000, name


def test_a_lost_solution_is_a_row_that_says_where(tmp_path):
    arguments = dict(study._case(H1, 2, "").arguments) | {"frames": [], "cfl": 3.0, "until": 0.05}
    assert arguments["average"] > 0.0
    row = next(row for row in cases.run_case(**arguments) if row["kind"] == "run")
    assert "grid_mean" not in row
    assert row["survived"] is False
    assert 0.0 < row["end_time"] < 0.05
    assert "step" in row["reason"]
