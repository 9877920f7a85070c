"""The map of the default's parts: what is varied, and the range that needs no tuning."""

from __future__ import annotations

import argparse
import dataclasses

import pandas as pd
import pytest

import sphsolid as sph
from sphsolid.defaults import H_OVER_DX_RESTRAINED
from studies import restraint
from studies.methods import PACKAGE


def test_the_default_is_among_the_variants_of_each_part() -> None:
    own = PACKAGE.simulation(sph.scenes.swinging_cube(poisson_ratio=0.3), spacing=0.25)
    made = restraint.variants()
    for part, value in restraint.DEFAULT.items():
        sim = made[part, value].simulation(own.scene, spacing=0.25)
        assert sim.stabilisation == own.stabilisation
        assert sim.dilatation == own.dilatation


def test_every_variant_meets_every_problem() -> None:
    listed = restraint.cases(argparse.Namespace(quick=False))
    lattices = len(restraint.variants()) * (len(restraint.HARD) + 2 * len(restraint.NUS))
    pressed = (len(restraint.COMPRESSED) + 1) * len(restraint.PRESSURES)
    shares = len(restraint.COMPRESSED) + len(restraint.SUPPORTS)
    assert len(listed) == lattices + pressed + shares * 4
    assert len({case.key for case in listed}) == len(listed)


def test_the_default_is_among_the_supports() -> None:
    scene = dataclasses.replace(sph.scenes.swinging_cube(), body=restraint.DISORDERED_BODY)
    own = PACKAGE.simulation(scene, spacing=0.25).cloud.h
    found = [
        value for value, method in restraint.supports().items()
        if method.simulation(scene, spacing=0.25).cloud.h == own
    ]  # fmt: skip
    assert found == [f"{H_OVER_DX_RESTRAINED:g}"]


def test_the_default_holds_a_pressed_cube_that_is_lost_without() -> None:
    default = f"{sph.Quartic().compressed:g}"
    rows = []
    for value in ("0", default):
        method = restraint.off_lattices()[value]
        rows += restraint.run_pressed(part="compressed", value=value, method=method, pressure=4.0)
    held, lost = restraint.claims(restraint.tables([*rows, row("10", True), row("40", True)]))[-2:]
    assert (held.verdict, lost.verdict) == ("met", "reported")
    assert lost.measured > 1e4 > 1.0 > held.measured
    assert default in restraint.off_lattices()


def row(value: str, sound: bool, problem: str = "a", part: str = "stiffness") -> dict:
    return {
        "kind": "hard", "part": part, "value": value, "problem": problem, "survived": sound,
        "folded": False, "folded_at": float("nan"),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("sound", "factor"),
    [
        ({"10": 1, "20": 1, "40": 1, "80": 1, "200": 1, "800": 1}, 80.0),
        ({"10": 0, "20": 1, "40": 1, "80": 1, "200": 0, "800": 1}, 4.0),
        ({"10": 1, "20": 0, "40": 1, "80": 0, "200": 1, "800": 1}, 1.0),
    ],
)
def test_the_range_ends_where_a_run_is_lost(sound: dict[str, int], factor: float) -> None:
    made = restraint.tables([row(value, bool(good)) for value, good in sound.items()])
    claim = restraint.claims(made)[0]
    assert claim.measured == factor
    assert claim.verdict == ("met" if factor >= restraint.ASKED_RANGE else "not met")


def test_the_table_counts_and_names() -> None:
    rows = [row("40", True), row("40", False, "b"), row("own", True, part="dilatation")]
    table = restraint.tables(rows)["table"]
    assert list(table["sound"]) == [1, 1]
    assert list(table["not_sound"]) == ["b", ""]
    assert list(table["default"]) == [True, False]
    assert isinstance(restraint.tables([])["table"], pd.DataFrame)
