"""Pair lists against brute force."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from sphsolid.cloud.gradient import offsets, row_sum
from sphsolid.cloud.pairs.neighbours import PairList, pairs_within, transposed
from sphsolid.scenes import Box

Array = NDArray[np.float64]


def matrix(pairs: PairList, columns: int) -> NDArray[np.int64]:
    """Who sees whom, 0 or 1; a pair listed twice would count 2."""
    seen = np.zeros((pairs.rows, columns), dtype=np.int64)
    np.add.at(seen, (pairs.row_of_pair, pairs.indices.astype(int)), 1)
    return seen


def brute_force(points: Array, particles: Array, radius: float) -> NDArray[np.int64]:
    return (np.linalg.norm(points[:, None] - particles[None], axis=2) < radius).astype(np.int64)


@pytest.mark.parametrize("radius", [0.05, 0.31, 0.7, 2.0])
def test_pairs_are_those_of_brute_force(radius: float) -> None:
    random = np.random.default_rng(6)
    points, particles = random.uniform(size=(60, 3)), random.uniform(size=(150, 3))
    pairs = pairs_within(points, particles, radius)
    np.testing.assert_array_equal(matrix(pairs, 150), brute_force(points, particles, radius))
    assert pairs.rows == 60
    assert pairs.mean_neighbours == pytest.approx(brute_force(points, particles, radius).sum() / 60)


def test_every_row_is_ascending() -> None:
    X = Box(jitter=0.4).mesh(0.2).vertices
    pairs = pairs_within(X, X, 0.36)
    for row in range(pairs.rows):
        near = pairs.indices[pairs.indptr[row] : pairs.indptr[row + 1]].astype(int)
        assert np.all(np.diff(near) > 0)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_a_cloud_sees_itself_symmetrically_and_every_particle_itself(jitter: float) -> None:
    X = Box(jitter=jitter).mesh(0.2).vertices
    seen = matrix(pairs_within(X, X, 1.8 * 0.2), len(X))
    np.testing.assert_array_equal(seen, seen.T)
    np.testing.assert_array_equal(np.diagonal(seen), 1)


@pytest.mark.parametrize("spacing", [0.25, 0.2, 1.0 / 7.0])
@pytest.mark.parametrize(
    ("h_over_dx", "stencil"), [(0.75, 19), (0.55, 7), (0.9, 27), (1.0, 27), (1.05, 33)]
)
def test_the_interior_stencil_of_a_lattice(
    spacing: float, h_over_dx: float, stencil: int
) -> None:
    """Support factor 2: radius 1.5 dx reaches 19 points, and 2.0 dx stops short of the 6 at 2."""
    X = Box(upper=(6 * spacing,) * 3).mesh(spacing).vertices
    pairs = pairs_within(X, X, 2.0 * h_over_dx * spacing)
    steps = np.rint(X / spacing).astype(int)
    inside = np.flatnonzero(np.all((steps >= 2) & (steps <= 4), axis=1))
    assert set(np.diff(pairs.indptr)[inside]) == {stencil}
    # The right ones, not only the right number.
    middle = int(np.flatnonzero(np.all(steps == 3, axis=1))[0])
    near = pairs.indices[pairs.indptr[middle] : pairs.indptr[middle + 1]]
    found = {tuple(step) for step in (steps[near] - 3).tolist()}
    reach = (2.0 * h_over_dx) ** 2 - 1e-9
    cube = itertools.product(range(-3, 4), repeat=3)
    assert found == {s for s in cube if sum(k * k for k in s) < reach}


@pytest.mark.parametrize(("h_over_dx", "seen"), [(0.75, 8), (0.82, 8), (0.84, 32), (1.0, 32)])
def test_the_stencil_of_a_cell_centre(h_over_dx: float, seen: int) -> None:
    """Eight corners while ``2 h < sqrt(11) / 2 dx = 1.658 dx``."""
    mesh = Box().mesh(0.2)
    centre = mesh.vertices[mesh.cells].mean(axis=1)
    pairs = pairs_within(centre, mesh.vertices, 2.0 * h_over_dx * 0.2)
    inside = np.all(np.abs(centre - 0.5) < 0.2, axis=1)
    assert set(np.diff(pairs.indptr)[inside]) == {seen}


def test_transposed_is_the_transpose_and_says_where_each_pair_stood() -> None:
    random = np.random.default_rng(8)
    points, particles = random.uniform(size=(40, 3)), random.uniform(size=(90, 3))
    pairs = pairs_within(points, particles, 0.3)
    other, place = transposed(pairs, 90)
    assert other.rows == 90
    np.testing.assert_array_equal(matrix(other, 40), matrix(pairs, 90).T)
    np.testing.assert_array_equal(other.row_of_pair, pairs.indices[place])
    np.testing.assert_array_equal(other.indices, pairs.row_of_pair[place])
    assert sorted(place) == list(range(pairs.pairs))
    lonely = matrix(pairs, 90).sum(axis=0) == 0
    assert np.any(lonely)  # particles that nobody sees have empty rows


def test_offsets_and_row_sums() -> None:
    random = np.random.default_rng(9)
    points, particles = random.uniform(size=(20, 3)), random.uniform(size=(80, 3))
    pairs = pairs_within(points, particles, 0.6)
    seen = matrix(pairs, 80)
    expected = seen @ particles - seen.sum(axis=1)[:, None] * points
    np.testing.assert_allclose(row_sum(pairs, offsets(points, particles, pairs)), expected)
