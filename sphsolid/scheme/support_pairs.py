"""The pairs of a cloud with the kernel between them, for terms that act from particle to particle.

A pair is a particle and another one within its support that it sees through the material.  Every
pair is there twice, once from each end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.gradient import offsets

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SupportPairs:
    """``P`` pairs, those of one particle one after the other.

    ``indptr (N + 1,)`` says where those of a particle begin, ``row, column (P,)`` who they are;
    ``d (P, 3)`` [m] is ``X_b - X_a`` and ``r (P,)`` its length; ``W (P,)`` [1/m^3] and ``slope
    (P,)`` [1/m^4] are the kernel and ``dW/dr``; ``place (P,)`` says where the pair stands in
    ``cloud.pairs``.
    """

    indptr: NDArray[np.uint64]
    row: NDArray[np.int64]
    column: NDArray[np.uint32]
    d: Array
    r: Array
    W: Array
    slope: Array
    place: NDArray[np.int64]


def support_pairs(cloud: Cloud) -> SupportPairs:
    """The pairs of ``cloud`` whose kernel is not zero."""
    pairs = cloud.pairs
    d = offsets(cloud.X, cloud.X, pairs)
    r = np.linalg.norm(d, axis=1)
    h = cloud.lengths.of_pairs(cloud.X, pairs)
    W, slope = cloud.smoothing.value(r, h), cloud.smoothing.slope(r, h)
    place = np.flatnonzero((r > 0.0) & (W > 0.0))
    row = pairs.row_of_pair[place]
    count = np.bincount(row, minlength=pairs.rows)
    return SupportPairs(
        np.concatenate([[0], np.cumsum(count)]).astype(np.uint64),
        row, pairs.indices[place], d[place], r[place], W[place], slope[place], place,
    )  # fmt: skip
