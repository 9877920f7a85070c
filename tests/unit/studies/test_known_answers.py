"""The study of known answers: verdicts on made-up tables, and a tiny run."""

from __future__ import annotations

import argparse

import pandas as pd
import pytest

from studies.known_answers import STUDY, claims, run_bending, run_cable, tables
from studies.methods import B_BAR


def rows(order, peak, folded=""):
    """A cable that converges with ``order`` in every field, a column that peaks at ``peak``.

    ``folded`` names the load of a cable, or the column, whose positions folded.
    """
    made = [
        {"scene": "cable", "load": load, "method": "m", "field": field, "h": h,
         "error": h**order, "wall_stress": 0.0, "wall_s": 1.0, "folded": load == folded,
         "folded_at": 0.0}
        for load in ("pulse", "step") for field in ("p", "P", "u") for h in (0.5, 0.25)
    ]  # fmt: skip
    column = {"scene": "bending column", "method": "m", "time": 0.45, "wall_s": 1.0}
    column |= {"folded": folded == "column", "folded_at": 0.0}
    return [*made, column | {"h": 0.25, "peak": 2.0}, column | {"h": 0.125, "peak": peak}]


def verdicts(*given):
    """By what was asked; what is only reported is left out."""
    found = claims(tables(rows(*given)))
    return {claim.what: claim.verdict for claim in found if claim.comparison != "reported"}


@pytest.mark.parametrize(
    ("order", "peak", "met"),
    [(2.0, 2.99, ["met", "met", "met"]), (1.0, 3.2, ["not met", "met", "not met"]),
     (0.5, 2.95, ["not met", "not met", "met"])],
)  # fmt: skip
def test_verdicts(order, peak, met):
    assert list(verdicts(order, peak).values()) == met
    assert claims(tables(rows(order, peak)))[0].measured == pytest.approx(order)


@pytest.mark.parametrize("folded", ["pulse", "step", "column"])
def test_nothing_is_met_by_a_run_that_folded(folded):
    for what, verdict in verdicts(2.0, 2.99, folded).items():
        assert verdict == ("not met" if folded in what else "met"), what


def test_every_case_is_one_of_its_own():
    for quick in (True, False):
        listed = STUDY.cases(argparse.Namespace(quick=quick))
        assert len({case.key for case in listed}) == len(listed)


def test_a_cable_and_a_column_give_their_rows():
    cable = pd.DataFrame(run_cable(method=B_BAR, load="step", cells=2))
    assert cable["field"].tolist() == ["p", "P", "u"]
    assert cable["error"].between(1e-4, 0.6).all()
    assert cable["wall_stress"].iloc[0] < 0.02
    [column] = run_bending(method=B_BAR, cells=2)
    assert column["peak"] == pytest.approx(2.989, rel=0.03)
    assert 0.4 < column["time"] < 0.5
