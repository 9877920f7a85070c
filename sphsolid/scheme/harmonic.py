"""The harmonic operator of a cloud, corrected a priori so that it is blind to linear fields.

With ``d = X_b - X_a``, ``r = |d|`` and the form of [Brookshaw1985]

    B_ab = -2 V_b W'(r) / r  6 / m_a,      m_a = -sum_b 2 V_b W'(r) r,
    (lap f)_a = sum_b B_ab [1 + lambda_a . d] (f_b - f_a),

``m_a`` makes the trace of the second moment that of a Laplacian, where a support is cut off too,
and ``lambda_a`` makes ``sum_b B_ab [1 + lambda_a . d] d = 0``.  So an affine motion has no
Laplacian anywhere.  Second derivatives that a cut support does not hold, normal to a face with one
layer of neighbours, are left out.  The correction of [Lee2016] is not printed in [Lee2017]: this
one is our choice.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from sphsolid.cloud.cloud import Cloud
from sphsolid.errors import require
from sphsolid.scheme.support_pairs import SupportPairs, support_pairs

Array = NDArray[np.float64]


def harmonic_operator(cloud: Cloud, *, corrected: bool = True) -> csr_array:
    """``lap (N, N)`` [1/m^2], rows that sum to zero.

    ``corrected=False`` leaves ``lambda`` out.  Raises ``InputError`` where the neighbours of a
    particle do not span three dimensions.
    """
    pairs, size = support_pairs(cloud), cloud.size
    share = -2.0 * cloud.V[pairs.column] * pairs.slope / pairs.r
    moment = np.bincount(pairs.row, share * pairs.r**2, minlength=size)
    require(
        bool(np.all(moment > 0.0)),
        "a particle has no neighbour within its support; raise h_over_dx",
    )
    B = share * (6.0 / moment)[pairs.row]
    if corrected:
        B = B * (1.0 + np.einsum("pi,pi->p", _correction(B, pairs, size)[pairs.row], pairs.d))
    matrix = csr_array(
        (B, pairs.column.astype(np.int64), pairs.indptr.astype(np.int64)), shape=(size, size)
    )
    return csr_array(matrix - diags_array(matrix.sum(axis=1)))


def _correction(B: Array, pairs: SupportPairs, size: int) -> Array:
    """``lambda (N, 3)`` [1/m]."""
    first = np.zeros((size, 3))
    second = np.zeros((size, 3, 3))
    np.add.at(first, pairs.row, B[:, None] * pairs.d)
    np.add.at(second, pairs.row, B[:, None, None] * pairs.d[:, :, None] * pairs.d[:, None, :])
    return np.asarray(-np.linalg.solve(second, first[:, :, None])[:, :, 0])
