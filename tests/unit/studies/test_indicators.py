"""Indicators on fields whose answer is known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.scenes import twisting_column
from studies.measures.indicators import (
    departure,
    noise_of,
    pressure_noise,
    pressure_range,
    twist_of_top,
    whole_turns,
)

SCENE = twisting_column()
SOLVERS = {
    "particles": sph.Simulation(SCENE, spacing=1 / 4, stabilisation=sph.NoStabilisation()),
    "elements": fem.Simulation(SCENE, spacing=1 / 4),
}


def with_pressure(kind, values):
    """A snapshot whose pressure is ``values(X, number along each axis)``."""
    shot = SOLVERS[kind].snapshot()
    number = np.rint((shot.stress_X - shot.stress_X.min(axis=0)) / 0.25)
    p = values(shot.stress_X, number)
    return replace(shot, J=1.0 + p / shot.material.kappa)


@pytest.mark.parametrize("kind", SOLVERS)
@pytest.mark.parametrize(
    ("values", "share"),
    [
        (lambda X, n: 1e5 * (-1.0) ** n.sum(axis=1), 1.0),
        (lambda X, n: 1e5 * (-1.0) ** n[:, 1], 1.0),
        (lambda X, n: 1e4 * (X @ [1.0, 2.0, -3.0]), 0.0),
        (lambda X, n: np.zeros(len(X)), 0.0),
        # One wave over ten spacings along Y: (1 - cos(2 pi / 10)) / 2.
        (lambda X, n: 1e5 * np.sin(2 * np.pi * X[:, 1] / 2.5), 0.5 * (1 - math.cos(0.2 * np.pi))),
    ],
)
def test_noise(kind, values, share):
    found = pressure_noise(with_pressure(kind, values))
    assert found == pytest.approx(share, abs=1e-6 if share in (0.0, 1.0) else 0.01)


def test_noise_of_a_disordered_linear_field_is_zero():
    """Jitter bends the runs, so a field that is linear in space stays small, not exactly zero."""
    scene = replace(SCENE, body=replace(SCENE.body, jitter=0.3))
    shot = sph.Simulation(scene, spacing=1 / 4, stabilisation=sph.NoStabilisation()).snapshot()
    p = 1e4 * (shot.X @ [1.0, 2.0, -3.0])
    assert pressure_noise(replace(shot, J=1.0 + p / shot.material.kappa)) < 0.03


def test_range_is_that_of_the_percentiles():
    shot = with_pressure("elements", lambda X, n: 1e6 * X[:, 1])
    low, high = pressure_range(shot, 0.0, 100.0)
    assert (low, high) == pytest.approx((0.125e6, 5.875e6))


@pytest.mark.parametrize("angle", [0.3, -2.0, 3.1])
def test_twist_of_a_turned_top(angle):
    shot = SOLVERS["particles"].snapshot()
    z, x = shot.X[:, 2], shot.X[:, 0]
    turned = shot.X.copy()
    turned[:, 0] = x * math.cos(angle) - z * math.sin(angle) + 0.7
    turned[:, 2] = x * math.sin(angle) + z * math.cos(angle)
    assert twist_of_top(replace(shot, x=turned)) == pytest.approx(angle)


def test_turns_are_counted():
    twist = 0.0
    for k in range(1, 60):
        true = 0.2 * k
        twist = whole_turns(math.remainder(true, 2 * math.pi), twist)
        assert twist == pytest.approx(true)


# --- points of any kind ---------------------------------------------------------------------------

X = np.stack(np.meshgrid(*[np.arange(11.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
V = np.ones(len(X))


@pytest.mark.parametrize(
    ("p", "share", "off"),
    [((-1.0) ** X.sum(axis=1), 1.0, 0.1), ((-1.0) ** X[:, 1], 1.0, 0.05),
     (np.sin(0.2 * np.pi * X[:, 0]), 0.5 * (1.0 - np.cos(0.2 * np.pi)), 0.01),
     (1e6 + X @ [1.0, 2.0, -3.0], 0.0, 1e-9), (np.full(len(X), 7.0), 0.0, 1e-9)],
)  # fmt: skip
def test_noise_on_a_lattice(p, share, off):
    assert noise_of(X, V, p, 1.0) == pytest.approx(share, abs=off)


def test_inside_a_lattice_a_checkerboard_has_exactly_one():
    inside = np.all((X > 0.0) & (X < 10.0), axis=1)
    found = departure(X, (-1.0) ** X.sum(axis=1), 1.0)[inside] / (6.0 / 7.0)
    np.testing.assert_allclose(np.abs(found), 1.0, rtol=1e-12)


def test_a_linear_field_has_none_in_any_disorder():
    moved = X + np.random.default_rng(0).uniform(-0.2, 0.2, X.shape)
    assert noise_of(moved, V, moved @ [1.0, 2.0, -3.0], 1.0) < 1e-12
