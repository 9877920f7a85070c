"""The punch study: rows and tables of runs on 11x6x2 points, claims on tables made up for it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.look.frame import HasDiverged
from studies.engine.claims import Claim
from studies.engine.results import Results, Tables
from studies.methods import B_BAR, PACKAGE, SUPG
from studies.pictures.shots import ShotFolder
from studies.punch import STUDY, cases, runs
from studies.punch.claims import claims
from studies.punch.figures import PICTURES
from studies.punch.runs import (
    CLASSICAL,
    COMPARED,
    CONSISTENT,
    DEFAULTS,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    HELD,
    INITIAL,
    OWN_OPERATOR,
    WIDE,
    WITHOUT_TAU_F,
    run_case,
    run_cost,
)
from studies.punch.tables import COST, MEASURED, RUN, tables

CELLS = 10
pytestmark = pytest.mark.filterwarnings("ignore::sphsolid.errors.FoldingWarning")


def _rows(shots: Path, reading, method, cells=CELLS):
    return run_case(
        key=f"{reading.name} {method.name} {cells}", reading=reading, method=method,
        operator=None if method in OWN_OPERATOR else CONSISTENT, cells=cells, until=COMPARED,
        shots=str(shots), shot_times=(0.005, 0.01, 0.015),
    )  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Seven methods, four of them in both readings, to 15 ms, as a run would leave them."""
    out = tmp_path_factory.mktemp("punch")
    methods = {INITIAL: (B_BAR, PACKAGE, CLASSICAL, GALERKIN, H6_NO_TAU_P, H6, H1),
               HELD: (B_BAR, PACKAGE, H6, H1)}  # fmt: skip
    rows = [
        row
        for reading, some in methods.items()
        for method in some
        for row in _rows(out / "shots", reading, method)
    ]
    rows += _rows(out / "shots", INITIAL, B_BAR, cells=2 * CELLS)
    rows += run_cost(key="cost", tau_p=0.1, cells=CELLS, repeats=2, work=1e3)
    made = tables(rows)
    STUDY.keep(out, made)
    return Results(out, made, pd.DataFrame(), {})


def _one(results: Results, reading, method) -> pd.Series:
    table = results.tables["table"]
    found = table[(table["press"] == reading.name) & (table["method"] == method.name)]
    return found.sort_values("cells").iloc[0]


def test_every_run_has_a_row_with_all_that_was_measured(results: Results) -> None:
    table = results.tables["table"]
    assert len(table) == 12
    own = table[table["method"] == PACKAGE.name]
    assert own["operator"].str.startswith("LatticeDifference").all()
    assert not own["folded"].any()
    assert set(table["lattice"]) == {"11x6x2", "21x11x3"}
    assert table["survived"].all()
    held = table[table["press"] == "held"]
    assert held[MEASURED].drop(columns="noise_late").notna().all(axis=None)
    # The punch goes down at 10 m/s, whoever computes it.
    np.testing.assert_allclose(held["top_low"], 0.5 - 10.0 * COMPARED, atol=1e-9)


def test_elements_differ_from_themselves_by_nothing_and_others_point_by_point(
    results: Results,
) -> None:
    row = _one(results, HELD, B_BAR)
    assert row["profile_same"] == row["profile_finest"] == row["top_rms"] == 0.0
    profile, coarse = results.tables["profile"], _one(results, INITIAL, H1)
    at = profile[np.isclose(profile["time"], COMPARED)].set_index("X")
    ours = at[at["key"] == coarse["key"]]["z"]
    fine = at[at["key"] == f"initial {B_BAR.name} {2 * CELLS}"]["z"]
    expected = (ours - fine.to_numpy()[::2]).abs().max()
    assert coarse["profile_finest"] == pytest.approx(expected, rel=1e-12)
    assert coarse["profile_same"] != pytest.approx(expected, rel=1e-3)


def test_the_distance_over_time_is_of_the_worse_end_of_the_range(results: Results) -> None:
    history = results.tables["history"]
    frames = [
        history[history["key"] == f"held {method.name} {CELLS}"].set_index("time [s]")
        for method in (H1, B_BAR)
    ]
    apart = (frames[0]["top_high [m]"].to_numpy() - frames[1]["top_high [m]"].to_numpy())[1:]
    # The punch holds the lower end, so all the difference is in the upper one.
    expected = np.sqrt(np.mean(apart**2))
    assert _one(results, HELD, H1)["top_rms"] == pytest.approx(expected, rel=1e-9)
    assert expected > 1e-4


def test_displacement_sph_is_the_unstabilised_mixed_method(results: Results) -> None:
    a, b = (_one(results, INITIAL, method) for method in (CLASSICAL, GALERKIN))
    assert a["top_low"] == pytest.approx(b["top_low"], abs=1e-5)
    assert a["energy_D_p"] == b["energy_D_p"] == 0.0


def test_energy_and_momentum_budgets_close(results: Results) -> None:
    table = results.tables["table"]
    supg = table[table["method"].isin([H1.name, H6.name])]
    parts = ["energy_D_p", "energy_D_J", "energy_projection", "energy_rest"]
    # What is kept, less all works, is what was supplied: nothing is missing from the table.
    np.testing.assert_allclose(supg["energy_kept"] - supg[parts].sum(axis=1), 1.0, rtol=1e-9)
    assert (supg["energy_D_p"] < 0.0).all()
    row, history = _one(results, HELD, H1), results.tables["history"]
    mine = history[history["key"] == row["key"]].sort_values("time [s]")
    change = mine["linear_momentum_z [kg m/s]"].iloc[[0, -1]].diff().iloc[-1]
    assert change == pytest.approx(row["floor_impulse"] + row["press_impulse"], rel=1e-9)


def test_pictures_come_from_the_kept_frames(results: Results) -> None:
    worth = {name for name, each in PICTURES.items() if each.is_worth_drawing(results.tables)}
    # Nothing ran with the operator as printed, nor to 30 ms: no page of empty panels.
    assert worth == {"evolution_initial", "comparison"}
    (results.out / "shots").rename(results.out / "gone")
    for name in worth:
        PICTURES[name].draw(results)
    for name in ("noise", "profile", "height"):
        STUDY.figures[name](results)
    (results.out / "gone").rename(results.out / "shots")


def test_a_run_that_diverges_is_a_result(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(runs, "simulation", lambda *_: sph.Simulation(
        runs.punch(), spacing=1.0 / CELLS, cfl=3.0, formulation=sph.PFJ()
    ))  # fmt: skip
    row = tables(_rows(tmp_path, INITIAL, H1))["table"].iloc[0]
    assert not row["survived"]
    assert 0.0 < row["diverged_at"] < COMPARED
    assert row["where"].endswith("m")
    assert row["why"]
    assert np.isnan(row["top_low"])
    assert row["J_min"] > 0.0
    found = ShotFolder(tmp_path).load(f"initial {H1.name} {CELLS}", COMPARED)
    assert isinstance(found, HasDiverged)


def test_the_full_study_covers_what_the_paper_shows(tmp_path: Path) -> None:
    listed = cases(argparse.Namespace(quick=False, cells=20, out=tmp_path))
    assert len({case.key for case in listed}) == len(listed) == 101
    given = [case.arguments for case in listed if case.run is run_case]
    assert len({each["reading"].name for each in given}) == 4
    assert {each["cells"] for each in given} == {20, 40, 60, 80}
    with pytest.raises(InputError, match="at least 10"):
        cases(argparse.Namespace(quick=True, cells=2, out=tmp_path))


def test_methods_are_the_paper_s_and_the_package_s() -> None:
    def made(method) -> sph.Simulation:
        return runs.simulation(INITIAL, method, CONSISTENT, CELLS, COMPARED)

    bare = sph.Simulation(runs.punch(), spacing=1.0 / CELLS, formulation=sph.PFJ())
    assert made(SUPG).identity() == bare.identity()
    assert made(DEFAULTS[0.2]).stabilisation.tau_p == sph.OfStep(0.2)
    paper = sph.SUPG(tau_F=0.5, xi_F=0.0, tau_p=0.1, secondary=sph.H6())
    assert made(H6).stabilisation == paper
    assert made(H1).stabilisation == sph.SUPG(tau_F=0.5, xi_F=0.1, tau_p=0.1)
    assert made(WITHOUT_TAU_F[0.1]).stabilisation == sph.SUPG(tau_F=0.0, xi_F=0.1, tau_p=0.1)
    for method in (H1, H6, CLASSICAL, GALERKIN, WIDE):
        assert made(method).integrator == sph.TVDRK2()
        assert dict(method.recipe.options)["cfl"] == 0.3
    wide = made(WIDE)
    assert wide.stabilisation == paper
    assert wide.cloud.smoothing.support * wide.cloud.h == pytest.approx(2.0 / CELLS)


# A world in which the paper is right in everything.
NOISE = {
    CLASSICAL: 0.4, GALERKIN: 0.4, H6_NO_TAU_P: 0.3, H6: 0.05, H1: 0.05, SUPG: 0.05,
    WITHOUT_TAU_F[0.0]: 0.4, WITHOUT_TAU_F[0.1]: 0.05, B_BAR: 0.1,
}  # fmt: skip
RANGES = {"initial": (0.455, 0.541), "held": (0.350, 0.744)}


def _table(**changes: dict[tuple[str, Any], Any]) -> pd.DataFrame:
    """One run a method and reading; ``changes``: column to ``{(reading, method): value}``."""
    rows = []
    for press, (low, high) in RANGES.items():
        for method, noise in NOISE.items():
            rows.append(
                dict.fromkeys([*RUN, *MEASURED], 0.0) | {
                    "key": f"{press} {method.name}", "press": press, "method": method.name,
                    "operator": "" if method == B_BAR else CONSISTENT.name, "lattice": "21x11x3",
                    "cells": 20, "until": 0.03, "noise_mean": noise, "top_low": low,
                    "top_high": high, "pressure_1": -3e6, "pressure_99": 2e6, "energy_kept": 0.9,
                    "survived": method != B_BAR or press == "initial", "diverged_at": 0.02,
                    "folded": False, "folded_at": float("nan"),
                }
            )  # fmt: skip
    table = pd.DataFrame(rows)
    for column, values in changes.items():
        for (press, method), value in values.items():
            which = (table["press"] == press) & (table["method"] == method.name)
            table.loc[which, column] = value
    return table


def _claim(start: str, table: pd.DataFrame, terms_ratio: float = 6.0) -> Claim:
    cost = pd.DataFrame([dict.fromkeys(COST, 1.0) | {"terms_ratio": terms_ratio}])
    made: Tables = {"table": table, "cost": cost}
    (found,) = [claim for claim in claims(made) if claim.what.startswith(start)]
    return found


@pytest.mark.parametrize(
    "claim",
    ["displacement SPH", "they are still there", "with tau_p = 0.1 dt", "it is tau_p",
     "H1 and H6 agree", "the SUPG terms", "extremely large distortions"],
)  # fmt: skip
def test_a_world_as_in_the_paper_is_reproduced(claim: str) -> None:
    assert _claim(claim, _table()).verdict == "reproduced"


@pytest.mark.parametrize(
    ("claim", "changes", "expected"),
    [
        ("displacement SPH", {"noise_mean": {("held", CLASSICAL): 0.14}}, "in part"),
        (
            "displacement SPH",
            {"noise_mean": {("held", CLASSICAL): 0.1, ("initial", CLASSICAL): 0.1}}, "not",
        ),
        ("they are still there", {"noise_mean": {("initial", H6_NO_TAU_P): 0.06}}, "in part"),
        ("with tau_p = 0.1 dt", {"noise_mean": {("initial", H6): 0.11}}, "not"),
        # No fluctuations without tau_p: none are removed.
        ("it is tau_p", {"noise_mean": {("initial", H6_NO_TAU_P): 0.14}}, "in part"),
        (
            "it is tau_p",
            {"noise_mean": {("initial", H6): 0.2, ("initial", WITHOUT_TAU_F[0.1]): 0.3}}, "not",
        ),
        ("H1 and H6 agree", {"top_high": {("held", H1): 0.7485}}, "in part"),
        ("H1 and H6 agree", {"noise_mean": {("held", H1): 0.0625}}, "in part"),
        ("H1 and H6 agree", {"noise_mean": {("held", H1): 0.04}}, "in part"),
        ("H1 and H6 agree", {"top_high": {("held", H1): float("nan")}}, "in part"),
        (
            "H1 and H6 agree",
            {"top_high": {("held", H1): 0.7485}, "pressure_1": {("initial", H1): -3.3e6}}, "not",
        ),
        ("extremely large", {"survived": {("held", B_BAR): True}}, "in part"),
        ("extremely large", {"survived": {("held", B_BAR): True, ("held", H1): False}}, "not"),
        # Folded after the instant of the other claims, and before it.
        (
            "extremely large",
            {"folded": {("held", H1): True}, "folded_at": {("held", H1): 0.02}}, "in part",
        ),
        (
            "H1 and H6 agree",
            {"folded": {("held", H1): True}, "folded_at": {("held", H1): 0.01}}, "in part",
        ),
        (
            "with tau_p",
            {"folded": {("initial", H6): True}, "folded_at": {("initial", H6): 0.01}}, "not",
        ),
    ],
)  # fmt: skip
def test_a_claim_that_fails_is_said_to(claim: str, changes: Any, expected: str) -> None:
    verdict = _claim(claim, _table(**changes)).verdict
    assert verdict == {"in part": "reproduced in part", "not": "not reproduced"}[expected]


@pytest.mark.parametrize("ratio", [4.9, 7.1])
def test_six_times_is_measured(ratio: float) -> None:
    assert _claim("the SUPG terms", _table(), ratio).verdict == "not reproduced"


@pytest.mark.parametrize(
    ("heights", "expected"),
    [({}, "met"), ({H6: 0.4595}, "met in part"), ({H6: 0.46, H1: 0.46, SUPG: 0.46}, "not met")],
)
def test_the_top_face_is_held_against_three_references(heights: Any, expected: str) -> None:
    table = _table(top_low={("initial", method): z for method, z in heights.items()})
    for reference in ("B-bar of the same lattice", "B-bar 21x11x3", "an independent"):
        start = f"initial, coarsest lattice: range of the top face at 15 ms as {reference}"
        claim = _claim(start, table)
        assert claim.verdict == expected
    if expected == "met in part":
        assert claim.shown.endswith(f"4.5 mm ({H6.name})")


def test_what_has_not_run_is_not_claimed() -> None:
    assert _claim("SUPG-SPH is more accurate than JST", _table()).verdict == "not examined"
    table = _table()
    only = table[table["method"] == B_BAR.name]
    for claim in claims({"table": only, "cost": pd.DataFrame(columns=COST)}):
        assert claim.verdict not in ("reproduced", "met")


@pytest.mark.parametrize(
    ("changes", "verdicts"),
    [
        ({}, ["met"] * 7),
        ({"folded": {("held", PACKAGE): True}, "folded_at": {("held", PACKAGE): 0.01}},
         ["met in part", *["met"] * 3, *["not met"] * 3]),
        ({"top_low": {("initial", PACKAGE): 0.4595}},
         ["met", *["not met"] * 3, *["met"] * 3]),
        ({"survived": {("initial", PACKAGE): False}}, ["met in part", *["met"] * 6]),
    ],
)  # fmt: skip
def test_the_default_is_judged_apart_from_the_mixed_methods(
    changes: Any, verdicts: list[str]
) -> None:
    table = _table()
    of_default = table[table["method"] == SUPG.name].assign(
        method=PACKAGE.name, operator="LatticeDifference4", key="of the default"
    )
    table = pd.concat([table, of_default], ignore_index=True)
    for column, values in changes.items():
        for (press, method), value in values.items():
            which = (table["press"] == press) & (table["method"] == method.name)
            table.loc[which, column] = value
    made: Tables = {"table": table, "cost": pd.DataFrame(columns=COST)}
    found = claims(made)
    own = [claim for claim in found if claim.where == PACKAGE.name]
    assert [c.verdict for c in own if c.comparison != "reported"] == verdicts
    (noise,) = [claim for claim in own if claim.comparison == "reported"]
    assert noise.measured == pytest.approx({"initial": 0.5, "held": 0.5})
    others = [claim.what for claim in claims({"table": _table(), "cost": made["cost"]})]
    assert [claim.what for claim in found if claim.where != PACKAGE.name] == others
