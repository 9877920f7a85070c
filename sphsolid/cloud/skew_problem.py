"""The system whose solution makes rows of a skew-symmetric matrix exact (see ``skew_change``).

For multipliers ``l_a (10,)`` the entries ``A_ab = w_ab [psi(a, b) . l_a - psi(b, a) . l_b]`` are
skew, with the ten monomials ``psi(a, b)`` of ``X_b - X_a``.  The matrix takes ``l`` to the row
moments ``sum_b A_ab psi(a, b)``, plus ``epsilon`` times its quadratic part: symmetric, never
negative, and applied pair by pair.

Positions come in units of the spacing, counted from the middle of the body.  What is computed from
them is then the same in every unit and at every place.  ``psi(b, a)`` is ``psi(a, b)`` with the
signs of the linears turned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lanes import WIDTH, lanes_of, no_lanes, set_lanes
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

    ``X (N, 3)`` in spacings; ``weights (P,)`` symmetric and positive; ``epsilon (N,)`` what is
    added to the diagonal of the quadratic multipliers.
    """

    pairs: PairList
    X: Array
    weights: Array
    epsilon: Array

    def row_moments(self, A: Array) -> Array:
        """``sum_b A_ab psi(a, b)  (N, 10, 3)`` of pair values ``A (P, 3)``."""
        out = np.empty((self.pairs.rows, TERMS, 3))
        _row_moments(self.pairs.indptr, self.pairs.indices, self.X, A, out)
        return out

    def change(self, multipliers: Array) -> Array:
        """``A - A0  (P, 3)`` of multipliers ``(N, 10, 3)``."""
        out = np.empty((self.pairs.pairs, 3))
        _change(*self.arrays, multipliers, out)
        return out

    def apply(self, multipliers: Array, out: Array) -> None:
        """The system's matrix times ``(N, 10, 4)``: three components and one that is not used."""
        _apply(*self.arrays, self.epsilon, multipliers, out)

    def reduce(self, multipliers: Array, residual: Array) -> None:
        """Take the matrix times ``multipliers`` off ``residual``, both ``(N, 10, 4)``."""
        _reduce(*self.arrays, self.epsilon, multipliers, residual)

    def null_space(self) -> Array:
        """Orthonormal ``(10 N, 10)``: ``s, grad s / 2, 0`` of every quadratic ``s``."""
        low, high = self.X.min(axis=0), self.X.max(axis=0)
        half = 0.5 * float(np.max(high - low))
        x = (self.X - 0.5 * (low + high)) / half
        slope = 0.5 / half
        columns = []
        for i, j in [(0, 0), (0, 1), (0, 2), (0, 3), *_QUADRATICS]:
            f, df = _power(x, i)
            g, dg = _power(x, j)
            values = np.zeros((len(x), TERMS))
            values[:, 0] = f * g
            values[:, 1:4] = slope * (df * g[:, None] + f[:, None] * dg)
            columns.append(values.ravel())
        return np.linalg.qr(np.stack(columns, axis=1))[0]

    @property
    def arrays(self) -> tuple[Any, ...]:
        """What the kernels take first."""
        return (self.pairs.indptr, self.pairs.indices, self.X, self.weights)

    def blocks(self) -> Array:
        """Diagonal blocks ``(N, 10, 10)``."""
        out = np.empty((self.pairs.rows, TERMS, TERMS))
        _blocks(*self.arrays, self.epsilon, out)
        return out


def in_lanes(values: Array) -> Array:
    """``(N, 10, 3)`` as ``(N, 10, 4)``, the last of which is zero."""
    out = np.zeros((*values.shape[:2], WIDTH))
    out[:, :, :3] = values
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
def _row_moments(indptr, indices, X, A, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for i in range(10):
            for c in range(3):
                out[a, i, c] = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            psi = monomials(X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2])
            for i in range(10):
                for c in range(3):
                    out[a, i, c] += psi[i] * A[k, c]


@kernel
def _blocks(indptr, indices, X, w, epsilon, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for i in range(10):
            for j in range(10):
                out[a, i, j] = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            if b != a:
                psi = monomials(X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2])
                for i in range(10):
                    for j in range(10):
                        out[a, i, j] += w[k] * psi[i] * psi[j]
        for i in range(4, 10):
            out[a, i, i] += epsilon[a]


@register_jitable
def _row(a, indptr, indices, X, w, epsilon, given):  # type: ignore[no-untyped-def]
    """Row ``a`` of the matrix times ``given``: ten lanes."""
    g0, g1, g2 = lanes_of(given, a, 0), lanes_of(given, a, 1), lanes_of(given, a, 2)
    g3, g4, g5 = lanes_of(given, a, 3), lanes_of(given, a, 4), lanes_of(given, a, 5)
    g6, g7, g8 = lanes_of(given, a, 6), lanes_of(given, a, 7), lanes_of(given, a, 8)
    g9 = lanes_of(given, a, 9)
    s0 = s1 = s2 = s3 = no_lanes()
    # What epsilon adds comes first, so that nothing is kept for later.
    e = epsilon[a]
    s4, s5, s6, s7, s8, s9 = e * g4, e * g5, e * g6, e * g7, e * g8, e * g9
    for k in range(indptr[a], indptr[a + 1]):
        b = indices[k]
        _, x, y, z, xx, yy, zz, xy, xz, yz = monomials(
            X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
        )
        # psi(a, b) . l_a - psi(b, a) . l_b: of odd monomials the sum, of even ones the difference.
        d = (
            (g0 - lanes_of(given, b, 0))
            + (x * (g1 + lanes_of(given, b, 1)) + y * (g2 + lanes_of(given, b, 2)))
            + (z * (g3 + lanes_of(given, b, 3)) + xx * (g4 - lanes_of(given, b, 4)))
        ) + (
            (yy * (g5 - lanes_of(given, b, 5)) + zz * (g6 - lanes_of(given, b, 6)))
            + (xy * (g7 - lanes_of(given, b, 7)) + xz * (g8 - lanes_of(given, b, 8)))
            + yz * (g9 - lanes_of(given, b, 9))
        )
        d = w[k] * d
        s0 = s0 + d
        s1, s2, s3 = s1 + x * d, s2 + y * d, s3 + z * d
        s4, s5, s6 = s4 + xx * d, s5 + yy * d, s6 + zz * d
        s7, s8, s9 = s7 + xy * d, s8 + xz * d, s9 + yz * d
    return s0, s1, s2, s3, s4, s5, s6, s7, s8, s9


@kernel
def _apply(indptr, indices, X, w, epsilon, given, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        s = _row(a, indptr, indices, X, w, epsilon, given)
        set_lanes(out, a, 0, s[0])
        set_lanes(out, a, 1, s[1])
        set_lanes(out, a, 2, s[2])
        set_lanes(out, a, 3, s[3])
        set_lanes(out, a, 4, s[4])
        set_lanes(out, a, 5, s[5])
        set_lanes(out, a, 6, s[6])
        set_lanes(out, a, 7, s[7])
        set_lanes(out, a, 8, s[8])
        set_lanes(out, a, 9, s[9])


@kernel
def _reduce(indptr, indices, X, w, epsilon, given, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        s = _row(a, indptr, indices, X, w, epsilon, given)
        set_lanes(out, a, 0, lanes_of(out, a, 0) - s[0])
        set_lanes(out, a, 1, lanes_of(out, a, 1) - s[1])
        set_lanes(out, a, 2, lanes_of(out, a, 2) - s[2])
        set_lanes(out, a, 3, lanes_of(out, a, 3) - s[3])
        set_lanes(out, a, 4, lanes_of(out, a, 4) - s[4])
        set_lanes(out, a, 5, lanes_of(out, a, 5) - s[5])
        set_lanes(out, a, 6, lanes_of(out, a, 6) - s[6])
        set_lanes(out, a, 7, lanes_of(out, a, 7) - s[7])
        set_lanes(out, a, 8, lanes_of(out, a, 8) - s[8])
        set_lanes(out, a, 9, lanes_of(out, a, 9) - s[9])


@kernel
def _change(indptr, indices, X, w, given, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            x, y, z = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
            psi, chi = monomials(x, y, z), monomials(-x, -y, -z)
            for c in range(3):
                d = 0.0
                for i in range(10):
                    d += psi[i] * given[a, i, c] - chi[i] * given[b, i, c]
                out[k, c] = w[k] * d
