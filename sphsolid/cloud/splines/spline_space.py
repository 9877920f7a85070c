"""A coarse space for smooth functions on any cloud: tensor-product cubic B-splines on a grid.

A point-by-point preconditioner does not see all multipliers of ``summation_by_parts``.  Those that
it cannot see are smooth: values ``s_a = s(X_a)``, slopes ``grad s(X_a) / 2`` and curvatures ``grad
grad s(X_a) / 6`` of one function ``s``.  Whenever ``s`` is cubic, the system's form is zero for
them.  Splines on a grid of a few spacings represent them on clouds of any kind, without a mesh or
aggregates.  They hold all quadratics exactly.  ``Splines`` evaluates (:meth:`Splines.prolong`),
tests (:meth:`Splines.restrict`, the transpose) and gives the coefficients of the quadratics.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange, register_jitable

Array = NDArray[np.float64]
#: Grid functions that are not zero at a point, along one axis.
WIDTH = 4
#: Functions of a coarse grid, at most.  Those of a cube of 65^3 particles and 2.5 spacings take
#: 0.8 GB while their matrix is factorised; with more particles the grid gets coarser.
MOST_COARSE = 25_000


class Splines:
    """Cubic B-splines on a grid of about ``edge`` over the box around ``X (N, 3)``.

    Lengths are counted in spacings, and so are slopes and curvatures; ``shape`` is the number of
    functions along each axis, ``size`` their number.
    """

    def __init__(self, X: Array, edge: float) -> None:
        low, high = X.min(axis=0), X.max(axis=0)
        length = np.maximum(high - low, 1.0e-12 * np.max(high - low))
        cells = np.maximum(1, np.ceil(length / edge - 1.0e-9)).astype(np.int64)
        self.edge = length / cells
        self.shape = cells + WIDTH - 1
        self.size = int(np.prod(self.shape))
        place = (X - low) / self.edge
        self.cell = np.clip(place.astype(np.int64), 0, cells - 1)
        t = place - self.cell
        self.N = np.stack(
            [
                (1.0 - t) ** 3,
                3.0 * t**3 - 6.0 * t**2 + 4.0,
                -3.0 * t**3 + 3.0 * t**2 + 3.0 * t + 1.0,
                t**3,
            ],
            axis=2,
        ) / 6.0
        slope = np.stack(
            [-((1.0 - t) ** 2), 3.0 * t**2 - 4.0 * t, -3.0 * t**2 + 2.0 * t + 1.0, t**2], axis=2
        ) / 2.0
        curvature = np.stack([1.0 - t, 3.0 * t - 2.0, 1.0 - 3.0 * t, t], axis=2)
        self.D = slope / self.edge[:, None]
        self.E = curvature / self.edge[:, None] ** 2
        order = np.lexsort(self.cell.T[::-1])
        flat = np.ravel_multi_index(tuple(self.cell.T), tuple(cells))
        self.order = order
        self.start = np.searchsorted(flat[order], np.arange(int(np.prod(cells)) + 1))
        self.cells = cells

    def prolong(self, coefficients: Array, out: Array) -> None:
        """Add the ten values of ``coefficients (size, 3)`` to ``out (N, 10, 3)``."""
        _prolong(self.cell, self.N, self.D, self.E, self.shape, coefficients, out)

    def restrict(self, z: Array, out: Array) -> None:
        """The transpose: ``out (size, 3)`` from ``z (N, 10, 3)``."""
        parts = np.empty((len(self.start) - 1, WIDTH**3, 3))
        _restrict_cells(self.order, self.start, self.N, self.D, self.E, z, parts)
        _gather_cells(self.cells, self.shape, parts, out)

    def linears(self) -> Array:
        """Orthonormal coefficients of the four linear functions ``(size, 4)``."""
        one = [np.ones(n) for n in self.shape]
        knots = [np.linspace(-1.0, 1.0, n) for n in self.shape]
        columns = [_outer(one, {}), *(_outer(one, {i: knots[i]}) for i in range(3))]
        return np.linalg.qr(np.stack(columns, axis=1))[0]

    def quadratics(self) -> Array:
        """Orthonormal coefficients of the ten quadratics ``(size, 10)``.

        With knots ``xi``, ``sum xi_i N_i = x`` and ``sum (xi_i^2 - edge^2 / 3) N_i = x^2``.
        """
        one, x, xx = [], [], []
        for n in self.shape:
            knots = np.linspace(-1.0, 1.0, n)
            step = knots[1] - knots[0] if n > 1 else 1.0
            one.append(np.ones(n))
            x.append(knots)
            xx.append(knots**2 - step**2 / 3.0)
        columns = []
        for i in range(3):
            columns += [_outer(one, {i: x[i]}), _outer(one, {i: xx[i]})]
            columns += [_outer(one, {i: x[i], j: x[j]}) for j in range(i + 1, 3)]
        columns.append(_outer(one, {}))
        return np.linalg.qr(np.stack(columns, axis=1))[0]


def coarse_splines(X: Array, edge: float) -> Splines:
    """Splines on a grid of ``edge`` spacings, or more where there would be too many."""
    volume = float(np.prod(np.maximum(np.ptp(X, axis=0), 1.0)))
    edge = max(edge, (volume / MOST_COARSE) ** (1.0 / 3.0))
    splines = Splines(X, edge)
    while splines.size > MOST_COARSE:
        edge *= 1.05
        splines = Splines(X, edge)
    return splines


def _outer(one: list[Array], chosen: dict[int, Array]) -> Array:
    a, b, c = (chosen.get(d, one[d]) for d in range(3))
    return np.asarray(a[:, None, None] * b[:, None] * c).ravel()


@register_jitable
def ten_values(n0, n1, n2, d0, d1, d2, e0, e1, e2):  # type: ignore[no-untyped-def]
    """``s, grad s / 2, grad grad s / 6`` of one product of splines, by monomials 1, x, .. yz.

    ``n, d, e``: value, slope and curvature along each axis.
    """
    return (
        n0 * n1 * n2,
        0.5 * d0 * n1 * n2, 0.5 * n0 * d1 * n2, 0.5 * n0 * n1 * d2,
        e0 * n1 * n2 / 6.0, n0 * e1 * n2 / 6.0, n0 * n1 * e2 / 6.0,
        d0 * d1 * n2 / 6.0, d0 * n1 * d2 / 6.0, n0 * d1 * d2 / 6.0,
    )  # fmt: skip


@kernel
def _prolong(cell, N, D, E, shape, coefficients, out):  # type: ignore[no-untyped-def]
    # Axis by axis: b[p, q] holds derivatives p along axis 0 and q along axis 1 of one row.
    for a in prange(len(cell)):
        for c in range(3):
            s = np.zeros(10)
            for k in range(4):
                b00 = b10 = b20 = b01 = b11 = b02 = 0.0
                for j in range(4):
                    v = d = e = 0.0
                    for i in range(4):
                        row = ((cell[a, 0] + i) * shape[1] + cell[a, 1] + j) * shape[2]
                        x = coefficients[row + cell[a, 2] + k, c]
                        v += N[a, 0, i] * x
                        d += D[a, 0, i] * x
                        e += E[a, 0, i] * x
                    b00 += N[a, 1, j] * v
                    b10 += N[a, 1, j] * d
                    b20 += N[a, 1, j] * e
                    b01 += D[a, 1, j] * v
                    b11 += D[a, 1, j] * d
                    b02 += E[a, 1, j] * v
                n, d2, e2 = N[a, 2, k], D[a, 2, k], E[a, 2, k]
                s[0] += n * b00
                s[1] += n * b10
                s[2] += n * b01
                s[3] += d2 * b00
                s[4] += n * b20
                s[5] += n * b02
                s[6] += e2 * b00
                s[7] += n * b11
                s[8] += d2 * b10
                s[9] += d2 * b01
            out[a, 0, c] += s[0]
            for m in range(1, 4):
                out[a, m, c] += s[m] / 2.0
            for m in range(4, 10):
                out[a, m, c] += s[m] / 6.0


@kernel
def _restrict_cells(order, start, N, D, E, z, out):  # type: ignore[no-untyped-def]
    """What the particles of every grid cell give to its 64 functions ``(cells, 64, 3)``."""
    for box in prange(len(out)):
        for f in range(64):
            for c in range(3):
                out[box, f, c] = 0.0
        for at in range(start[box], start[box + 1]):
            a = order[at]
            for c in range(3):
                for k in range(4):
                    n, d, e = N[a, 2, k], D[a, 2, k] / 2.0, E[a, 2, k] / 6.0
                    d3 = D[a, 2, k] / 6.0
                    v = n * z[a, 0, c] + d * z[a, 3, c] + e * z[a, 6, c]
                    v1 = n * z[a, 2, c] / 2.0 + d3 * z[a, 9, c]
                    v11 = n * z[a, 5, c] / 6.0
                    v0 = n * z[a, 1, c] / 2.0 + d3 * z[a, 8, c]
                    v01 = n * z[a, 7, c] / 6.0
                    v00 = n * z[a, 4, c] / 6.0
                    for j in range(4):
                        w = N[a, 1, j] * v + D[a, 1, j] * v1 + E[a, 1, j] * v11
                        w0 = N[a, 1, j] * v0 + D[a, 1, j] * v01
                        w00 = N[a, 1, j] * v00
                        for i in range(4):
                            out[box, (i * 4 + j) * 4 + k, c] += (
                                N[a, 0, i] * w + D[a, 0, i] * w0 + E[a, 0, i] * w00
                            )


@kernel
def _gather_cells(cells, shape, parts, out):  # type: ignore[no-untyped-def]
    for node in prange(len(out)):
        n2 = node % shape[2]
        n1 = (node // shape[2]) % shape[1]
        n0 = node // (shape[2] * shape[1])
        t0 = 0.0
        t1 = 0.0
        t2 = 0.0
        for i in range(max(0, n0 - cells[0] + 1), min(3, n0) + 1):
            for j in range(max(0, n1 - cells[1] + 1), min(3, n1) + 1):
                for k in range(max(0, n2 - cells[2] + 1), min(3, n2) + 1):
                    box = ((n0 - i) * cells[1] + n1 - j) * cells[2] + n2 - k
                    f = (i * 4 + j) * 4 + k
                    t0 += parts[box, f, 0]
                    t1 += parts[box, f, 1]
                    t2 += parts[box, f, 2]
        out[node, 0] = t0
        out[node, 1] = t1
        out[node, 2] = t2
