"""Is the support large enough for an invertible correction?  Asked before anything is built."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.cloud.gradient import offsets, row_sum
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
#: Least ratio of the smallest to the largest singular value of the neighbour positions.
FLATNESS = 1.0e-3
#: Nearest particles among which a large enough support is looked for.
_MOST = 60


def nothing_hidden(points: Array, pairs: PairList) -> Mask:
    """Every particle is seen from everywhere."""
    return np.zeros(pairs.pairs, dtype=bool)


def check_support(
    points: Array,
    particles: Array,
    pairs: PairList,
    *,
    h_over_dx: float,
    support: float,
    spacings: Array,
    what: str,
    hidden: Callable[[Array, PairList], Mask] = nothing_hidden,
) -> None:
    """Raise ``InputError`` unless the neighbours of every point span three dimensions.

    ``spacings (R,)`` [m] around the points; ``hidden(points, pairs) -> (P,)`` which pairs are
    none because the body does not join them.  The message names the worst point and the
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
    near = _nearest(points, particles, bad)
    behind = hidden(points, near).reshape(len(bad), -1)
    needed = _smallest_ratio(points[bad], particles, spacings[bad], near, behind) / support
    away = int(np.count_nonzero(np.any(behind[:, : 4], axis=1)))
    raise InputError(
        f"h_over_dx = {h_over_dx:g} is too small: {len(bad)} of {pairs.rows} {what} particles have "
        f"too few neighbours for the gradient correction, for instance {what} particle {worst} at "
        f"X = {points[worst].tolist()} m with {int(neighbours[worst])}"
        + (f" (particles near {away} of them do not count: a gap, slot or notch is between)"
           if away else "")
        + f"; raise h_over_dx to at least {np.ceil(needed * 102.0) / 100.0:g}"
    )


def _nearest(points: Array, particles: Array, chosen: Indices) -> PairList:
    """The particles nearest to the ``chosen`` points, by distance; other rows are empty."""
    count = min(_MOST, len(particles))
    _, near = cKDTree(particles).query(points[chosen], k=count)
    size = np.zeros(len(points), dtype=np.int64)
    size[chosen] = count
    return PairList(np.concatenate([[0], np.cumsum(size)]), near.ravel().astype(np.uint32))


def _smallest_ratio(
    points: Array, particles: Array, spacings: Array, near: PairList, hidden: Mask
) -> float:
    """Radius over spacing within which every point's neighbours span three dimensions."""
    reach = 0.0
    index = near.indices.reshape(len(points), -1)
    for point, row, behind, spacing in zip(points, index, hidden, spacings, strict=True):
        seen = particles[row[~behind]]
        for n in range(4, len(seen) + 1):
            d = seen[:n]
            value = np.linalg.svd(d - d.mean(axis=0), compute_uv=False)
            if value[2] > FLATNESS * value[0]:
                radius = float(np.linalg.norm(seen[n - 1] - point))
                reach = max(reach, radius / spacing)
                break
        else:
            cut = (
                f" ({np.count_nonzero(behind)} of the {len(row)} nearest particles lie across a "
                "gap, slot or notch and do not count)" if behind.any() else ""
            )
            raise InputError(
                f"the cloud is flat around X = {point.tolist()} m{cut}: no support makes the "
                "gradient correction invertible there; use at least two layers of particles"
            )
    return reach
