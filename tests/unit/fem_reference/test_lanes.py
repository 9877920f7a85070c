"""The side-by-side layout and the sums at the nodes."""

import numpy as np
import pytest

from fem_reference.assembly import NodeIncidence
from fem_reference.lanes import LANES, blocks, one_by_one, side_by_side


@pytest.mark.parametrize("elements", [1, LANES - 1, LANES, LANES + 1, 3 * LANES])
def test_blocks_hold_every_element_once_and_are_filled_with_the_last(elements: int) -> None:
    table = np.random.default_rng(0).normal(size=(elements, 5, 2))
    lanes = side_by_side(table)
    assert lanes.shape == (blocks(elements), 5, 2, LANES)
    assert lanes.flags.c_contiguous
    np.testing.assert_array_equal(one_by_one(lanes, elements), table)
    spare = one_by_one(lanes, lanes.shape[0] * LANES)[elements:]
    np.testing.assert_array_equal(spare, np.broadcast_to(table[-1], spare.shape))


def test_sums_at_the_nodes_are_those_of_a_plain_loop() -> None:
    random = np.random.default_rng(1)
    elements, nodes = 2 * LANES + 3, 17
    cells = np.array([random.permutation(nodes)[:8] for _ in range(elements)], dtype=np.uint32)
    vectors, scalars = random.normal(size=(elements, 8, 3)), random.normal(size=(elements, 8))
    expected, total = np.zeros((nodes, 3)), np.zeros(nodes)
    np.add.at(expected, cells, vectors)
    np.add.at(total, cells, scalars)
    found, sums = np.empty((nodes, 3)), np.empty(nodes)
    NodeIncidence.of(cells, nodes).gather(side_by_side(vectors.reshape(elements, 24)), found)
    NodeIncidence.of(cells, nodes, components=1).gather_scalars(side_by_side(scalars), sums)
    # Element by element in both: the same order, so the same bits.
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(sums, total)
