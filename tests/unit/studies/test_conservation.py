"""Verdicts of the conservation study on made-up tables, and the study on a handful of particles."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import Diverged
from sphsolid.scenes import l_shaped_block
from studies.conservation import study as conservation
from studies.conservation.measures import (
    DEFAULTS,
    INTEGRATORS,
    MADE_BY_TIME,
    left_over,
    outcome,
)
from studies.conservation.runs import CFLS, CUBE, ELEMENTS, PAPER, block_cases, cube_cases, tiny
from studies.conservation.verdicts import (
    pressure_verdicts,
    rest_orders,
    undeformed_impulse,
    verdicts,
)
from studies.harness.front import main

NOTHING = pd.DataFrame(columns=conservation.COLUMNS["cube"])
GOOD = {
    "survived": True, "folded": False, "outcome": "kept", "linear": 1e-15, "angular_free": 1e-15,
    "impulse_gap": 1e-16, "noise": 0.2, "load": 1.0, "L_x": 0.0, "L_y": 0.0, "L_z": 0.0,
}  # fmt: skip


def runs(*rows: dict[str, Any]) -> pd.DataFrame:
    """Runs of the block, good ones of group ``all`` where nothing else is said."""
    whole = [{"group": "all"} | PAPER | GOOD | row for row in rows]
    return pd.DataFrame(whole, columns=conservation.COLUMNS["table"])


def cubes(*rows: dict[str, Any]) -> pd.DataFrame:
    good = {
        "group": "ladder", "survived": True, "folded": False, "outcome": "kept", "spin": 105.0,
        "rest": 1e-7,
        "left_over": 1e-7,
        "angular_total": 1e-15, "linear_total": 1e-15,
    }  # fmt: skip
    return pd.DataFrame([CUBE | good | row for row in rows], columns=conservation.COLUMNS["cube"])


def said(table: pd.DataFrame, cube: pd.DataFrame = NOTHING) -> dict[str, tuple[str, float]]:
    found = verdicts(table, cube, rest_orders(cube))
    return {row.claim: (row.verdict, row.measured) for row in found.itertuples()}


@pytest.mark.parametrize("column", ["linear", "angular_free"])
@pytest.mark.parametrize(
    ("drifts", "verdict"),
    [
        ((1e-15, 9e-13), "reproduced"),
        ((1e-15, 2e-12), "in part"),
        ((1e-3, 2e-12), "not reproduced"),
    ],
)
def test_momentum_is_judged_by_the_worst_run(
    column: str, drifts: tuple[float, float], verdict: str
) -> None:
    claim = {
        "linear": "linear momentum is zero to round-off",
        "angular_free": "angular momentum is constant without loads",
    }[column]
    assert said(runs(*({column: drift} for drift in drifts)))[claim] == (verdict, max(drifts))


def test_a_lost_run_has_shown_nothing() -> None:
    """Its numbers are those of the time before, or missing."""
    lost = {"survived": False, "outcome": "lost"}
    verdict = said(runs({}, lost | {"angular_free": float("nan"), "linear": 1e-16}))
    assert verdict["angular momentum is constant without loads"][0] == "in part"
    assert np.isnan(verdict["angular momentum is constant without loads"][1])
    assert verdict["linear momentum is zero to round-off"][0] == "in part"
    assert verdict["runs to 20 s, every combination (share)"] == ("in part", 0.5)
    assert said(runs(lost))["runs to 20 s, every combination (share)"][0] == "not reproduced"


def test_a_run_that_folded_has_shown_nothing() -> None:
    """Momentum is that of the body it was, energy may be kept, and it is no body any more."""
    verdict = said(runs({}, {"folded": True, "folded_at": 3.0, "outcome": "folded"}))
    assert verdict["linear momentum is zero to round-off"][0] == "in part"
    assert verdict["runs to 20 s, every combination (share)"] == ("in part", 0.5)
    smooth = ELEMENTS | {"group": "elements", "noise": 0.2, "spacing": PAPER["spacing"]}
    both = runs(smooth, {"folded": True, "outcome": "folded"})
    claim = next(text for text in said(both) if text.startswith("pressure is smooth"))
    assert said(both)[claim] == ("not reproduced", float("inf"))


def test_a_run_that_made_energy_did_not_survive_in_earnest() -> None:
    verdict = said(runs({}, {"outcome": "energy made"}))
    assert verdict["runs to 20 s, every combination (share)"] == ("in part", 0.5)


@pytest.mark.parametrize(("drift", "word"), [(1e-4, "reproduced"), (1e-9, "not reproduced")])
def test_the_contrast_needs_a_drift(drift: float, word: str) -> None:
    table = runs({}, {"group": "no projection", "projection": "none", "angular_free": drift})
    assert said(table)["without the projection it is not"] == (word, drift)


@pytest.mark.parametrize(
    ("noise", "word"), [(0.19, "reproduced"), (0.39, "in part"), (0.41, "not reproduced")]
)
def test_pressure_is_compared_on_the_same_mesh(noise: float, word: str) -> None:
    elements = [
        ELEMENTS | {"group": "elements", "noise": value, "spacing": spacing}
        for value, spacing in ((0.1, PAPER["spacing"]), (9.0, 0.5))
    ]
    found = list(pressure_verdicts(runs({"noise": noise}, *elements)))
    assert [verdict.verdict for verdict in found] == [word]
    assert found[0].measured == pytest.approx(noise / 0.1)


@pytest.mark.parametrize(("gap", "word"), [(1e-11, "met"), (1e-9, "not met")])
def test_the_impulse_must_agree(gap: float, word: str) -> None:
    verdict = said(runs({"impulse_gap": gap}))
    assert verdict["angular momentum at 5 s is the applied impulse"] == (word, gap)


@pytest.mark.parametrize(("off", "word"), [(1e-4, "met"), (1e-2, "not met")])
def test_a_small_load_meets_the_undeformed_arms(off: float, word: str) -> None:
    L = dict(zip(("L_x", "L_y", "L_z"), (1.0 + off) * undeformed_impulse(1e-3), strict=True))
    verdict = said(runs({"group": "small load", "load": 1e-3} | L))
    found = verdict["a thousandth of the load: the undeformed-arm impulse"]
    assert found[0] == word
    assert found[1] == pytest.approx(off)


def test_the_undeformed_impulse_is_that_of_the_scene() -> None:
    """Sum of ``X x t_B`` over the loaded faces and over time, by brute force."""
    scene = l_shaped_block(jitter=0.0)
    mesh = scene.body.mesh(0.5)
    times = np.linspace(0.0, 5.0, 401)
    total = np.zeros(3)
    for traction in scene.tractions:
        quads = mesh.vertices[mesh.face(traction.face)]
        area = 9.0 / len(quads)
        centres = quads.mean(axis=1)
        pull = np.stack([traction.value(centres, centres, t) for t in times])
        impulse = np.trapezoid(pull, times, axis=0)
        total += area * np.cross(centres, impulse).sum(axis=0)
    np.testing.assert_allclose(total, undeformed_impulse(), rtol=1e-5)
    np.testing.assert_allclose(undeformed_impulse(), [-2.15e5, -1.14e5, 1.48e5], rtol=5e-3)


def test_orders_of_the_rest() -> None:
    cube = cubes(
        *({"cfl": cfl, "rest": 5.0 * cfl**3} for cfl in (0.3, 0.15, 0.075)),
        *({"cfl": cfl, "rest": 2.0 * cfl, "operator": "Literal"} for cfl in (0.3, 0.15)),
        {"cfl": 0.6, "rest": 1.0, "outcome": "energy made"},
    )
    orders = rest_orders(cube).set_index("operator")["order"]
    assert orders["Consistent"] == pytest.approx(3.0)
    assert orders["Literal"] == pytest.approx(1.0)
    assert said(runs(), cube)["cube: the rest falls as dt^2 or faster"][0] == "not met"
    only = cube[cube["operator"] == "Consistent"]
    assert said(runs(), only)["cube: the rest falls as dt^2 or faster"][0] == "met"


def test_an_order_of_the_ledger_is_fitted_to_every_run() -> None:
    cube = cubes(
        {"cfl": 0.8, "rest": 1.0, "left_over": 0.25}, {"cfl": 0.4, "rest": 1.0, "left_over": 1.0},
        {"cfl": 0.2, "rest": 0.25, "left_over": 1.0},
    )  # fmt: skip
    orders = rest_orders(cube).iloc[0]
    assert orders["order"] == pytest.approx(1.0)
    assert orders["order_left_over"] == pytest.approx(-1.0)


@pytest.mark.parametrize(("rest", "word"), [(9e-7, "met"), (2e-6, "not met")])
def test_the_ledger_is_judged_at_the_finest_kept_run(rest: float, word: str) -> None:
    cube = cubes(
        {"spacing": 0.25, "rest": 1e-3}, {"spacing": 0.125, "rest": rest},
        {"spacing": 0.0625, "rest": 1.0, "outcome": "energy made"},
    )  # fmt: skip
    claim = "cube: ledger closes at CFL 0.3 (finest run)"
    assert said(runs(), cube)[claim] == (word, rest)


def test_momenta_of_the_cube_count_in_every_projected_run() -> None:
    claim = "cube: angular momentum kept for ten turns"
    bare = {"group": "no projection", "projection": "none", "angular_total": 1e-2}
    assert said(runs(), cubes({}, bare))[claim][0] == "met"
    assert said(runs(), cubes({}, {"angular_total": 2e-12}))[claim][0] == "met in part"
    assert said(runs(), cubes({"angular_total": 2e-12}))[claim][0] == "not met"


def test_the_whole_study_holds_every_combination_once() -> None:
    cases = [*block_cases(Path("out")), *cube_cases()]
    keys = [case.key for case in cases]
    assert len(set(keys)) == len(keys)
    asked = {
        (a["formulation"], a["secondary"], a["operator"], a["projection"], a["spacing"])
        for a in (case.arguments for case in cases)
        if a["group"] in ("all", "no projection")
    }
    for formulation in ("{p,F}", "{p,F,J}", "{p,F,H,J}"):
        for secondary in ("H1", "H6"):
            for operator in ("Literal", "Consistent"):
                for projection, spacing in (("local", 0.85), ("none", 0.85), ("local", 0.5)):
                    assert (formulation, secondary, operator, projection, spacing) in asked


def test_every_integrator_has_an_order_at_the_same_steps() -> None:
    asked = {(a["integrator"], a["cfl"]) for a in (c.arguments for c in cube_cases())
             if a["group"] in ("ladder", "methods") and a["method"] == "SUPG-SPH"}  # fmt: skip
    assert asked >= {(name, cfl) for name in INTEGRATORS for cfl in CFLS}


def test_a_tiny_study_runs_from_command_line_to_report(tmp_path: Path) -> None:
    study = dataclasses.replace(
        conservation.STUDY,
        cases=lambda options: list(tiny(options.out)),
        warm_up=lambda options: [],
    )
    assert main(study, ["--out", str(tmp_path), "--jobs", "1"]) == 0
    for name in ("momenta", "drift", "ledger", "cube"):
        assert (tmp_path / f"{name}.png").stat().st_size > 0
    assert (tmp_path / "report.pdf").stat().st_size > 0
    run = json.loads((tmp_path / "run.json").read_text())
    assert run["cases_failed"] == 0
    table = pd.read_csv(tmp_path / "table.csv")
    whole = table[table["until"] == 6.0]
    assert (whole["survived"]).all()
    assert (whole[["linear", "angular_free", "angular_step"]] < 1e-12).all(axis=None)
    assert (whole["impulse_gap"] < 1e-12).all()
    assert (whole["left_over"].abs() < 1e-3).all()
    mine = table[table["method"] == DEFAULTS].iloc[0]
    assert (mine["integrator"], mine["weighting"]) == ("position Verlet", "self-adjoint")
    cube = pd.read_csv(tmp_path / "cube.csv")
    assert (cube["angular_total"] < 1e-12).all()
    # Lumped masses at eight corners and the points between: 1 + 2 h^2 times the exact cube.
    np.testing.assert_allclose(cube["L_z"], 19250.0 * 1.5, rtol=1e-12)
    words = pd.read_csv(tmp_path / "verdicts.csv").set_index("claim")["verdict"]
    assert words["linear momentum is zero to round-off"] == "reproduced"
    # The half-second run has not reached the end of the tractions: it has shown nothing.
    assert words["angular momentum is constant without loads"] == "in part"


# ------------------------------------------------------------------ the measures themselves
ENDED = SimpleNamespace(
    step=3,
    snapshot=lambda: SimpleNamespace(X=np.zeros((4, 3))),
    positions=SimpleNamespace(folded_since=np.nan),
)


def test_what_is_left_over_has_the_work_of_the_projection_in_it() -> None:
    table = pd.DataFrame(
        {"energy_rest [J]": [0.0, 3.0, -2.0], "work_projection [J]": [0.0, -2.5, 2.0]}
    )
    assert left_over(table) == pytest.approx([0.0, 0.5, 0.0])


@pytest.mark.parametrize(
    ("rest", "expected"),
    [(0.0, "kept"), (0.9, "kept"), (-0.9, "kept"), (1.1, "energy made"), (-1.1, "ledger open")],
)
def test_a_run_that_misses_energy_has_not_kept_it(rest: float, expected: str) -> None:
    row = outcome(ENDED, None, rest * MADE_BY_TIME, 0.0)
    assert row["outcome"] == expected
    assert row["survived"]


def test_a_lost_run_is_lost_whatever_its_ledger_says() -> None:
    failure = Diverged("negative Jacobian", 0.25, 17, 3, (0.0, 1.0, 2.0), "less")
    row = outcome(ENDED, failure, -1.0, 0.0)
    assert (row["outcome"], row["survived"], row["lost_at"]) == ("lost", False, 0.25)
