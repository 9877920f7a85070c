"""Verdicts: what holds, what holds in part, what nothing was run for."""

from __future__ import annotations

import math

import pytest

from sphsolid.errors import InputError
from studies.engine.claims import FIRST, Claim, claims_table


def verdict(measured, comparison, asked=math.nan, **more):
    return Claim("it", measured, comparison, asked, **more).verdict


@pytest.mark.parametrize(
    ("measured", "comparison", "asked", "holds"),
    [
        (1.0, "<=", 1.0, True), (1.0, "<", 1.0, False), (1.0, ">=", 1.0, True),
        (1.0, ">", 1.0, False), (0.9, "<", 1.0, True), (1.1, ">", 1.0, True),
        (1.0, "within", (1.0, 2.0), True), (2.1, "within", (1.0, 2.0), False),
        (math.nan, "<=", 1.0, False), (math.nan, "within", (0.0, 1.0), False),
        ({"a": 1.0, "b": 2.0}, "<=", {"a": 1.0, "b": 2.0}, True),
        ({"a": 1.0, "b": 1.0}, "within", (0.0, 2.0), True),
    ],
)  # fmt: skip
def test_a_number_holds_or_not(measured, comparison, asked, holds):
    assert verdict(measured, comparison, asked) == ("met" if holds else "not met")
    of_paper = verdict(measured, comparison, asked, source="paper")
    assert of_paper == ("reproduced" if holds else "not reproduced")


def test_some_of_it_may_hold():
    two = {"a": 1.0, "b": 3.0}
    assert verdict(two, "<=", 2.0) == "met in part"
    assert verdict(two, "<=", 0.5) == "not met"
    assert verdict({"a": 1.0, "b": math.nan}, "<=", 2.0) == "met in part"
    assert verdict({}, "<=", 2.0) == "not examined"
    assert verdict(3.0, "<=", 2.0, in_part=4.0) == "met in part"
    assert verdict(5.0, "<=", 2.0, in_part=4.0) == "not met"
    assert verdict(1.0, "<=", 2.0, incomplete="no finest level") == "met in part"
    assert verdict(3.0, "<=", 2.0, incomplete="no finest level") == "not met"
    assert verdict(3.0, "reported") == "reported"


def test_a_run_that_folded_shows_nothing():
    assert verdict(1.0, "<=", 2.0, sound=False) == "not met"
    assert verdict(3.0, "<=", 2.0, sound=False, in_part=4.0) == "not met"
    two = {"a": 1.0, "b": 1.0}
    assert verdict(two, "<=", 2.0, sound={"a": True, "b": False}) == "met in part"


def test_counted():
    assert [Claim.counted("c", n, 3).verdict for n in range(4)] == [
        "not met", "met in part", "met in part", "met"
    ]  # fmt: skip
    assert Claim.counted("c", 2, 3).shown == "2 of 3"
    assert Claim.counted("c", 2, 3, source="paper", said="two").verdict == "reproduced in part"
    assert Claim.counted("c", 0, 0).verdict == "not examined"


@pytest.mark.parametrize(
    ("claim", "shown", "limit"),
    [
        (Claim("c", 1.234, "<=", 2.0, unit="m"), "1.23 m", "at most 2 m"),
        (Claim("c", 1.2, "within", (1.0, 2.0), format=".1f"), "1.2", "1.0 to 2.0"),
        (Claim("c", {"a": 1.0, "b": math.nan}, ">", 2.0), "a 1, b -", "more than 2"),
        (Claim("c", {"a": 1.0}, ">=", {"a": 2.0}), "a 1", "a at least 2"),
        (Claim("c", 3.0), "3", "-"),
        (Claim("c", 1.8974, ">=", 1.9), "1.897", "at least 1.9"),
        (Claim("c", 3.9982, ">=", 4.0, format=".2f"), "3.998", "at least 4.00"),
        (Claim("c", 0.030004, "<=", 0.03, format=".0%"), "3.0004%", "at most 3%"),
        (Claim("c", 1.0 + 1e-12, "<=", 1.0), "1", "at most 1"),
        (Claim("c", {"a": 1.8974, "b": 1.92}, ">=", 1.9), "a 1.897, b 1.92", "at least 1.9"),
        (Claim("c", 3.0, "<", 4.0, said="three", wanted="four", incomplete="no more"),
         "three; no more", "four"),
    ],
)  # fmt: skip
def test_numbers_as_a_report_says_them(claim, shown, limit):
    assert (claim.shown, claim.limit) == (shown, limit)


def test_what_does_not_hold_comes_first():
    claims = [
        Claim("good", 1.0, "<=", 2.0), Claim("reported", 1.0), Claim("bad", 3.0, "<=", 2.0),
        Claim("some", {"a": 1.0, "b": 3.0}, "<=", 2.0, source="paper"), Claim("none", {}, ">", 1.0),
    ]  # fmt: skip
    table = claims_table(claims)
    assert table["claim"].tolist() == ["bad", "some", "none", "reported", "good"]
    assert set(table["verdict"]) <= set(FIRST)
    assert claims_table(claims, worst_first=False)["claim"].tolist()[0] == "good"
    assert len(claims_table([])) == 0


@pytest.mark.parametrize(
    "wrong",
    [
        {"comparison": "<="}, {"comparison": "<=", "asked": (0.0, 1.0)},
        {"comparison": "within", "asked": 1.0}, {"comparison": "<=", "asked": {"b": 1.0}},
        {"comparison": "<=", "asked": 1.0, "sound": {"b": True}},
    ],
)  # fmt: skip
def test_a_claim_that_compares_nothing_is_refused(wrong):
    with pytest.raises(InputError, match="claim 'c'"):
        Claim("c", {"a": 1.0}, **wrong)


def test_two_claims_of_one_name_are_refused():
    with pytest.raises(InputError, match="claims repeat: c here"):
        claims_table([Claim("c ", 1.0, where="here")] * 2)


def test_a_number_that_would_do_says_that_the_run_was_not_sound() -> None:
    folded = Claim("height", 0.01, "<=", 0.02, sound=False)
    assert (folded.verdict, folded.shown) == ("not met", "0.01; folded or diverged")
    parts = Claim("height", {"a": 0.01, "b": 0.01}, "<=", 0.02, sound={"a": True, "b": False})
    assert (parts.verdict, parts.shown) == ("met in part", "a 0.01, b 0.01; folded or diverged: b")
    assert Claim("height", 0.03, "<=", 0.02, sound=False).shown == "0.03"
    assert Claim.counted("runs", 2, 3).limit == "all"
