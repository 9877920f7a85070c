"""The system whose solution makes rows of a skew-symmetric matrix exact (see ``skew_change``).

For multipliers ``l_a (10,)`` the entries ``A_ab = w_ab [psi(a, b) . l_a - psi(b, a) . l_b]`` are
skew, with the ten monomials ``psi(a, b)`` of ``(X_b - X_a) / scale_a``.  The matrix takes ``l`` to
the row moments ``sum_b A_ab psi(a, b)``, plus ``epsilon`` times its quadratic part: symmetric,
never negative, and applied pair by pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.compiled import kernel, prange, register_jitable

Array = NDArray[np.float64]
#: Multipliers a particle: the monomials up to degree two.
TERMS = 10
#: Axes, counted from 1, whose products are the six quadratics.
_QUADRATICS = [(i, j) for i in (1, 2, 3) for j in range(i, 4)]


@dataclass(frozen=True)
class SkewProblem:
    """Pairs, positions and weights of the system.

    ``X (N, 3)`` [m]; ``scale (N,)`` [m]; ``weights (P,)`` symmetric and positive; ``epsilon (N,)``
    what is added to the diagonal of the quadratic multipliers.
    """

    pairs: PairList
    X: Array
    scale: Array
    weights: Array
    epsilon: Array

    def row_moments(self, A: Array) -> Array:
        """``sum_b A_ab psi(a, b)  (N, 10, 3)`` of pair values ``A (P, 3)``."""
        out = np.empty((self.pairs.rows, TERMS, 3))
        _row_moments(self.pairs.indptr, self.pairs.indices, self.X, self.scale, A, out)
        return out

    def change(self, multipliers: Array) -> Array:
        """``A - A0  (P, 3)``."""
        out = np.empty((self.pairs.pairs, 3))
        _change(*self.arrays, multipliers, out)
        return out

    def apply(self, multipliers: Array, out: Array) -> None:
        """The system's matrix times ``(N, 10, 3)``."""
        _apply(*self.arrays, self.epsilon, multipliers, out)

    def null_space(self) -> Array:
        """Orthonormal ``(10 N, 10)``: ``s, grad s / 2, 0`` of every quadratic ``s``."""
        low, high = self.X.min(axis=0), self.X.max(axis=0)
        half = 0.5 * float(np.max(high - low))
        x = (self.X - 0.5 * (low + high)) / half
        slope = 0.5 * self.scale / half
        columns = []
        for i, j in [(0, 0), (0, 1), (0, 2), (0, 3), *_QUADRATICS]:
            f, df = _power(x, i)
            g, dg = _power(x, j)
            values = np.zeros((len(x), TERMS))
            values[:, 0] = f * g
            values[:, 1:4] = slope[:, None] * (df * g[:, None] + f[:, None] * dg)
            columns.append(values.ravel())
        return np.linalg.qr(np.stack(columns, axis=1))[0]

    @property
    def arrays(self) -> tuple[Any, ...]:
        """What the kernels take first."""
        p = self.pairs
        return (p.indptr, p.indices, self.X, self.scale, self.weights)

    def blocks(self) -> Array:
        """Diagonal blocks ``(N, 10, 10)``."""
        out = np.empty((self.pairs.rows, TERMS, TERMS))
        _blocks(*self.arrays, self.epsilon, out)
        return out


def _power(x: Array, axis: int) -> tuple[Array, Array]:
    """Coordinate ``axis``, counted from 1, and its gradient; axis 0 is the constant 1."""
    gradient = np.zeros_like(x)
    if axis == 0:
        return np.ones(len(x)), gradient
    gradient[:, axis - 1] = 1.0
    return x[:, axis - 1], gradient


@register_jitable
def monomials(x, y, z):  # type: ignore[no-untyped-def]
    """``psi``: the ten monomials of an offset in units of the spacing."""
    return (1.0, x, y, z, 0.5 * x * x, 0.5 * y * y, 0.5 * z * z, x * y, x * z, y * z)


@kernel
def _row_moments(indptr, indices, X, scale, A, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for i in range(10):
            for c in range(3):
                out[a, i, c] = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            x = (X[b, 0] - X[a, 0]) / scale[a]
            y = (X[b, 1] - X[a, 1]) / scale[a]
            z = (X[b, 2] - X[a, 2]) / scale[a]
            psi = monomials(x, y, z)
            for i in range(10):
                for c in range(3):
                    out[a, i, c] += psi[i] * A[k, c]


@kernel
def _blocks(indptr, indices, X, scale, w, epsilon, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for i in range(10):
            for j in range(10):
                out[a, i, j] = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            if b != a:
                x = (X[b, 0] - X[a, 0]) / scale[a]
                y = (X[b, 1] - X[a, 1]) / scale[a]
                z = (X[b, 2] - X[a, 2]) / scale[a]
                psi = monomials(x, y, z)
                for i in range(10):
                    for j in range(10):
                        out[a, i, j] += w[k] * psi[i] * psi[j]
        for i in range(4, 10):
            out[a, i, i] += epsilon[a]


@kernel
def _apply(indptr, indices, X, scale, w, epsilon, given, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        acc = np.zeros((10, 3))
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            dx, dy, dz = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
            x, y, z = dx / scale[a], dy / scale[a], dz / scale[a]
            u, v, t = -dx / scale[b], -dy / scale[b], -dz / scale[b]
            psi = monomials(x, y, z)
            chi = monomials(u, v, t)
            d0 = 0.0
            d1 = 0.0
            d2 = 0.0
            for i in range(10):
                d0 += psi[i] * given[a, i, 0] - chi[i] * given[b, i, 0]
                d1 += psi[i] * given[a, i, 1] - chi[i] * given[b, i, 1]
                d2 += psi[i] * given[a, i, 2] - chi[i] * given[b, i, 2]
            d0 *= w[k]
            d1 *= w[k]
            d2 *= w[k]
            for i in range(10):
                acc[i, 0] += psi[i] * d0
                acc[i, 1] += psi[i] * d1
                acc[i, 2] += psi[i] * d2
        for i in range(10):
            extra = epsilon[a] if i >= 4 else 0.0
            for c in range(3):
                out[a, i, c] = acc[i, c] + extra * given[a, i, c]


@kernel
def _change(indptr, indices, X, scale, w, given, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            dx, dy, dz = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
            x, y, z = dx / scale[a], dy / scale[a], dz / scale[a]
            u, v, t = -dx / scale[b], -dy / scale[b], -dz / scale[b]
            psi = monomials(x, y, z)
            chi = monomials(u, v, t)
            for c in range(3):
                d = 0.0
                for i in range(10):
                    d += psi[i] * given[a, i, c] - chi[i] * given[b, i, c]
                out[k, c] = w[k] * d
