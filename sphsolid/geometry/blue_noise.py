"""Evenly spread points without order in a box of any dimension: random, then relaxed.

Lloyd's iteration moves every point to the centroid of what is nearest to it.  The centroids are
those of random samples, drawn anew each time, so that no grid of samples shows in the result.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
_SWEEPS = 16
_SAMPLES_A_POINT = 8


def blue_noise(
    lower: Array, upper: Array, count: int, fixed: Array, random: np.random.Generator
) -> Array:
    """``count`` points ``(count, d)`` in the box between ``lower`` and ``upper``.

    ``fixed (m, d)`` are points of its boundary that keep their share of the room.
    """
    if count == 0:
        return np.empty((0, len(lower)))
    points = random.uniform(lower, upper, (count, len(lower)))
    samples = _SAMPLES_A_POINT * (count + len(fixed))
    for _ in range(_SWEEPS):
        sample = random.uniform(lower, upper, (samples, len(lower)))
        _, owner = cKDTree(np.concatenate([points, fixed])).query(sample)
        held = np.bincount(owner, minlength=count)[:count]
        moment = np.stack(
            [np.bincount(owner, weights=x, minlength=count)[:count] for x in sample.T], axis=1
        )
        points = np.where(held[:, None] > 0, moment / np.maximum(held, 1)[:, None], points)
    return points
