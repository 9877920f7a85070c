"""The punch on clouds: bodies without a mesh are what they claim, a short run, the claims."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from sphsolid.cloud.lengths import Uniform, lengths_of
from sphsolid.geometry.integrals import vertex_volumes
from studies.engine.results import Results
from studies.methods import SUPG
from studies.punch_cloud import (
    BARE,
    CLOUDS,
    FILLED,
    HEXAHEDRA,
    LEVELS,
    PICTURES,
    POINTS,
    STUDY,
    TETRAHEDRA,
    WIDEST,
    body_of,
    claims,
    run_case,
    tables,
)

#: Sides of the block [m].
SIDES = np.array([1.0, 0.1, 0.5])


@pytest.mark.parametrize("cloud", CLOUDS)
def test_every_body_is_the_block(cloud: str) -> None:
    body, spacing = body_of(cloud, spacing=0.05, seed=3)
    mesh = body.mesh(spacing)
    V = vertex_volumes(mesh)
    assert float(np.sum(V)) == pytest.approx(np.prod(SIDES), rel=1e-12)
    np.testing.assert_allclose(V @ mesh.vertices, np.prod(SIDES) * 0.5 * SIDES, rtol=1e-10)


def test_hexahedra_have_the_smoothing_length_of_the_points() -> None:
    """Cells of 25 x 33 x 25 mm; with the widest edge the comparison would be one of supports."""
    bodies = [body_of(cloud, spacing=1 / 40, seed=1) for cloud in (HEXAHEDRA, POINTS, WIDEST)]
    hexahedra, points, grid = (lengths_of(body.mesh(spacing), 1.0) for body, spacing in bodies)
    for lengths in (hexahedra, points, grid):
        assert isinstance(lengths, Uniform)
    assert hexahedra.spacing == pytest.approx(points.spacing, rel=1e-12)
    assert grid.spacing > 1.2 * points.spacing


@pytest.mark.parametrize("method", [SUPG, BARE])
def test_a_short_punch_without_a_mesh(tmp_path: Path, method) -> None:
    run, first, second = run_case(
        key="short", cloud=POINTS, method=method, cells=10, seed=1, until=1e-3,
        shots=str(tmp_path),
    )  # fmt: skip
    assert run["survived"]
    assert run["steps"] > 2
    assert (run["secondary"] > 0) == (method == SUPG)
    assert run["noise"] == pytest.approx(np.mean([first["noise"], second["noise"]]))
    assert math.isnan(run["noise_in_rows"])
    assert run["missed_momentum"] < 1e-12
    assert first["top_high"] >= second["top_low"]
    assert len(list(tmp_path.glob("short@*.npz"))) == 1


def made(noise: dict, **changes) -> list[dict]:
    """Rows of two seeds a cloud and method; ``changes`` of those of ``points``."""
    common = {
        "kind": "run", "cells": LEVELS[0], "settings": "", "particles": 8, "survived": True,
        "folded": False, "folded_at": math.nan,
    }  # fmt: skip
    rows = []
    for (cloud, method), values in noise.items():
        for seed, value in enumerate(values, start=1):
            row = common | {"cloud": cloud, "method": method.name, "seed": seed, "noise": value}
            own = changes if cloud == POINTS and method == SUPG else {}
            rows.append(row | {"key": f"{cloud} {method.name} {seed}"} | own)
    return rows


WORLD = {
    (HEXAHEDRA, SUPG): (0.10, 0.12), (POINTS, SUPG): (0.11, 0.13),
    (FILLED, SUPG): (0.12, 0.12), (POINTS, TETRAHEDRA): (0.05, 0.06), (POINTS, BARE): (0.4, 0.4),
}  # fmt: skip


def verdicts(noise: dict, **changes) -> dict[str, str]:
    return {claim.what: claim.verdict for claim in claims(tables(made(noise, **changes)))}


def test_claims_compare_with_h1_on_the_points_of_the_same_seed() -> None:
    found = tables(made(WORLD))
    against = found["table"].set_index(["cloud", "method"])["against_H1"]
    assert against[POINTS, SUPG.name] == pytest.approx(np.mean([0.1, 1 / 12]))
    assert against[POINTS, TETRAHEDRA.name] == pytest.approx(-0.5)
    assert set(verdicts(WORLD).values()) == {"met"}
    assert len(verdicts(WORLD)) == 8


@pytest.mark.parametrize(
    ("claim", "noise", "changes"),
    [
        ("points: noise above that of H1, mean", {(POINTS, SUPG): (0.14, 0.13)}, {}),
        ("points: the same, worst seed", {(POINTS, SUPG): (0.125, 0.12)}, {}),
        ("points: noise over that without stabilisation", {(POINTS, BARE): (0.2, 0.2)}, {}),
        ("points: runs that diverged", {}, {"survived": False}),
        ("points: runs that folded", {}, {"folded": True}),
        ("filled: noise above that of H1, mean", {(FILLED, SUPG): (0.14, 0.14)}, {}),
    ],
)
def test_each_claim_can_fail(claim: str, noise: dict, changes: dict) -> None:
    assert verdicts(WORLD | noise, **changes)[claim] == "not met"


def test_pictures_and_curves_are_drawn_from_what_was_kept(tmp_path: Path) -> None:
    rows = run_case(
        key="k", cloud=POINTS, method=SUPG, cells=10, seed=1, until=5e-4,
        shots=str(tmp_path / "shots"),
    )  # fmt: skip
    found = tables(rows)
    results = Results(tmp_path, found, found["runs"], {})
    assert STUDY.figures["noise"](results).axes[0].lines
    assert not any(each.is_worth_drawing(found) for each in PICTURES.values())
