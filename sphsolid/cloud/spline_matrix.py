"""The skew problem's matrix on a space of splines: ``P^T S P``, pair by pair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.skew_problem import SkewProblem, monomials
from sphsolid.cloud.spline_space import Splines, ten_values
from sphsolid.compiled import register_jitable, serial_kernel

Array = NDArray[np.float64]


def spline_matrix(problem: SkewProblem, splines: Splines) -> Array:
    """Lower half of the matrix ``(size, size)``.

    The pairs of a seventh of the particles of 65^3 would take a seventh of the time, but give
    a coarse solution with which the iterations double.
    """
    out = np.zeros((splines.size, splines.size))
    _matrix(
        *problem.arrays, problem.epsilon, splines.order, splines.cell, splines.N, splines.D,
        splines.E, splines.shape, out,
    )  # fmt: skip
    return out


@serial_kernel
def _matrix(  # type: ignore[no-untyped-def]
    indptr, indices, X, scale, w, epsilon, order, cell, N, D, E, shape, out
):
    columns = np.empty(128, dtype=np.int64)
    values = np.empty(128)
    bend = np.empty((64, 6))
    # Cell by cell, so that the rows of the matrix in use stay in the cache.
    for a in order:
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            if b == a:
                # The particle's own entry stands for the diagonal of the quadratic multipliers.
                _side(a, 0.0, 0.0, 0.0, 1.0, cell, N, D, E, shape, 0, False, columns, values, bend)
                for m in range(6):
                    for i in range(64):
                        scaled = epsilon[a] * bend[i, m]
                        for j in range(i + 1):
                            out[columns[i], columns[j]] += scaled * bend[j, m]
                continue
            if b < a:
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
            weight = w[k]
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
    psi = monomials(x, y, z)
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
