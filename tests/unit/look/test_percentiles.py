"""Percentiles by volume: what they must not depend on."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.look.percentiles import weighted_percentile

SHARES = (0.0, 1.0, 25.0, 50.0, 99.0, 100.0)


@pytest.mark.parametrize("size", [1, 2, 7, 100, 501])
def test_equal_weights_are_numpys(size):
    values = np.random.default_rng(size).normal(size=size)
    expected = np.percentile(values, SHARES, method="averaged_inverted_cdf")
    for weight in (1.0, 1.0 / 3.0, 1e-9):
        found = weighted_percentile(values, np.full(size, weight), SHARES)
        assert found == pytest.approx(expected, rel=1e-14)
    assert weighted_percentile(values, np.ones(size), [50.0])[0] == pytest.approx(
        np.median(values)
    )


@pytest.mark.parametrize("share", [0.0, 3.0, 37.0, 50.0, 90.0, 99.9, 100.0])
def test_a_point_split_in_two_counts_as_before(share):
    rng = np.random.default_rng(5)
    values, weights = rng.normal(size=40), rng.uniform(0.1, 1.0, size=40)
    whole = weighted_percentile(values, weights, [share])
    for k in (0, 17, int(np.argmax(values)), int(np.argmin(values))):
        part = 0.3 * weights[k]
        split = weights.copy()
        split[k] -= part
        halves = weighted_percentile(np.append(values, values[k]), np.append(split, part), [share])
        assert halves.tolist() == whole.tolist()


def test_a_share_between_two_values_is_their_mean_also_after_a_split():
    whole = weighted_percentile([0.0, 1.0, 2.0, 3.0], np.ones(4), [25.0, 50.0])
    assert whole.tolist() == [0.5, 1.5]
    split = weighted_percentile([0.0, 0.0, 1.0, 2.0, 3.0], [0.3, 0.7, 1.0, 1.0, 1.0], [25.0])
    assert split.tolist() == [0.5]


def test_a_boundary_layer_of_half_cells_does_not_move_it():
    """Particles on a lattice stand for half, quarter and eighth cells at the boundary."""
    n = 20
    edge, middle = np.linspace(0.0, 1.0, n + 1), (np.arange(n) + 0.5) / n
    weight = np.ones(n + 1)
    weight[[0, -1]] = 0.5

    def field(x):
        return np.add.outer(np.add.outer(x**2, x), 3.0 * x).ravel()

    V = np.multiply.outer(np.multiply.outer(weight, weight), weight).ravel()
    particles = weighted_percentile(field(edge), V, [1.0, 50.0, 99.0])
    cells = weighted_percentile(field(middle), np.ones(n**3), [1.0, 50.0, 99.0])
    counted = np.percentile(field(edge), [1.0, 50.0, 99.0])
    assert particles == pytest.approx(cells, abs=0.03)
    # Counting particles instead, three faces of the cube are twice as heavy as they should be.
    assert abs(counted - cells)[[0, 2]].min() > 3.0 * abs(particles - cells).max()


def test_mirrored_values_have_mirrored_percentiles():
    rng = np.random.default_rng(2)
    values, weights = rng.normal(size=60), rng.integers(1, 9, size=60) / 8.0
    low, high = weighted_percentile(values, weights, [1.0, 99.0])
    assert weighted_percentile(-values, weights, [1.0, 99.0]).tolist() == [-high, -low]


def test_the_ends_are_the_ends_however_little_they_weigh():
    values, weights = [-5.0, 0.0, 1.0, 7.0], [1e-15, 1.0, 1.0, 1e-15]
    assert weighted_percentile(values, weights, [0.0, 100.0]).tolist() == [-5.0, 7.0]


def test_what_has_no_volume_does_not_count():
    found = weighted_percentile([-9.0, 1.0, 2.0, 9.0], [0.0, 1.0, 1.0, 0.0], [0.0, 100.0])
    assert found.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("values", "weights", "shares"),
    [
        ([1.0, 2.0], [1.0], [50.0]),
        ([1.0, np.nan], [1.0, 1.0], [50.0]),
        ([1.0, 2.0], [1.0, -1.0], [50.0]),
        ([1.0, 2.0], [0.0, 0.0], [50.0]),
        ([], [], [50.0]),
        ([1.0, 2.0], [1.0, 1.0], [101.0]),
        ([[1.0, 2.0]], [[1.0, 1.0]], [50.0]),
    ],
)
def test_what_has_no_percentile_is_refused(values, weights, shares):
    with pytest.raises(InputError, match="weighted_percentile"):
        weighted_percentile(values, weights, shares)
