"""The indicator without rows of particles, on fields whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from studies.measures.scattered_noise import departure, noise_of

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
