"""Parts of a cloud: what no chain of pairs joins."""

import numpy as np

from sphsolid.cloud.pairs.neighbours import pairs_within
from sphsolid.cloud.pairs.parts import parts_of


def test_one_cloud_is_one_part():
    X = np.random.default_rng(1).uniform(size=(40, 3))
    assert np.array_equal(parts_of(pairs_within(X, X, 2.0)), np.zeros(40))


def test_parts_are_numbered_in_the_order_of_their_first_particles():
    X = np.array([[0.0, 0, 0], [9, 0, 0], [1, 0, 0], [5, 0, 0], [8, 0, 0], [2, 0, 0]])
    assert parts_of(pairs_within(X, X, 1.5)).tolist() == [0, 1, 0, 2, 1, 0]
