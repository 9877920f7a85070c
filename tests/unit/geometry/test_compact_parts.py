"""Points in compact parts."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.geometry.compact_parts import compact_parts
from sphsolid.scenes import Box


@pytest.mark.parametrize("count", [1, 3, 8, 1000])
def test_every_point_is_in_one_of_equal_parts(count):
    points = np.random.default_rng(0).random((100, 3))
    parts = compact_parts(points, count)
    assert len(parts) == min(count, 100)
    np.testing.assert_array_equal(np.sort(np.concatenate(parts)), np.arange(100))
    assert np.ptp([len(part) for part in parts]) <= 1
    assert all(np.all(np.diff(part) > 0) for part in parts)


def test_parts_are_long_along_the_numbers_and_compact_without():
    X = Box(jitter=0.4).mesh(1 / 15).vertices
    along = compact_parts(X, 16)
    assert min(np.ptp(X[part, 2]) for part in along) > 0.9
    assert max(np.ptp(X[part, axis]) for part in along for axis in (0, 1)) < 0.35
    mixed = X[np.random.default_rng(0).permutation(len(X))]
    assert max(np.ptp(mixed[part], axis=0).max() for part in compact_parts(mixed, 64)) < 0.4
