"""Each verdict of the punch study can be reached, from tables made up for it."""

from __future__ import annotations

from typing import Any

import pandas as pd
import pytest

from studies.punch.methods import (
    DISPLACEMENT,
    FEM,
    GALERKIN,
    H1,
    H6,
    H6_NO_TAU_P,
    TOOLKIT,
    without_tau_F,
)
from studies.punch.tables import COST, MEASURED, RUN
from studies.punch.verdicts import Verdict, of_parts, verdict_table, verdicts

#: A world in which the paper is right in everything.
NOISE = {
    DISPLACEMENT: 0.4, GALERKIN: 0.4, H6_NO_TAU_P: 0.3, H6: 0.05, H1: 0.05, TOOLKIT: 0.05,
    without_tau_F(0.0): 0.4, without_tau_F(0.1): 0.05, FEM: 0.1,
}  # fmt: skip
RANGES = {"initial": (0.455, 0.541), "held": (0.350, 0.744)}


def _table(**changes: dict[tuple[str, str], Any]) -> pd.DataFrame:
    """One run a method and reading; ``changes``: column to ``{(press, method): value}``."""
    rows = []
    for press, (low, high) in RANGES.items():
        for method, noise in NOISE.items():
            row: dict[str, Any] = dict.fromkeys([*RUN, *MEASURED], 0.0) | {
                "key": f"{press} {method}", "press": press, "method": method,
                "operator": "-" if method == FEM else "Consistent", "lattice": "21x11x3",
                "cells": 20, "until": 0.03, "noise_mean": noise, "top_low": low,
                "top_high": high, "pressure_1": -3e6, "pressure_99": 2e6, "energy_kept": 0.9,
                "survived": method != FEM or press == "initial", "lost_at": 0.02,
                "folded": False, "folded_at": float("nan"),
            }  # fmt: skip
            rows.append(row)
    table = pd.DataFrame(rows)
    for column, values in changes.items():
        for (press, method), value in values.items():
            table.loc[(table["press"] == press) & (table["method"] == method), column] = value
    return table


def _verdicts(table: pd.DataFrame, terms_ratio: float = 6.0) -> dict[str, Verdict]:
    cost = pd.DataFrame([dict.fromkeys(COST, 1.0) | {"terms_ratio": terms_ratio}])
    return {v.claim.split(" (")[0]: v for v in verdicts({"table": table, "cost": cost})}


def _of(found: dict[str, Verdict], start: str) -> str:
    (verdict,) = [v.verdict for claim, v in found.items() if claim.startswith(start)]
    return verdict


CLAIMS = [
    "displacement SPH", "they are still there", "with tau_p = 0.1 dt", "it is tau_p",
    "H1 and H6 agree", "the SUPG terms", "extremely large distortions",
]  # fmt: skip


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_world_as_in_the_paper_is_reproduced(claim: str) -> None:
    assert _of(_verdicts(_table()), claim) == "reproduced"


@pytest.mark.parametrize(
    ("claim", "changes", "expected"),
    [
        ("displacement SPH", {"noise_mean": {("held", DISPLACEMENT): 0.14}}, "in part"),
        (
            "displacement SPH",
            {"noise_mean": {("held", DISPLACEMENT): 0.1, ("initial", DISPLACEMENT): 0.1}},
            "not",
        ),
        ("they are still there", {"noise_mean": {("initial", H6_NO_TAU_P): 0.06}}, "in part"),
        ("with tau_p = 0.1 dt", {"noise_mean": {("initial", H6): 0.11}}, "not"),
        ("it is tau_p", {"noise_mean": {("initial", H6_NO_TAU_P): 0.06}}, "in part"),
        (
            "it is tau_p",
            {"noise_mean": {("initial", H6): 0.2, ("initial", without_tau_F(0.1)): 0.3}},
            "not",
        ),
        ("H1 and H6 agree", {"top_high": {("held", H1): 0.7485}}, "in part"),
        ("H1 and H6 agree", {"noise_mean": {("held", H1): 0.0625}}, "in part"),
        (
            "H1 and H6 agree",
            {"top_high": {("held", H1): 0.7485}, "pressure_1": {("initial", H1): -3.3e6}},
            "not",
        ),
        ("extremely large distortions", {"survived": {("held", FEM): True}}, "in part"),
        (
            "extremely large distortions",
            {"survived": {("held", FEM): True, ("held", H1): False}},
            "not",
        ),
        # After the instant of the other claims, and before it.
        (
            "extremely large distortions",
            {"folded": {("held", H1): True}, "folded_at": {("held", H1): 0.02}},
            "in part",
        ),
        (
            "H1 and H6 agree",
            {"folded": {("held", H1): True}, "folded_at": {("held", H1): 0.01}},
            "in part",
        ),
        (
            "with tau_p",
            {"folded": {("initial", H6): True}, "folded_at": {("initial", H6): 0.01}},
            "not",
        ),
    ],
)
def test_a_claim_that_fails_is_said_to(
    claim: str, changes: dict[str, dict[tuple[str, str], Any]], expected: str
) -> None:
    verdict = _of(_verdicts(_table(**changes)), claim)
    assert verdict == {"in part": "reproduced in part", "not": "not reproduced"}[expected]


@pytest.mark.parametrize(("ratio", "expected"), [(4.9, "not reproduced"), (7.1, "not reproduced")])
def test_six_times_is_measured(ratio: float, expected: str) -> None:
    assert _of(_verdicts(_table(), ratio), "the SUPG terms") == expected


@pytest.mark.parametrize(
    ("heights", "expected"),
    [({}, "met"), ({H6: 0.4595}, "met in part"), ({H6: 0.46, H1: 0.46, TOOLKIT: 0.46}, "not met")],
)
def test_the_top_face_is_held_against_three_references(
    heights: dict[str, float], expected: str
) -> None:
    found = _verdicts(_table(top_low={("initial", m): z for m, z in heights.items()}))
    for reference in ("B-bar of the same lattice", "B-bar 21x11x3", "an independent"):
        start = f"initial, coarsest lattice: range of the top face at 15 ms as {reference}"
        assert _of(found, start) == expected


def test_the_worst_method_is_named() -> None:
    found = _verdicts(_table(top_low={("initial", TOOLKIT): 0.4612}))
    verdict = found["initial, coarsest lattice: range of the top face at 15 ms as B-bar 21x11x3"]
    assert verdict.measured == f"0.0 mm ({min(H6, H1)}) to 6.2 mm ({TOOLKIT})"


def test_jst_is_not_judged() -> None:
    assert _of(_verdicts(_table()), "SUPG-SPH is more accurate than JST-SPH") == "not examined"


def test_runs_that_are_missing_leave_no_verdict_made_up() -> None:
    table = _table()
    cost = pd.DataFrame(columns=COST)
    only = table[table["method"] == FEM]
    for verdict in verdicts({"table": only, "cost": cost}):
        assert verdict.verdict not in ("reproduced", "met")


def test_the_table_of_verdicts_has_a_row_each() -> None:
    cost = pd.DataFrame(columns=COST)
    frame = verdict_table({"table": _table(), "cost": cost}).frame
    assert list(frame.columns) == ["claim", "measured (threshold)", "verdict"]
    assert len(frame) == len(list(verdicts({"table": _table(), "cost": cost})))


def test_all_some_none() -> None:
    assert of_parts(True, True) == "reproduced"
    assert of_parts(True, False) == "reproduced in part"
    assert of_parts(False) == "not reproduced"
