"""Solving on a coarse space of splines: what a preconditioner needs for smooth errors.

The matrix ``P^T S P`` of splines along the longest axis is one of blocks, each coupled to the few
next ones (``PlaneMatrix``).  So is its Cholesky factor.  On a cube of 25 splines a side that is a
twentieth of the work of the dense one.  Its null space are polynomials that every spline space
holds.  It is pinned: as many coefficients as it has dimensions get one added to their diagonal.
Where the right-hand side is orthogonal to the null space, these coefficients come out as zero.
What is added then changes the solution by a null vector only, which is taken out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.linalg import cholesky, qr, solve_triangular

from sphsolid.cloud.splines.plane_matrix import PlaneMatrix
from sphsolid.cloud.splines.spline_space import Splines

Array = NDArray[np.float64]


class CoarseSolution:
    """``z -> P (P^T S P)^+ P^T z`` for ``matrix = P^T S P`` with the null space ``null``.

    ``null (splines.size, m)`` are coefficients.  The matrix is scaled by its diagonal, or by
    ``least (size,)`` in the order of its rows where that is larger.  Then ``shift`` is added to the
    diagonal, whose entries are one.  It is there for functions that reach no particle, whose row is
    empty.  It also keeps other null vectors from being blown up by more than ``1 / shift``.

    ``dtype`` is that of the stored factor; every application reads all of it.  ``F^T F`` with a
    rounded ``F`` is as positive as the exact one, and that is all that a preconditioner must be.
    """

    def __init__(
        self,
        splines: Splines,
        matrix: PlaneMatrix,
        null: Array,
        *,
        shift: float,
        least: Array | None = None,
        dtype: DTypeLike = np.float64,
    ) -> None:
        self._splines, self._order, self._dtype = splines, matrix.order, dtype
        diagonal = matrix.diagonal
        if least is not None:
            diagonal = np.maximum(diagonal, least)
        root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        # Coefficients of functions that reach no particle are free: counted with the null space,
        # they would be pinned in place of those that matter.
        reached = (matrix.diagonal > 0.0)[:, None]
        self._null = np.linalg.qr(np.where(reached, null[matrix.order] / root[:, None], 0.0))[0]
        # Coefficients on which the null space can be read most safely.
        pins = qr(self._null.T, mode="r", pivoting=True)[1][: null.shape[1]]
        extra = np.full(len(root), shift)
        extra[diagonal <= 0.0] = 1.0
        extra[pins] += 1.0
        self._root = root
        blocks = matrix.blocks
        n = blocks.shape[2]
        rows = root.reshape(-1, n)
        for i in range(len(blocks)):
            for r in range(min(i, blocks.shape[1] - 1) + 1):
                blocks[i, r] *= rows[i, :, None] * rows[i - r]
            blocks[i, 0][np.diag_indices(n)] += extra.reshape(-1, n)[i]
        _factorise(blocks)
        self._factor = blocks.astype(dtype)

    def add(self, z: Array, out: Array) -> None:
        """Add the solution for ``z (N, 10, 3)`` to ``out (N, 10, 3)``."""
        right = np.empty((self._splines.size, 3))
        self._splines.restrict(z, right)
        self._splines.prolong(self.solve(right), out)

    def solve(self, right: Array) -> Array:
        """Coefficients ``(size, 3)`` from ``P^T z (size, 3)``."""
        b = self._without_null(right[self._order] * self._root[:, None])
        # Scaled, because the residual's square may be below the range of single precision.
        size = float(np.max(np.abs(b))) or 1.0
        x = np.asarray(b / size, dtype=self._dtype)
        _substitute(self._factor, x.reshape(len(self._factor), -1, 3))
        solved = self._without_null(np.asarray(x, dtype=np.float64)) * size
        out = np.empty_like(right)
        out[self._order] = solved * self._root[:, None]
        return out

    def _without_null(self, values: Array) -> Array:
        return np.asarray(values - self._null @ (self._null.T @ values))


class NoCoarseSolution:
    """Adds nothing."""

    def add(self, z: Array, out: Array) -> None:
        """Leave ``out`` as it is."""


def _factorise(blocks: Array) -> None:
    """Cholesky factor in place, with the inverses of its diagonal blocks in their place."""
    reach = blocks.shape[1] - 1
    identity = np.eye(blocks.shape[2])
    for i in range(len(blocks)):
        first = max(0, i - reach)
        for j in range(first, i + 1):
            block = blocks[i, i - j]
            for k in range(max(first, j - reach), j):
                block -= blocks[i, i - k] @ blocks[j, j - k].T
            if j < i:
                block[...] = block @ blocks[j, 0].T
        factor = cholesky(blocks[i, 0], lower=True, check_finite=False)
        blocks[i, 0] = solve_triangular(factor, identity, lower=True, check_finite=False)


def _substitute(factor: Array, x: Array) -> None:
    """Solve in place for ``x (planes, n, 3)``."""
    planes, reach = len(factor), factor.shape[1] - 1
    for i in range(planes):
        for r in range(1, min(i, reach) + 1):
            x[i] -= factor[i, r] @ x[i - r]
        x[i] = factor[i, 0] @ x[i]
    for i in reversed(range(planes)):
        for r in range(1, min(planes - 1 - i, reach) + 1):
            x[i] -= factor[i + r, r].T @ x[i + r]
        x[i] = factor[i, 0].T @ x[i]
