"""Claims of the conservation study on made-up tables, and the study on a handful of particles."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from sphsolid import PFHJ, PFJ, SSPRK3, TVDRK2, PositionVerlet
from sphsolid.errors import Diverged
from sphsolid.recommendation import recommend_supg
from sphsolid.scenes import l_shaped_block
from studies import conservation
from studies.conservation import CFLS, CONSISTENT, H1, OPERATORS, SPACINGS, bare, paper
from studies.conservation.claims import claims, orders, undeformed_impulse
from studies.conservation.runs import (
    MADE_BY_TIME,
    Block,
    Body,
    Cube,
    ended,
    given_back,
    left_over,
)
from studies.engine.study import main
from studies.measures.run import Ran
from studies.methods import B_BAR, PACKAGE, SUPG

GOOD = {
    "group": "paper", "method": paper().name, "formulation": "{p,F}", "secondary": "H6",
    "spacing": 0.85, "cfl": 0.3, "survived": True, "folded": False, "folded_at": math.nan,
    "outcome": "kept", "linear": 1e-15, "angular_free": 1e-15, "impulse_gap": 1e-16, "noise": 0.2,
    "load": 1.0, "L_x": 0.0, "L_y": 0.0, "L_z": 0.0,
}  # fmt: skip
ELEMENTS = GOOD | {"group": "elements", "method": B_BAR.name, "formulation": "", "secondary": ""}
GOOD_CUBE = {
    "group": "ladder", "method": paper(H1, CONSISTENT).name, "formulation": "{p,F}",
    "integrator": "TVD-RK2", "projection": "local", "spacing": 0.25, "cfl": 0.3, "spin": 105.0,
    "survived": True, "folded": False, "folded_at": math.nan, "outcome": "kept", "residual": 1e-7,
    "left_over": 1e-7, "angular_total": 1e-15, "linear_total": 1e-15,
}  # fmt: skip
NOTHING = pd.DataFrame(columns=list(GOOD_CUBE))
FREE = pd.DataFrame(columns=["shape", "cloud", "outcome", "linear_drift", "angular_drift"])
LINEAR = "linear momentum is zero to round-off"
ANGULAR = "angular momentum is constant without loads"
LASTED = "runs to 20 s with its energy, every combination"
SMOOTH = "pressure is smooth: noise over that of B-bar"


def runs(*rows: dict[str, Any]) -> pd.DataFrame:
    """Runs of the block, good ones of the paper's setting where nothing else is said."""
    return pd.DataFrame([GOOD | row for row in rows], columns=list(GOOD))


def cubes(*rows: dict[str, Any]) -> pd.DataFrame:
    return pd.DataFrame([GOOD_CUBE | row for row in rows])


def judged(table: pd.DataFrame, cube: pd.DataFrame = NOTHING) -> dict[str, str]:
    found = claims({"table": table, "cube": cube, "bodies": FREE, "orders": orders(cube)})
    return {claim.what: claim.verdict for claim in found}


@pytest.mark.parametrize(("column", "claim"), [("linear", LINEAR), ("angular_free", ANGULAR)])
@pytest.mark.parametrize(
    ("drifts", "verdict"),
    [
        ((1e-15, 9e-13), "reproduced"),
        ((1e-15, 2e-12), "reproduced in part"),
        ((1e-3, 2e-12), "not reproduced"),
    ],
)
def test_momentum_is_judged_by_every_run(column, claim, drifts, verdict):
    table = runs(*({column: drift, "spacing": k} for k, drift in enumerate(drifts, 1)))
    assert judged(table)[claim] == verdict
    [found] = [one for one in claims({"table": table, "cube": NOTHING, "bodies": FREE,
                                      "orders": NOTHING}) if one.what == claim]  # fmt: skip
    assert found.shown == f"{max(drifts):.1e}"
    assert f"spacing {1 + drifts.index(max(drifts))} m" in found.where


def test_a_run_that_diverged_has_shown_nothing():
    """Its numbers are those of the time before, or missing."""
    gone = {"survived": False, "outcome": "diverged"}
    found = judged(runs({}, gone | {"angular_free": math.nan, "linear": 1e-16}))
    assert [found[what] for what in (ANGULAR, LINEAR, LASTED)] == ["reproduced in part"] * 3
    assert judged(runs(gone))[LASTED] == "not reproduced"


def test_a_run_that_folded_has_shown_nothing():
    """Momentum is that of the body it was, energy may be kept, and it is no body any more."""
    folded = {"folded": True, "folded_at": 3.0, "outcome": "folded"}
    found = judged(runs({}, folded))
    assert found[LINEAR] == found[LASTED] == "reproduced in part"
    assert judged(runs(ELEMENTS, folded))[SMOOTH] == "not reproduced"


def test_a_run_that_made_energy_did_not_survive_in_earnest():
    assert judged(runs({}, {"outcome": "energy made"}))[LASTED] == "reproduced in part"


@pytest.mark.parametrize(("drift", "verdict"), [(1e-4, "reproduced"), (1e-9, "not reproduced")])
def test_the_contrast_needs_a_drift(drift, verdict):
    table = runs({}, {"group": "no projection", "angular_free": drift})
    assert judged(table)["without the projection it is not"] == verdict


@pytest.mark.parametrize(
    ("noise", "verdict"),
    [(0.19, "reproduced"), (0.39, "reproduced in part"), (0.41, "not reproduced")],
)
@pytest.mark.parametrize("group", ["paper", "package"])
def test_pressure_is_compared_on_the_same_mesh(noise, verdict, group):
    own = {"noise": noise, "group": group}
    own |= {"method": SUPG.name, "secondary": "H1"} if group == "package" else {}
    elements = [ELEMENTS | {"noise": value, "spacing": h} for value, h in ((0.1, 0.85), (9.0, 0.5))]
    assert judged(runs(own, *elements))[SMOOTH] == verdict


@pytest.mark.parametrize(("gap", "verdict"), [(1e-11, "met"), (1e-9, "not met")])
def test_the_impulse_must_agree(gap, verdict):
    found = judged(runs({"impulse_gap": gap}))
    assert found["angular momentum at 5 s is the applied impulse"] == verdict


@pytest.mark.parametrize(("off", "verdict"), [(1e-4, "met"), (1e-2, "not met")])
def test_a_small_load_meets_the_undeformed_arms(off, verdict):
    L = dict(zip(("L_x", "L_y", "L_z"), (1.0 + off) * undeformed_impulse(1e-3), strict=True))
    found = judged(runs({"group": "small load", "load": 1e-3} | L))
    assert found["a thousandth of the load: the undeformed-arm impulse"] == verdict


def test_the_undeformed_impulse_is_that_of_the_scene():
    """Sum of ``X x t_B`` over the loaded faces and over time, by brute force."""
    scene = l_shaped_block(jitter=0.0)
    mesh = scene.body.mesh(0.5)
    times = np.linspace(0.0, 5.0, 401)
    total = np.zeros(3)
    for traction in scene.tractions:
        quads = mesh.vertices[mesh.face(traction.face)]
        centres = quads.mean(axis=1)
        pull = np.stack([traction.value(centres, centres, t) for t in times])
        impulse = np.trapezoid(pull, times, axis=0)
        total += 9.0 / len(quads) * np.cross(centres, impulse).sum(axis=0)
    np.testing.assert_allclose(total, undeformed_impulse(), rtol=1e-5)
    np.testing.assert_allclose(undeformed_impulse(), [-2.15e5, -1.14e5, 1.48e5], rtol=5e-3)


def test_orders_of_the_residual():
    cube = cubes(
        *({"cfl": cfl, "residual": 5.0 * cfl**3} for cfl in (0.3, 0.15, 0.075)),
        *({"cfl": cfl, "residual": 2.0 * cfl, "method": "printed"} for cfl in (0.3, 0.15)),
        {"cfl": 0.6, "residual": 1.0, "outcome": "energy made"},
    )
    fitted = orders(cube).set_index("method")["order"]
    assert fitted.tolist() == pytest.approx([3.0, 1.0])
    what = "cube: the residual falls as dt^2 or faster"
    assert judged(runs(), cube)[what] == "not met"
    assert judged(runs(), cube[cube["method"] != "printed"])[what] == "met"


def test_an_order_is_fitted_to_every_run():
    cube = cubes(
        {"cfl": 0.8, "residual": 1.0, "left_over": 0.25},
        {"cfl": 0.4, "residual": 1.0, "left_over": 1.0},
        {"cfl": 0.2, "residual": 0.25, "left_over": 1.0},
    )
    fitted = orders(cube).iloc[0]
    assert fitted["order"] == pytest.approx(1.0)
    assert fitted["order_left_over"] == pytest.approx(-1.0)


@pytest.mark.parametrize(("residual", "verdict"), [(9e-7, "met"), (2e-6, "not met")])
def test_the_energy_budget_is_judged_at_the_finest_run_that_kept_it(residual, verdict):
    cube = cubes(
        {"spacing": 0.25, "residual": 1e-3}, {"spacing": 0.125, "residual": residual},
        {"spacing": 0.0625, "residual": 1.0, "outcome": "energy made"},
    )  # fmt: skip
    assert judged(runs(), cube)["cube: energy budget closes at CFL 0.3 (finest run)"] == verdict


def test_momenta_of_the_cube_count_in_every_projected_run():
    what = "cube: angular momentum kept for ten turns"
    free = {"group": "no projection", "projection": "none", "angular_total": 1e-2}
    assert judged(runs(), cubes({}, free))[what] == "met"
    assert judged(runs(), cubes({}, {"angular_total": 2e-12}))[what] == "met in part"
    assert judged(runs(), cubes({"angular_total": 2e-12}))[what] == "not met"


def test_the_whole_study_holds_every_combination_once():
    listed = [*conservation.blocks(), *conservation.cubes()]
    assert len({one.key for one in listed}) == len(listed)
    asked = {one.key for one in listed}
    for formulation in conservation.FORMULATIONS:
        for secondary in (H1, conservation.H6):
            for operator in OPERATORS:
                method = paper(secondary, operator, formulation)
                for spacing in SPACINGS:
                    assert Block("", method, spacing).key in asked
                assert Block("", bare(method)).key in asked
    for integrator in (TVDRK2(), SSPRK3(), PositionVerlet()):
        method = paper(H1, CONSISTENT)
        method = method if integrator == TVDRK2() else method.but(integrator=integrator)
        assert {Cube("", method, cfl=cfl).key for cfl in CFLS} <= asked


@pytest.mark.parametrize("formulation", [PFJ(), PFHJ()])
def test_self_adjoint_supg_has_its_name_where_it_is_chosen(formulation):
    scene = l_shaped_block()
    assert conservation.package(scene, recommend_supg(scene).formulation) is SUPG
    assert formulation.name in conservation.package(scene, formulation).name


def small(options: argparse.Namespace) -> list[Any]:
    """Both scenes by both solvers on a few particles; the paper's runs with frames."""
    long = (paper(), paper(operator=CONSISTENT), B_BAR, SUPG, PACKAGE)
    groups = ("paper", "paper", "elements", "package", "default")
    listed: list[Any] = [
        Block(group, method, 1.5, pictured=True) for group, method in zip(groups, long, strict=True)
    ]
    listed.append(Block("paper", paper(H1, CONSISTENT, PFHJ()), 1.5, until=0.5))
    cubes = {"ladder": paper(H1, CONSISTENT), "elements": B_BAR, "package": SUPG,
             "default": PACKAGE}  # fmt: skip
    for group, method in cubes.items():
        listed.append(Cube(group, method, 0.5, turns=0.25))
    listed.append(Body("default", PACKAGE, "cube", "lattice"))
    return [conservation.case_of(one, options.out) for one in listed]


def test_a_small_study_runs_from_command_line_to_report(tmp_path: Path):
    study = dataclasses.replace(conservation.STUDY, cases=small, warm_up=lambda options: [])
    assert main(study, ["--out", str(tmp_path), "--jobs", "1"]) == 0
    for name in ("momenta", "drift", "budget", "cube", "sequence_1"):
        (made,) = (tmp_path / "figures").glob(f"{name}.*")
        assert made.stat().st_size > 0
    assert (tmp_path / "report.pdf").stat().st_size > 0
    assert json.loads((tmp_path / "run.json").read_text())["cases_failed"] == 0
    table = pd.read_csv(tmp_path / "table.csv")
    whole = table[table["until"] == 20.0]
    assert (whole["survived"]).all()
    assert (whole[["linear", "angular_free", "angular_step"]] < 1e-12).all(axis=None)
    assert (whole["impulse_gap"] < 1e-12).all()
    assert (whole["left_over"].abs() < 1e-3).all()
    mine = table[table["method"] == SUPG.name].iloc[0]
    assert (mine["integrator"], mine["weighting"]) == ("position Verlet", "self-adjoint")
    cube = pd.read_csv(tmp_path / "cube.csv")
    assert (cube["angular_total"] < 1e-12).all()
    # Lumped masses at eight corners and the points between: 1 + 2 h^2 times the exact cube.
    nodal = cube[cube["method"] != PACKAGE.name]
    np.testing.assert_allclose(nodal["L_z"], 19250.0 * 1.5, rtol=1e-12)
    bodies = pd.read_csv(tmp_path / "bodies.csv")
    assert bodies["outcome"].tolist() == ["kept"]
    assert (bodies[["linear_drift", "angular_drift"]] < 1e-12).all(axis=None)
    verdicts = pd.read_csv(tmp_path / "claims.csv").set_index("claim")["verdict"]
    assert verdicts[LINEAR] == "reproduced"
    # The half-second run has not reached the end of the tractions: it has shown nothing.
    assert verdicts[ANGULAR] == "reproduced in part"


def of_default(drift=1e-15, back=0.0, outcome="kept"):
    """Claims of the default alone, on a block, a cube and two free bodies."""
    own = {"group": "default", "method": PACKAGE.name, "secondary": "", "given_back": back}
    table = pd.DataFrame([GOOD | own | {"linear": drift, "angular_free": drift}])
    cube = pd.DataFrame([GOOD_CUBE | own | {"linear_total": drift, "angular_total": drift}])
    bodies = pd.DataFrame(
        [{"shape": "cube", "cloud": cloud, "outcome": outcome, "linear_drift": 1e-15,
          "angular_drift": value} for cloud, value in (("lattice", 1e-15), ("tet", drift))]
    )  # fmt: skip
    made = {"table": table, "cube": cube, "bodies": bodies, "orders": orders(cube)}
    return {claim.what: claim.verdict for claim in claims(made)}


@pytest.mark.parametrize(
    ("change", "word", "count", "verdict"),
    [({"drift": 2e-12}, "linear momentum", 2, "not met"),
     ({"drift": 2e-12}, "angular momentum", 2, "not met"),
     ({"drift": 2e-12}, "momenta of free", 1, "met in part"),
     ({"back": 2e-12}, "takes energy", 2, "not met"),
     ({"outcome": "folded"}, "momenta of free", 1, "not met")],
)  # fmt: skip
def test_the_default_must_keep_both_momenta_of_every_body(change, word, count, verdict):
    def own(found):
        return {
            what: said for what, said in found.items()
            if word in what and (what.startswith(PACKAGE.name) or "free bodies" in what)
            and "impulse" not in what
        }  # fmt: skip

    assert set(own(of_default()).values()) == {"met"}
    changed = own(of_default(**change))
    assert len(changed) == count
    assert set(changed.values()) == {verdict}


def test_claims_of_the_paper_do_not_rest_on_the_default():
    bad = {"group": "default", "method": PACKAGE.name, "linear": 1.0, "angular_free": 1.0,
           "outcome": "folded", "folded": True, "given_back": 0.0}  # fmt: skip
    found = judged(runs({}), NOTHING)
    table = pd.DataFrame([GOOD | {"given_back": 0.0}, GOOD | bad])
    assert found.items() <= judged(table, NOTHING).items()


# ------------------------------------------------------------------ the measures themselves
def test_what_a_restraint_gave_back_is_the_largest_rise_between_records():
    history = pd.DataFrame({"dissipation_restraint [J]": [0.0, -2.0, -1.5, -4.0]})
    assert given_back(history) == pytest.approx(0.5)
    assert given_back(history[:2]) == 0.0
    assert given_back(pd.DataFrame({"a": [1.0, 2.0]})) == 0.0


def test_what_is_left_over_has_the_work_of_the_projection_in_it():
    history = pd.DataFrame(
        {"energy_rest [J]": [0.0, 3.0, -2.0], "work_projection [J]": [0.0, -2.5, 2.0]}
    )
    assert left_over(history) == pytest.approx([0.0, 0.5, 0.0])


def ran(diverged: Diverged | None = None, *, folded: bool = False) -> Ran:
    return Ran(pd.DataFrame(), diverged, 3, 1.0, 1.0, folded, 0.5 if folded else math.nan)


@pytest.mark.parametrize(
    ("missed", "expected"),
    [(0.0, "kept"), (0.9, "kept"), (-0.9, "kept"), (1.1, "energy made"), (-1.1, "energy missing")],
)
def test_a_run_that_misses_energy_has_not_kept_it(missed, expected):
    row = ended(ran(), missed * MADE_BY_TIME)
    assert row["outcome"] == expected
    assert row["survived"]


def test_how_a_run_ended_does_not_depend_on_its_energy_alone():
    failure = Diverged("negative Jacobian", 0.25, 17, 3, (0.0, 1.0, 2.0), "less")
    row = ended(ran(failure, folded=True), -1.0)
    assert (row["outcome"], row["survived"], row["diverged_at"]) == ("diverged", False, 0.25)
    assert ended(ran(folded=True), -1.0)["outcome"] == "folded"
