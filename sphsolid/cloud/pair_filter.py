"""A filter on any cloud that keeps constants and is symmetric in the volumes.

With ``k_ab = (1 - r_ab / (w dx_ab))_+`` of pairs that see each other and of each particle itself,

    S_ab = d_a k_ab V_b d_b,        V_a S_ab = V_b S_ba,        S 1 = 1,

where ``d`` is the fixed point of ``d <- sqrt(d / (k V d))``, the symmetric form of Sinkhorn's
iteration [Sinkhorn1967].  Applied as ``f_a + sum_b S_ab (f_b - f_a)``, which leaves a constant as
it is to the last bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.gradient import offsets
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.compiled import kernel, prange
from sphsolid.errors import InputError

Array = NDArray[np.float64]
#: Row sums this near to one are round-off of sums of some ten numbers.
_ROUND_OFF = 1.0e-15
_MOST_ITERATIONS = 1000


@kernel
def _smooth(indptr, indices, weight, f, out):  # type: ignore[no-untyped-def]
    for a in prange(len(out)):
        here, total = f[a], 0.0
        for k in range(indptr[a], indptr[a + 1]):
            total += weight[k] * (f[indices[k]] - here)
        out[a] = here + total


class PairFilter:
    """``S`` of ``cloud`` with a reach of ``width`` spacings."""

    def __init__(self, cloud: Cloud, *, width: float) -> None:
        self.width = width
        pairs, k, _ = weighted_pairs(cloud, width)
        d = _balanced(k, pairs, cloud.V)
        row, column = pairs.row_of_pair, pairs.indices
        weight = (d[row] * d[column]) * k * cloud.V[column]
        # A particle's own weight is what is left of one.
        other = row != column
        count = np.bincount(row[other], minlength=pairs.rows)
        self._indptr = np.concatenate([[0], np.cumsum(count)]).astype(np.uint64)
        self._indices, self._weight = column[other], weight[other]

    @property
    def mean_neighbours(self) -> float:
        """Others that count, a particle."""
        return len(self._indices) / (len(self._indptr) - 1)

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)``; ``out`` is not ``f``."""
        _smooth(self._indptr, self._indices, self._weight, f, out)

    @property
    def description(self) -> str:
        """Which filter it is."""
        return f"{self.width:g} spacings wide, {self.mean_neighbours:.1f} neighbours"


class WeightedPairs(NamedTuple):
    """Pairs with ``k (P,)`` and ``d (P, 3)``, the offset to the neighbour over the reach."""

    pairs: PairList
    k: Array
    d: Array


def weighted_pairs(cloud: Cloud, width: float) -> WeightedPairs:
    """Who lies within ``width`` spacings and sees whom, each particle itself included."""
    lengths = cloud.lengths
    within = lengths.pairs(cloud.X, cloud.X, width / lengths.h_over_dx)
    pairs = cloud.sight.seen(cloud.X, within)
    h = np.broadcast_to(lengths.of_pairs(cloud.X, pairs), pairs.pairs)
    d = offsets(cloud.X, cloud.X, pairs) / (width / lengths.h_over_dx * h)[:, None]
    return WeightedPairs(pairs, np.maximum(1.0 - np.linalg.norm(d, axis=1), 0.0), d)


def _balanced(k: Array, pairs: PairList, V: Array) -> Array:
    """``d (N,)`` with ``d_a sum_b k_ab V_b d_b = 1``, to round-off or as near as it gets."""
    matrix = csr_array(
        (k * V[pairs.indices], pairs.indices.astype(np.int64), pairs.indptr),
        shape=(pairs.rows, pairs.rows),
    )
    d = 1.0 / np.sqrt(matrix @ np.ones(pairs.rows))
    nearest = np.inf
    for _ in range(_MOST_ITERATIONS):
        total = matrix @ d
        error = float(np.max(np.abs(d * total - 1.0)))
        if error <= _ROUND_OFF or (error < 1.0e-13 and error >= nearest):
            return d
        nearest = error
        d = np.sqrt(d / total)
    raise InputError(
        f"no filter on this cloud: after {_MOST_ITERATIONS} iterations the weights of a particle "
        f"still miss one by {error:.1e}; use a larger width or a mesh that is less graded"
    )
