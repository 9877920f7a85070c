"""The least skew-symmetric change with given row moments: the linear algebra of summation by parts.

Among skew ``A`` on a symmetric list of pairs, near to a skew ``A0``, with

    sum_b A_ab psi_i(a, b) = target_ai   exactly for i in {1, x, y, z}, in the mean for quadratics,

the minimiser of ``sum |A_ab - A0_ab|^2 / w_ab + sum_a |rest_a|^2 / (epsilon w)``, ``rest`` what is
left of the quadratic moments, is

    A_ab = A0_ab + w_ab [ psi(a, b) . l_a - psi(b, a) . l_b ],

with ten multipliers a particle and the ten monomials ``psi(a, b)`` of ``(X_b - X_a) / scale_a``.
They solve one symmetric system, the same for the three components of the gradient.  In the long run
of wave lengths it acts like a sixth-order operator, so it is solved by conjugate gradients with two
preconditioners added up: the inverses of the diagonal blocks, and an exact solution on a coarse
space of splines, which holds what the blocks do not see.  Its null space, the quadratics
(``s, grad s / 2``), is in the coarse space and orthogonal to the right-hand side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from sphsolid.cloud.neighbours import PairList
from sphsolid.cloud.spline_space import Splines, ten_values
from sphsolid.compiled import kernel, prange, register_jitable, serial_kernel

Array = NDArray[np.float64]
#: Multipliers a particle: the monomials up to degree two.
TERMS = 10
#: The coarse grid is this many spacings wide, or wider, so that it has no more functions than ...
COARSE_SPACINGS = 3.0
MOST_COARSE = 4000
#: A residual that has grown this much says that there is no solution.
HOPELESS = 1.0e8
#: Particles whose pairs are summed into the coarse matrix: with a quarter of them on 33^3 particles
#: the iterations rise by two thirds.
MOST_SAMPLED = 40_000


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
        _change(*self._arrays, multipliers, out)
        return out

    def apply(self, multipliers: Array, out: Array) -> None:
        """The system's matrix times ``(N, 10, 3)``."""
        _apply(*self._arrays, self.epsilon, multipliers, out)

    @property
    def _arrays(self) -> tuple[Any, ...]:
        p = self.pairs
        return (p.indptr, p.indices, self.X, self.scale, self.weights)

    def blocks(self) -> Array:
        """Diagonal blocks ``(N, 10, 10)``."""
        out = np.empty((self.pairs.rows, TERMS, TERMS))
        _blocks(*self._arrays, self.epsilon, out)
        return out

    def coarse(self, splines: Splines) -> Array:
        """Lower half of the matrix on the coarse space, from the pairs of some particles."""
        stride = -(-self.pairs.rows // MOST_SAMPLED)
        out = np.zeros((splines.size, splines.size))
        _coarse(
            *self._arrays, self.epsilon, splines.order, splines.cell, splines.N, splines.D,
            splines.E, splines.shape, stride, out,
        )
        return out


@dataclass(frozen=True)
class Multipliers:
    """Solution ``values (N, 10, 3)``, iterations, and what is left of the right-hand side."""

    values: Array
    iterations: int
    remainder: float


def solve(
    problem: SkewProblem, right: Array, *, tolerance: float, most_iterations: int
) -> Multipliers:
    """Conjugate gradients until the residual's largest entry is ``tolerance`` of the first.

    Totals are plain numpy sums, whose order does not depend on the number of threads.
    """
    preconditioner = _Preconditioner(problem)
    scale = float(np.max(np.abs(right)))
    values = np.zeros_like(right)
    if scale == 0.0:
        return Multipliers(values, 0, 0.0)
    residual, applied = right.copy(), np.empty_like(right)
    z = preconditioner(residual)
    direction = z.copy()
    rz = np.einsum("nic,nic->c", residual, z)
    left = 1.0
    for iteration in range(most_iterations):
        left = float(np.max(np.abs(residual))) / scale
        if left <= tolerance or left > HOPELESS:
            return Multipliers(values, iteration, left)
        problem.apply(direction, applied)
        curvature = np.einsum("nic,nic->c", direction, applied)
        step = np.divide(rz, curvature, out=np.zeros(3), where=curvature > 0.0)
        values += step * direction
        residual -= step * applied
        z = preconditioner(residual)
        fresh = np.einsum("nic,nic->c", residual, z)
        direction *= np.divide(fresh, rz, out=np.zeros(3), where=rz > 0.0)
        direction += z
        rz = fresh
    return Multipliers(values, most_iterations, left)


class _Preconditioner:
    """Inverse diagonal blocks plus the coarse solution."""

    def __init__(self, problem: SkewProblem) -> None:
        self._inverse = np.linalg.inv(problem.blocks())
        X = problem.X
        spacing = float(np.mean(problem.scale))
        volume = float(np.prod(np.maximum(np.ptp(X, axis=0), spacing)))
        edge = max(COARSE_SPACINGS * spacing, (volume / MOST_COARSE) ** (1.0 / 3.0))
        self._splines = Splines(X, problem.scale, edge)
        while self._splines.size > 1.5 * MOST_COARSE:
            edge *= 1.1
            self._splines = Splines(X, problem.scale, edge)
        matrix = problem.coarse(self._splines)
        diagonal = np.diag(matrix).copy()
        # Functions that reach no particle have an empty row; a little on the diagonal carries them
        # and those that hardly reach one.
        self._root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        matrix *= self._root[:, None] * self._root
        null = np.linalg.qr(self._splines.quadratics() / self._root[:, None])[0]
        matrix += null @ null.T
        matrix[np.diag_indices(len(matrix))] += 1.0e-9
        self._factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)

    def __call__(self, z: Array) -> Array:
        """``M^-1 z  (N, 10, 3)``."""
        out = np.empty_like(z)
        _times_blocks(self._inverse, z, out)
        coarse = np.empty((self._splines.size, 3))
        self._splines.restrict(z, coarse)
        coarse *= self._root[:, None]
        solved = cho_solve(self._factor, coarse, check_finite=False) * self._root[:, None]
        self._splines.prolong(solved, out)
        return out


@register_jitable
def _monomials(x, y, z):  # type: ignore[no-untyped-def]
    """``psi``: the ten monomials of an offset in units of the spacing."""
    return (1.0, x, y, z, 0.5 * x * x, 0.5 * y * y, 0.5 * z * z, x * y, x * z, y * z)


@kernel
def _times_blocks(inverse, z, out):  # type: ignore[no-untyped-def]
    for a in prange(len(z)):
        for i in range(10):
            t0 = 0.0
            t1 = 0.0
            t2 = 0.0
            for j in range(10):
                t0 += inverse[a, i, j] * z[a, j, 0]
                t1 += inverse[a, i, j] * z[a, j, 1]
                t2 += inverse[a, i, j] * z[a, j, 2]
            out[a, i, 0] = t0
            out[a, i, 1] = t1
            out[a, i, 2] = t2


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
            psi = _monomials(x, y, z)
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
                psi = _monomials(x, y, z)
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
            psi = _monomials(x, y, z)
            chi = _monomials(u, v, t)
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
            psi = _monomials(x, y, z)
            chi = _monomials(u, v, t)
            for c in range(3):
                d = 0.0
                for i in range(10):
                    d += psi[i] * given[a, i, c] - chi[i] * given[b, i, c]
                out[k, c] = w[k] * d


@serial_kernel
def _coarse(  # type: ignore[no-untyped-def]
    indptr, indices, X, scale, w, epsilon, order, cell, N, D, E, shape, stride, out
):
    columns = np.empty(128, dtype=np.int64)
    values = np.empty(128)
    bend = np.empty((64, 6))
    # Cell by cell, so that the rows of the matrix in use stay in the cache.
    for place in range(0, len(order), stride):
        a = order[place]
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            if b == a:
                # The particle's own entry stands for the diagonal of the quadratic multipliers.
                _side(a, 0.0, 0.0, 0.0, 1.0, cell, N, D, E, shape, 0, False, columns, values, bend)
                for m in range(6):
                    for i in range(64):
                        scaled = stride * epsilon[a] * bend[i, m]
                        for j in range(i + 1):
                            out[columns[i], columns[j]] += scaled * bend[j, m]
                continue
            if stride == 1 and b < a:
                continue
            same = True
            for d in range(3):
                same = same and cell[a, d] == cell[b, d]
            x, y, z = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
            s, q = scale[a], scale[b]
            _side(
                a, x / s, y / s, z / s, 1.0, cell, N, D, E, shape, 0, False, columns, values, bend
            )
            first = 0 if same else 64
            _side(
                b, -x / q, -y / q, -z / q, -1.0, cell, N, D, E, shape, first, same, columns, values,
                bend,
            )  # fmt: skip
            weight = w[k] * (1.0 if stride == 1 else 0.5 * stride)
            for begin in range(0, first + 1, 64):
                for i in range(begin, begin + 64):
                    scaled = weight * values[i]
                    for j in range(begin, i + 1):
                        out[columns[i], columns[j]] += scaled * values[j]
            if not same:
                for i in range(64):
                    scaled = weight * values[i]
                    for j in range(64, 128):
                        high, low = columns[i], columns[j]
                        if high == low:
                            out[high, low] += 2.0 * scaled * values[j]
                        elif high > low:
                            out[high, low] += scaled * values[j]
                        else:
                            out[low, high] += scaled * values[j]


@register_jitable
def _side(  # type: ignore[no-untyped-def]
    p, x, y, z, sign, cell, N, D, E, shape, entry, adds, columns, values, bend
):
    """``sign psi . l_p`` of the 64 splines that reach particle ``p``, and their curvatures."""
    psi = _monomials(x, y, z)
    spline = 0
    for i in range(4):
        for j in range(4):
            row = ((cell[p, 0] + i) * shape[1] + cell[p, 1] + j) * shape[2] + cell[p, 2]
            for k in range(4):
                v = ten_values(
                    N[p, 0, i], N[p, 1, j], N[p, 2, k], D[p, 0, i], D[p, 1, j], D[p, 2, k],
                    E[p, 0, i], E[p, 1, j], E[p, 2, k],
                )  # fmt: skip
                value = 0.0
                for m in range(10):
                    value += psi[m] * v[m]
                for m in range(6):
                    bend[spline, m] = v[4 + m]
                columns[entry] = row + k
                values[entry] = sign * value + (values[entry] if adds else 0.0)
                entry += 1
                spline += 1
