"""Four numbers in a register: the same bits as four loops."""

from __future__ import annotations

import numpy as np

from sphsolid.cloud.lanes import lanes_of, no_lanes, set_lanes
from sphsolid.compiled import serial_kernel


@serial_kernel
def _combined(a, b, factor, out):  # type: ignore[no-untyped-def]
    for n in range(len(a)):
        total = no_lanes()
        for i in range(a.shape[1]):
            total = total + factor[i] * (lanes_of(a, n, i) - lanes_of(b, n, i)) * lanes_of(a, n, i)
        set_lanes(out, n, 0, total)


def test_the_bits_are_those_of_plain_arithmetic() -> None:
    random = np.random.default_rng(0)
    a, b = random.normal(size=(2, 7, 5, 4))
    factor = random.normal(size=5)
    out = np.zeros((7, 1, 4))
    _combined(a, b, factor, out)
    expected = np.zeros((7, 4))
    for i in range(5):
        expected = expected + factor[i] * (a[:, i] - b[:, i]) * a[:, i]
    np.testing.assert_array_equal(out[:, 0], expected)
