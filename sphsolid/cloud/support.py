"""Is the support large enough for an invertible correction?  Asked before anything is built."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.cloud.gradient import offsets, row_sum
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.errors import InputError

Array = NDArray[np.float64]
#: Least ratio of the smallest to the largest singular value of the neighbour positions.
FLATNESS = 1.0e-3


def check_support(
    points: Array,
    particles: Array,
    pairs: PairList,
    *,
    h_over_dx: float,
    support: float,
    spacings: Array,
    what: str,
) -> None:
    """Raise ``InputError`` unless the neighbours of every point span three dimensions.

    ``spacings (R,)`` [m] around the points.  The message names the worst point and the
    ``h_over_dx`` that would serve all of them.
    """
    neighbours = np.diff(pairs.indptr)
    enough = neighbours >= 4
    spans = np.zeros(pairs.rows, dtype=bool)
    if np.all(neighbours > 0):
        d = offsets(points, particles, pairs)
        mean = row_sum(pairs, d) / neighbours[:, None]
        centred = d - mean[pairs.row_of_pair]
        scatter = row_sum(pairs, centred[:, :, None] * centred[:, None, :])
        value = np.linalg.eigvalsh(scatter)
        spans = value[:, 0] > FLATNESS**2 * value[:, 2]
    bad = np.flatnonzero(~(enough & spans))
    if len(bad) == 0:
        return
    worst = int(bad[np.argmin(neighbours[bad])])
    needed = _smallest_ratio(points[bad], particles, spacings[bad]) / support
    raise InputError(
        f"h_over_dx = {h_over_dx:g} is too small: {len(bad)} of {pairs.rows} {what} particles have "
        f"too few neighbours for the gradient correction, for instance {what} particle {worst} at "
        f"X = {points[worst].tolist()} m with {int(neighbours[worst])}; raise h_over_dx to at "
        f"least {np.ceil(needed * 102.0) / 100.0:g}"
    )


def _smallest_ratio(points: Array, particles: Array, spacings: Array) -> float:
    """Radius over spacing within which every point's neighbours span three dimensions."""
    count = min(60, len(particles))
    distance, index = cKDTree(particles).query(points, k=count)
    reach = 0.0
    for point, radii, near, spacing in zip(points, distance, index, spacings, strict=True):
        for n in range(4, count + 1):
            d = particles[near[:n]]
            value = np.linalg.svd(d - d.mean(axis=0), compute_uv=False)
            if value[2] > FLATNESS * value[0]:
                reach = max(reach, float(radii[n - 1]) / spacing)
                break
        else:
            raise InputError(
                f"the cloud is flat around X = {point.tolist()} m: no support makes the gradient "
                "correction invertible there; use at least two layers of particles"
            )
    return reach
