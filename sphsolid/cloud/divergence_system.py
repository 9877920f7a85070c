"""The system of the least change that makes the divergence theorem hold (see ``consistent``).

``S`` takes one multiplier a particle to what the change ``D`` adds to D0,

    (S mu)_a = sum_b V_b w_ab [ V_b mu_a - phi_ab . eta_b ].

Its form is ``mu . S mu = sum_b V_b^2 min_l sum_a w_ab (mu_a - l(X_a))^2``, the minimum over linear
functions ``l``.  It measures curvature: at long waves ``S`` acts like a fourth-order operator.
With its diagonal alone, iterations grow with ``N^(2/3)``.  So a solution on a coarse space of
splines can be added.  Its matrix is exactly that of ``S`` there.  With one that only sees
curvatures the iteration fails on shells, where functions without curvature at any particle are not
linear.

In the boundary layers of a thin lattice few pairs may change.  There ``S`` has more null vectors
than the linears, and the coarse solution blows them up.  The diagonal alone is safer there, and
enough.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.splines.coarse_solution import CoarseSolution, NoCoarseSolution
from sphsolid.cloud.splines.plane_matrix import add_entry
from sphsolid.cloud.splines.spline_matrix import particle_matrix
from sphsolid.cloud.splines.spline_space import coarse_splines
from sphsolid.compiled import kernel, prange, serial_kernel

Array = NDArray[np.float64]
#: Width of the coarse grid in spacings.
COARSE_SPACINGS = 2.5
#: Small beside the fourth power of the longest wave number times that width, large enough for the
#: null vectors that the few pairs of a lattice's boundary layers have beside the linears.
SHIFT = 1.0e-6
#: The matrix of the splines is a difference: entries below this share of what it is taken from are
#: not scaled up, with their round-off, to one.
LEAST_SHARE = 1.0e-6


class DivergenceSystem:
    """``S`` as an operator on ``(N, 3)``, and its preconditioner.

    ``weights (P,)`` of the pairs that may change, symmetric; ``h`` [m] a length of the size of the
    spacing, which makes the monomials dimensionless; ``coarse``: with the coarse solution.
    """

    def __init__(
        self,
        pairs: PairList,
        particles: Array,
        volumes: Array,
        weights: Array,
        h: float,
        *,
        coarse: bool,
    ) -> None:
        self._arrays = (pairs.indptr, pairs.indices, particles, volumes, weights, h)
        self._size = len(volumes)
        moments = np.empty((pairs.rows, 4, 4))
        _moments(pairs.indptr, pairs.indices, particles, weights, h, moments)
        self._inverse = _pseudo_inverses(moments)
        diagonal = self.diagonal()
        # A particle whose pairs are all fixed by C0 and C1 has a zero row: nothing to solve there.
        solvable = diagonal > 1.0e-12 * float(np.max(diagonal))
        self._jacobi = np.where(solvable, 1.0 / np.where(solvable, diagonal, 1.0), 0.0)
        self._coarse = self._coarse_solution() if coarse else NoCoarseSolution()

    def _coarse_solution(self) -> CoarseSolution:
        indptr, indices, X, V, w, h = self._arrays
        splines = coarse_splines(X / h, COARSE_SPACINGS)
        apart = np.zeros(3, dtype=np.int64)
        row = np.repeat(np.arange(self._size), np.diff(indptr))
        for d in range(3):
            along = splines.cell[:, d]
            apart[d] = np.max(np.abs(along[indices] - along[row]), initial=0)
        blocks = np.zeros((self._size, 10, 10))
        blocks[:, 0, 0] = np.bincount(row, w * V[indices] ** 2, minlength=self._size)
        matrix = particle_matrix(splines, blocks, apart=2 * int(np.max(apart)))
        size = LEAST_SHARE * matrix.diagonal
        _subtract(
            splines.order, splines.start, splines.cells, splines.cell, splines.N, splines.shape,
            matrix.row, apart, *self._arrays, self._inverse, matrix.blocks,
        )  # fmt: skip
        return CoarseSolution(splines, matrix, splines.linears(), shift=SHIFT, least=size)

    def precondition(self, residual: Array) -> Array:
        """``(N, 3)``: over the diagonal, plus the coarse solution."""
        z, out = np.zeros((2, self._size, 10, 3))
        z[:, 0] = residual
        self._coarse.add(z, out)
        return np.asarray(residual * self._jacobi[:, None] + out[:, 0])

    def eta(self, mu: Array) -> Array:
        """``eta_b (N, 4, 3)``."""
        eta = np.empty((self._size, 4, 3))
        _local_unknowns(*self._arrays, self._inverse, mu, eta)
        return eta

    def apply(self, mu: Array) -> Array:
        """``S mu (N, 3)``."""
        out = np.empty_like(mu)
        _apply(*self._arrays, mu, self.eta(mu), out)
        return out

    def change(self, mu: Array) -> Array:
        """``D (P, 3)`` of the pairs."""
        out = np.empty((len(self._arrays[1]), 3))
        _change(*self._arrays, mu, self.eta(mu), out)
        return out

    def diagonal(self) -> Array:
        """Diagonal of ``S (N,)``."""
        out = np.empty(self._size)
        _diagonal(*self._arrays, self._inverse, out)
        return out


def _pseudo_inverses(moments: Array) -> Array:
    """Of ``m_b (N, 4, 4)``: points with few active pairs are rank deficient."""
    peak = float(np.max(moments[:, 0, 0]))
    value, vector = np.linalg.eigh(moments)
    kept = value > 1.0e-10 * peak
    reciprocal = np.where(kept, 1.0 / np.where(kept, value, 1.0), 0.0)
    return np.einsum("bik,bk,bjk->bij", vector, reciprocal, vector)


@kernel
def _moments(indptr, indices, X, w, h, moment):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        for i in range(4):
            for j in range(4):
                moment[b, i, j] = 0.0
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            phi = (1.0, p1, p2, p3)
            for i in range(4):
                for j in range(4):
                    moment[b, i, j] += w[k] * phi[i] * phi[j]


@kernel
def _local_unknowns(indptr, indices, X, V, w, h, inverse, mu, eta):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        s = np.zeros((4, 3))
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            for d in range(3):
                m = w[k] * V[b] * mu[a, d]
                s[0, d] += m
                s[1, d] += p1 * m
                s[2, d] += p2 * m
                s[3, d] += p3 * m
        for i in range(4):
            for d in range(3):
                total = 0.0
                for j in range(4):
                    total += inverse[b, i, j] * s[j, d]
                eta[b, i, d] = total


@kernel
def _apply(indptr, indices, X, V, w, h, mu, eta, out):  # type: ignore[no-untyped-def]
    # (S mu)_a = sum_b V_b D_a(X_b); the pattern and w are symmetric, so a gathers over its row.
    for a in prange(len(indptr) - 1):
        s0 = 0.0
        s1 = 0.0
        s2 = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            e = eta[b]
            c = V[b] * w[k]
            s0 += c * (V[b] * mu[a, 0] - e[0, 0] - p1 * e[1, 0] - p2 * e[2, 0] - p3 * e[3, 0])
            s1 += c * (V[b] * mu[a, 1] - e[0, 1] - p1 * e[1, 1] - p2 * e[2, 1] - p3 * e[3, 1])
            s2 += c * (V[b] * mu[a, 2] - e[0, 2] - p1 * e[1, 2] - p2 * e[2, 2] - p3 * e[3, 2])
        out[a, 0] = s0
        out[a, 1] = s1
        out[a, 2] = s2


@kernel
def _diagonal(indptr, indices, X, V, w, h, inverse, out):  # type: ignore[no-untyped-def]
    for a in prange(len(indptr) - 1):
        s = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            phi = (1.0, p1, p2, p3)
            quadratic = 0.0
            for i in range(4):
                for j in range(4):
                    quadratic += phi[i] * inverse[b, i, j] * phi[j]
            s += V[b] * V[b] * w[k] * (1.0 - w[k] * quadratic)
        out[a] = s


@kernel
def _change(indptr, indices, X, V, w, h, mu, eta, D):  # type: ignore[no-untyped-def]
    for b in prange(len(indptr) - 1):
        for k in range(indptr[b], indptr[b + 1]):
            a = indices[k]
            p1 = (X[a, 0] - X[b, 0]) / h
            p2 = (X[a, 1] - X[b, 1]) / h
            p3 = (X[a, 2] - X[b, 2]) / h
            for d in range(3):
                e = eta[b, 0, d] + p1 * eta[b, 1, d] + p2 * eta[b, 2, d] + p3 * eta[b, 3, d]
                D[k, d] = w[k] * (V[b] * mu[a, d] - e)


@serial_kernel
def _subtract(  # type: ignore[no-untyped-def]
    order, start, cells, cell, N, shape, row, apart, indptr, indices, X, V, w, h, inverse, out
):
    """``sum_b y_b^T m_b^-1 y_b`` off ``out``, ``y_b`` the moments of every spline around ``b``."""
    # All particles of a grid cell see splines of the cells up to ``apart`` beside it.
    n1, n2 = 4 + 2 * apart[1], 4 + 2 * apart[2]
    size = (4 + 2 * apart[0]) * n1 * n2
    y, times = np.empty((4, size)), np.empty((4, size))
    total = np.empty((size, size))
    rows = np.empty(size, dtype=np.int64)
    for box in range(len(start) - 1):
        if start[box] == start[box + 1]:
            continue
        here = cell[order[start[box]]]
        total[:] = 0.0
        for at in range(start[box], start[box + 1]):
            b = order[at]
            y[:] = 0.0
            for k in range(indptr[b], indptr[b + 1]):
                a = indices[k]
                c0 = cell[a, 0] - here[0] + apart[0]
                c1 = cell[a, 1] - here[1] + apart[1]
                c2 = cell[a, 2] - here[2] + apart[2]
                p1 = (X[a, 0] - X[b, 0]) / h
                p2 = (X[a, 1] - X[b, 1]) / h
                p3 = (X[a, 2] - X[b, 2]) / h
                for i in range(4):
                    for j in range(4):
                        first = ((c0 + i) * n1 + c1 + j) * n2 + c2
                        value = w[k] * V[b] * N[a, 0, i] * N[a, 1, j]
                        for f in range(4):
                            s = value * N[a, 2, f]
                            y[0, first + f] += s
                            y[1, first + f] += p1 * s
                            y[2, first + f] += p2 * s
                            y[3, first + f] += p3 * s
            for i in range(4):
                for f in range(size):
                    times[i, f] = (
                        inverse[b, i, 0] * y[0, f] + inverse[b, i, 1] * y[1, f]
                        + inverse[b, i, 2] * y[2, f] + inverse[b, i, 3] * y[3, f]
                    )  # fmt: skip
            for f in range(size):
                y0, y1, y2, y3 = y[0, f], y[1, f], y[2, f], y[3, f]
                if y0 == 0.0:
                    continue
                for g in range(f + 1):
                    total[f, g] += (
                        y0 * times[0, g] + y1 * times[1, g] + y2 * times[2, g] + y3 * times[3, g]
                    )
        for f in range(size):
            m0 = here[0] - apart[0] + f // (n1 * n2)
            m1 = here[1] - apart[1] + (f // n2) % n1
            m2 = here[2] - apart[2] + f % n2
            inside = 0 <= m0 < shape[0] and 0 <= m1 < shape[1] and 0 <= m2 < shape[2]
            rows[f] = row[(m0 * shape[1] + m1) * shape[2] + m2] if inside else -1
        for f in range(size):
            for g in range(f + 1):
                if total[f, g] != 0.0:
                    add_entry(out, rows[f], rows[g], -total[f, g])
