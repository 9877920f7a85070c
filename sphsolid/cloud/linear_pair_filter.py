"""A filter on any cloud that keeps linear functions and is symmetric in the volumes.

With ``L`` the value at a particle of the linear function that fits those around it best, weighted
by ``k_ab V_b`` (see ``pair_filter``), the rest ``R = I - L`` is zero of linear functions, at the
boundary too, and

    S = I - c V^-1 R^T V R,        V_a S_ab = V_b S_ba,        S 1 = 1,        S X = X.

It is what fourth differences are along lines.  ``c`` is one, or less where ``R`` magnifies
something (its largest singular value in the volumes, by the power method), so that no wave is
turned round.  Constants come out to the last bit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.pair_filter import weighted_pairs
from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]
#: Below this share of the widest direction neighbours count as lying in a plane or a line.
_FLAT = 1.0e-3
_ITERATIONS = 100


@kernel
def _rest(indptr, indices, weight, f, out):  # type: ignore[no-untyped-def]
    """``out = R f``; ``weight`` is ``L`` without its diagonal."""
    for a in prange(len(out)):
        here, total = f[a], 0.0
        for k in range(indptr[a], indptr[a + 1]):
            total += weight[k] * (f[indices[k]] - here)
        out[a] = -total


@kernel
def _take(indptr, indices, weight, rest, f, out):  # type: ignore[no-untyped-def]
    """``out = f - c V^-1 R^T V rest``; ``out`` may be ``f``."""
    for a in prange(len(out)):
        total = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            total += weight[k] * rest[indices[k]]
        out[a] = f[a] - total


class LinearPairFilter:
    """``S`` of ``cloud`` with a reach of ``width`` spacings."""

    def __init__(self, cloud: Cloud, *, width: float) -> None:
        self.width = width
        L = _linear_fit(cloud, width)
        V, size = cloud.V, cloud.size
        R = csr_array(diags_array(np.ones(size)) - L)
        share = 1.0 / max(1.0, _largest(R, V))
        back = csr_array(diags_array(share / V) @ R.T @ diags_array(V))
        back.sort_indices()
        other = csr_array(L - diags_array(L.diagonal()))
        other.eliminate_zeros()
        other.sort_indices()
        self._fit = _rows(other)
        self._back = _rows(back)

    @property
    def mean_neighbours(self) -> float:
        """Others that a fit takes into account, a particle."""
        return len(self._fit[1]) / (len(self._fit[0]) - 1)

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)``; ``work`` is overwritten."""
        _rest(*self._fit, f, work)
        _take(*self._back, work, f, out)

    @property
    def description(self) -> str:
        """Which filter it is."""
        return f"linear fits {self.width:g} spacings wide, {self.mean_neighbours:.1f} neighbours"


def _rows(matrix: csr_array) -> tuple[NDArray[np.uint64], NDArray[np.uint32], Array]:
    return (
        matrix.indptr.astype(np.uint64), matrix.indices.astype(np.uint32),
        matrix.data.astype(np.float64),
    )  # fmt: skip


def _linear_fit(cloud: Cloud, width: float) -> csr_array:
    """``L (N, N)``: ``sum_b L_ab f_b`` is ``f_a`` of every linear function."""
    found = weighted_pairs(cloud, width)
    pairs, row, size = found.pairs, found.pairs.row_of_pair, cloud.size
    weight = found.k * cloud.V[pairs.indices]
    weight = weight / np.bincount(row, weight, size)[row]
    middle = np.stack([np.bincount(row, weight * d, size) for d in found.d.T], axis=1)
    d = found.d - middle[row]
    moments = np.empty((size, 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(row, weight * d[:, i] * d[:, j], size)
    # In a direction in which there is nobody, nothing is fitted.
    slope = np.einsum("aij,aj->ai", np.linalg.pinv(moments, rcond=_FLAT, hermitian=True), middle)
    value = weight * (1.0 - np.einsum("pi,pi->p", d, slope[row]))
    return csr_array(
        (value, pairs.indices.astype(np.int64), pairs.indptr), shape=(size, size)
    )


def _largest(R: csr_array, V: Array) -> float:
    """Largest eigenvalue of ``V^-1 R^T V R``, from below, by the power method."""
    f = np.random.default_rng(0).uniform(-1.0, 1.0, len(V))
    largest = 0.0
    for _ in range(_ITERATIONS):
        size = float(np.sum(V * f * f))
        if size == 0.0:
            break
        rest = R @ f
        largest = max(largest, float(np.sum(V * rest * rest)) / size)
        f = (R.T @ (V * rest)) / V / np.sqrt(size)
    return largest
