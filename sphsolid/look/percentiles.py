"""Percentiles by volume: one function for every table, figure and colour bar."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import require

#: Shares of the whole that are the same but for round-off.
_SAME = 1.0e-12


def weighted_percentile(
    values: ArrayLike, weights: ArrayLike, shares: ArrayLike
) -> NDArray[np.float64]:
    """The values below which ``shares`` (s,) [per cent] of the weight lie, ``(s,)``.

    ``values (n,)`` with ``weights (n,)`` >= 0, the volumes that the points stand for.  It is the
    inverse of the distribution, with the mean of both neighbours where a share falls between
    them: for equal weights numpy's ``averaged_inverted_cdf``.  So a point counts as much as two of
    half its weight in the same place, and mirrored values have mirrored percentiles; a line
    drawn from value to value, numpy's default, could not have the first property.

    Raises ``InputError`` for lengths that differ, weights that are negative or sum to nothing,
    values that are not finite and shares outside [0, 100].
    """
    v, w = np.asarray(values, dtype=float), np.asarray(weights, dtype=float)
    q = np.asarray(shares, dtype=float) / 100.0
    require(
        v.ndim == 1 and v.shape == w.shape,
        f"weighted_percentile: values {v.shape} and weights {w.shape} must be of one length",
    )
    require(
        bool(np.isfinite(v).all() and (w >= 0.0).all() and np.isfinite(w).all() and w.sum() > 0.0),
        "weighted_percentile: values must be finite, weights not negative and not all zero",
    )
    require(
        bool((q >= 0.0).all() and (q <= 1.0).all()),
        f"weighted_percentile: shares {np.asarray(shares).tolist()} must be within 0 .. 100",
    )
    v, w = v[w > 0.0], w[w > 0.0]
    order = np.argsort(v, kind="stable")
    below = np.cumsum(w[order])
    below /= below[-1]
    first = np.searchsorted(below, q - _SAME)
    # One further where the share is the whole of what lies below: between two values.
    second = np.minimum(np.searchsorted(below, q + _SAME), len(v) - 1)
    # Nothing lies below the least value or above the largest, however little they weigh.
    for end, at in ((q <= _SAME, 0), (q >= 1.0 - _SAME, len(v) - 1)):
        first, second = np.where(end, at, first), np.where(end, at, second)
    return np.asarray(0.5 * (v[order[first]] + v[order[second]]))
