"""Matrices on a space of splines: ``P^T S P``, gathered cell by cell of the grid.

``P`` takes coefficients to ten values a particle (``Splines``).  ``S`` has blocks on its diagonal,
one a particle, and, in the skew problem, products of pairs beside it.  All particles of a cell
see the same 64 splines, so that products are summed into small dense blocks, one for two
cells, before they are spread over the matrix.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.skew_problem import SkewProblem, monomials
from sphsolid.cloud.splines.plane_matrix import (
    PlaneMatrix,
    add_entry,
    empty_plane_matrix,
    longest_first,
)
from sphsolid.cloud.splines.spline_space import Splines
from sphsolid.compiled import register_jitable, serial_kernel

Array = NDArray[np.float64]


def particle_matrix(splines: Splines, blocks: Array, *, apart: int = 0) -> PlaneMatrix:
    """``P^T S P`` of a block-diagonal ``S``, ``blocks (N, 10, 10)``.

    There is room for couplings of functions ``apart`` cells from each other.
    """
    matrix = empty_plane_matrix(splines, apart)
    _particles(*_grid(splines), matrix.row, blocks, matrix.blocks)
    return matrix


def skew_matrix(problem: SkewProblem, splines: Splines, blocks: Array) -> PlaneMatrix:
    """``P^T S P`` of the skew problem, ``blocks`` its diagonal.

    Every pair takes part.  Those of a seventh of the particles of 65^3 would take less time, but
    give a coarse solution with which the iterations double.
    """
    pairs = problem.pairs
    along = splines.cell[:, longest_first(splines)[0]]
    apart = int(np.max(np.abs(along[pairs.indices] - along[pairs.row_of_pair])))
    matrix = particle_matrix(splines, blocks, apart=apart)
    _pairs(*_grid(splines), matrix.row, *problem.arrays, matrix.blocks)
    return matrix


def _grid(splines: Splines) -> tuple[Any, ...]:
    """What the kernels take first."""
    s = splines
    return (s.order, s.start, s.cells, s.shape, s.cell, s.N, s.D, s.E)


@serial_kernel
def _particles(  # type: ignore[no-untyped-def]
    order, start, cells, shape, cell, N, D, E, row, blocks, out
):
    rows = np.empty(64, dtype=np.int64)
    values, times = np.empty((10, 64)), np.empty((10, 64))
    for box in range(len(start) - 1):
        if start[box] == start[box + 1]:
            continue
        total = np.zeros((64, 64))
        for at in range(start[box], start[box + 1]):
            a = order[at]
            for m in range(10):
                psi = np.zeros(10)
                psi[m] = 1.0
                _side(
                    a, (psi[0], psi[1], psi[2], psi[3], psi[4], psi[5], psi[6], psi[7], psi[8],
                    psi[9]), N, D, E, values[m],
                )  # fmt: skip
            times[:] = 0.0
            for m in range(10):
                for n in range(10):
                    factor = blocks[a, m, n]
                    for i in range(64):
                        times[m, i] += factor * values[n, i]
            for m in range(10):
                for i in range(64):
                    factor = values[m, i]
                    for j in range(64):
                        total[i, j] += factor * times[m, j]
        _rows(cell[order[start[box]]], shape, row, rows)
        for i in range(64):
            for j in range(i + 1):
                add_entry(out, rows[i], rows[j], total[i, j])


@serial_kernel
def _pairs(  # type: ignore[no-untyped-def]
    order, start, cells, shape, cell, N, D, E, row, indptr, indices, X, w, out
):
    mine, others = np.empty(64, dtype=np.int64), np.empty(64, dtype=np.int64)
    one, two = np.empty(64), np.empty(64)
    for box in range(len(start) - 1):
        # The pairs of this cell with itself and with later ones, by the other cell.
        count = 0
        for at in range(start[box], start[box + 1]):
            count += indptr[order[at] + 1] - indptr[order[at]]
        first, pair = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
        where = np.empty(count, dtype=np.int64)
        count = 0
        for at in range(start[box], start[box + 1]):
            a = order[at]
            for k in range(indptr[a], indptr[a + 1]):
                b = indices[k]
                other = (cell[b, 0] * cells[1] + cell[b, 1]) * cells[2] + cell[b, 2]
                if b != a and other >= box:
                    first[count], pair[count], where[count] = a, k, other
                    count += 1
        if count == 0:
            continue
        turn = np.argsort(where[:count], kind="mergesort")
        _rows(cell[first[0]], shape, row, mine)
        begin = 0
        while begin < count:
            other = where[turn[begin]]
            total = np.zeros((64, 64))
            end = begin
            while end < count and where[turn[end]] == other:
                a, k = first[turn[end]], pair[turn[end]]
                b = indices[k]
                x, y, z = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
                _side(a, monomials(x, y, z), N, D, E, one)
                _side(b, monomials(-x, -y, -z), N, D, E, two)
                for i in range(64):
                    factor = -w[k] * one[i]
                    for j in range(64):
                        total[i, j] += factor * two[j]
                end += 1
            _rows(cell[indices[pair[turn[begin]]]], shape, row, others)
            if other == box:
                # Both orders of every pair were met: the block is symmetric.
                for i in range(64):
                    for j in range(i + 1):
                        add_entry(out, mine[i], mine[j], total[i, j])
            else:
                for i in range(64):
                    for j in range(64):
                        # A spline that reaches both cells meets itself in either order.
                        twice = 2.0 if mine[i] == others[j] else 1.0
                        add_entry(out, mine[i], others[j], twice * total[i, j])
            begin = end


@register_jitable
def _rows(cell, shape, row, out):  # type: ignore[no-untyped-def]
    """Rows of the 64 splines of a grid cell."""
    for i in range(4):
        for j in range(4):
            at = ((cell[0] + i) * shape[1] + cell[1] + j) * shape[2] + cell[2]
            for k in range(4):
                out[(i * 4 + j) * 4 + k] = row[at + k]


@register_jitable
def _side(p, psi, N, D, E, out):  # type: ignore[no-untyped-def]
    """``psi`` times the ten values at particle ``p`` of each of the 64 splines (``ten_values``)."""
    for i in range(4):
        n0, d0, e0 = N[p, 0, i], D[p, 0, i] / 2.0, E[p, 0, i] / 6.0
        d3 = D[p, 0, i] / 6.0
        v = psi[0] * n0 + psi[1] * d0 + psi[4] * e0
        v1 = psi[2] * n0 / 2.0 + psi[7] * d3
        v11 = psi[5] * n0 / 6.0
        v2 = psi[3] * n0 / 2.0 + psi[8] * d3
        v12 = psi[9] * n0 / 6.0
        v22 = psi[6] * n0 / 6.0
        for j in range(4):
            n1, d1, e1 = N[p, 1, j], D[p, 1, j], E[p, 1, j]
            value = v * n1 + v1 * d1 + v11 * e1
            slope = v2 * n1 + v12 * d1
            bend = v22 * n1
            for k in range(4):
                out[(i * 4 + j) * 4 + k] = (
                    value * N[p, 2, k] + slope * D[p, 2, k] + bend * E[p, 2, k]
                )
