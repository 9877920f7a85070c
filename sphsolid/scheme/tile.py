"""Sums over pairs and 3x3 algebra on one tile of particles, in scratch rows.

A tile is ``LANES`` consecutive particles (see ``cloud.pairs.pair_operator``).  Its intermediate
results live in *scratch rows*, one row a component, lying one after another in one flat array:
distances between rows are constants, so the compiler knows that they do not overlap and works on
several particles in one instruction.  Indices are unsigned for the same reason: no test for
negative ones.

Every function here is inlined into the kernels of ``galerkin``, ``fine_scale`` and ``pressure``.
``S`` is the scratch of one thread, ``row`` a scratch row, ``at`` the first particle of the tile.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined, register_jitable
from sphsolid.continuum.tensor import Tensor, axpy, load, scale, store
from sphsolid.fields import GRAIN, LANES

Array = NDArray[np.float64]
U = np.uint64

#: Scratch rows a thread has, and their distance: runs may write a few lanes too many.
ROWS = 64
STRIDE = LANES + 2 * GRAIN


def make_scratch() -> Array:
    """Scratch ``(workers, .)`` for all threads there can be."""
    # Ones, so that lanes nobody has written to hold nothing slow or invalid.
    return np.ones((numba.config.NUMBA_NUM_THREADS, ROWS * STRIDE))


@inlined
def share(t: Any, workers: Any, tiles: Any) -> Any:
    """First and last tile of worker ``t``."""
    return U(t * tiles // workers), U((t + 1) * tiles // workers)


@inlined
def load_lane(S: Any, row: int, lane: Any) -> Tensor:
    """Tensor of a lane from nine scratch rows."""
    q = U(row * STRIDE) + lane
    return (
        S[q], S[q + U(STRIDE)], S[q + U(2 * STRIDE)],
        S[q + U(3 * STRIDE)], S[q + U(4 * STRIDE)], S[q + U(5 * STRIDE)],
        S[q + U(6 * STRIDE)], S[q + U(7 * STRIDE)], S[q + U(8 * STRIDE)],
    )  # fmt: skip


@inlined
def store_lane(A: Tensor, S: Any, row: int, lane: Any) -> None:
    """Write a tensor into nine scratch rows."""
    q = U(row * STRIDE) + lane
    S[q] = A[0]
    S[q + U(STRIDE)] = A[1]
    S[q + U(2 * STRIDE)] = A[2]
    S[q + U(3 * STRIDE)] = A[3]
    S[q + U(4 * STRIDE)] = A[4]
    S[q + U(5 * STRIDE)] = A[5]
    S[q + U(6 * STRIDE)] = A[6]
    S[q + U(7 * STRIDE)] = A[7]
    S[q + U(8 * STRIDE)] = A[8]


@inlined
def fetch(field: Any, count: int, at: Any, S: Any, row: int) -> None:
    """Copy ``count`` components of the tile into scratch rows."""
    for c in range(U(count)):
        q = U(row * STRIDE) + c * U(STRIDE)
        for lane in range(U(LANES)):
            S[q + lane] = field[c, at + lane]


@inlined
def fetch_tensor(field: Any, at: Any, S: Any, row: int) -> None:
    """Copy a tensor field of the tile, in either layout, into nine scratch rows."""
    if field.ndim == 2:
        fetch(field, 9, at, S, row)
    else:
        for lane in range(U(LANES)):
            store_lane(load(field, at + lane), S, row, lane)


@inlined
def put(S: Any, row: int, count: int, at: Any, field: Any) -> None:
    """Copy scratch rows to ``count`` components of the tile's particles."""
    for c in range(U(count)):
        q = U(row * STRIDE) + c * U(STRIDE)
        for lane in range(U(LANES)):
            field[c, at + lane] = S[q + lane]


@inlined
def put_tensor(S: Any, row: int, at: Any, field: Any) -> None:
    """Copy nine scratch rows to a tensor field, in either layout."""
    if field.ndim == 2:
        put(S, row, 9, at, field)
    else:
        for lane in range(U(LANES)):
            store(load_lane(S, row, lane), field, at + lane)


@inlined
def subtract(S: Any, row: int, count: int, at: Any, field: Any) -> None:
    """Take scratch rows from ``count`` components of the tile's particles."""
    for c in range(U(count)):
        q = U(row * STRIDE) + c * U(STRIDE)
        for lane in range(U(LANES)):
            field[c, at + lane] -= S[q + lane]


@inlined
def put_negative(S: Any, row: int, count: int, at: Any, field: Any) -> None:
    """Write minus scratch rows to ``count`` components of the tile's particles."""
    for c in range(U(count)):
        q = U(row * STRIDE) + c * U(STRIDE)
        for lane in range(U(LANES)):
            field[c, at + lane] = -S[q + lane]


# Sums over the lanes of a run.  Loops over lanes are short, and beginning one costs as much as
# several additions (the compiler tests whether rows overlap): each does as much as it can at once.


@inlined
def _run_gradient(  # type: ignore[no-untyped-def]
    A, run, at, f, factor, S, row
):
    origin, lanes = at + A.lane[run] + A.base[run], A.lanes[run]
    q = U(row) * U(STRIDE) + A.lane[run]
    for c in range(U(9)):
        for lane in range(lanes):
            S[q + c * U(STRIDE) + lane] = 0.0
    if A.stencil[run] < A.stencils:
        for i in range(U(3)):
            q0 = q + U(3) * i * U(STRIDE)
            q1, q2 = q0 + U(STRIDE), q0 + U(2 * STRIDE)
            for k in range(A.term[A.stencil[run]], A.term[A.stencil[run] + U(1)], U(4)):
                b0, b1 = origin + A.offset[k], origin + A.offset[k + U(1)]
                b2, b3 = origin + A.offset[k + U(2)], origin + A.offset[k + U(3)]
                x0, x1 = factor * A.value[0, k], factor * A.value[0, k + U(1)]
                x2, x3 = factor * A.value[0, k + U(2)], factor * A.value[0, k + U(3)]
                y0, y1 = factor * A.value[1, k], factor * A.value[1, k + U(1)]
                y2, y3 = factor * A.value[1, k + U(2)], factor * A.value[1, k + U(3)]
                z0, z1 = factor * A.value[2, k], factor * A.value[2, k + U(1)]
                z2, z3 = factor * A.value[2, k + U(2)], factor * A.value[2, k + U(3)]
                for lane in range(lanes):
                    f0, f1 = f[i, b0 + lane], f[i, b1 + lane]
                    f2, f3 = f[i, b2 + lane], f[i, b3 + lane]
                    S[q0 + lane] += (x0 * f0 + x1 * f1) + (x2 * f2 + x3 * f3)
                    S[q1 + lane] += (y0 * f0 + y1 * f1) + (y2 * f2 + y3 * f3)
                    S[q2 + lane] += (z0 * f0 + z1 * f1) + (z2 * f2 + z3 * f3)
    else:
        v = A.own[run]
        for k in range(A.seen[A.stencil[run]], A.seen[A.stencil[run] + U(1)]):
            b = origin + A.neighbour[k]
            for lane in range(lanes):
                g0, g1 = factor * A.own_value[0, v + lane], factor * A.own_value[1, v + lane]
                g2 = factor * A.own_value[2, v + lane]
                f0, f1, f2 = f[0, b + lane], f[1, b + lane], f[2, b + lane]
                S[q + lane] += f0 * g0
                S[q + U(STRIDE) + lane] += f0 * g1
                S[q + U(2 * STRIDE) + lane] += f0 * g2
                S[q + U(3 * STRIDE) + lane] += f1 * g0
                S[q + U(4 * STRIDE) + lane] += f1 * g1
                S[q + U(5 * STRIDE) + lane] += f1 * g2
                S[q + U(6 * STRIDE) + lane] += f2 * g0
                S[q + U(7 * STRIDE) + lane] += f2 * g1
                S[q + U(8 * STRIDE) + lane] += f2 * g2
            v += lanes


@inlined
def _run_interpolation(  # type: ignore[no-untyped-def]
    A, run, column, count, at, f, S, row
):
    origin, lanes = at + A.lane[run] + A.base[run], A.lanes[run]
    for i in range(U(count)):
        q = (U(row) + i) * U(STRIDE) + A.lane[run]
        for lane in range(lanes):
            S[q + lane] = 0.0
        if A.stencil[run] < A.stencils:
            for k in range(A.term[A.stencil[run]], A.term[A.stencil[run] + U(1)], U(4)):
                b0, b1 = origin + A.offset[k], origin + A.offset[k + U(1)]
                b2, b3 = origin + A.offset[k + U(2)], origin + A.offset[k + U(3)]
                w0, w1 = A.value[column, k], A.value[column, k + U(1)]
                w2, w3 = A.value[column, k + U(2)], A.value[column, k + U(3)]
                for lane in range(lanes):
                    S[q + lane] += (w0 * f[i, b0 + lane] + w1 * f[i, b1 + lane]) + (
                        w2 * f[i, b2 + lane] + w3 * f[i, b3 + lane]
                    )
        else:
            v = A.own[run]
            for k in range(A.seen[A.stencil[run]], A.seen[A.stencil[run] + U(1)]):
                b = origin + A.neighbour[k]
                for lane in range(lanes):
                    S[q + lane] += A.own_value[column, v + lane] * f[i, b + lane]
                v += lanes


@inlined
def _run_divergence(  # type: ignore[no-untyped-def]
    A, run, at, T, count, S, row
):
    """``count`` rows, each from three components of ``T``."""
    origin, lanes = at + A.lane[run] + A.base[run], A.lanes[run]
    for i in range(U(count)):
        q = (U(row) + i) * U(STRIDE) + A.lane[run]
        c0, c1, c2 = U(3) * i, U(3) * i + U(1), U(3) * i + U(2)
        for lane in range(lanes):
            S[q + lane] = 0.0
        if A.stencil[run] < A.stencils:
            for k in range(A.term[A.stencil[run]], A.term[A.stencil[run] + U(1)], U(2)):
                b0, b1 = origin + A.offset[k], origin + A.offset[k + U(1)]
                x0, x1 = A.value[0, k], A.value[0, k + U(1)]
                y0, y1 = A.value[1, k], A.value[1, k + U(1)]
                z0, z1 = A.value[2, k], A.value[2, k + U(1)]
                for lane in range(lanes):
                    S[q + lane] += (
                        x0 * T[c0, b0 + lane] + y0 * T[c1, b0 + lane] + z0 * T[c2, b0 + lane]
                    ) + (x1 * T[c0, b1 + lane] + y1 * T[c1, b1 + lane] + z1 * T[c2, b1 + lane])
        else:
            v = A.own[run]
            for k in range(A.seen[A.stencil[run]], A.seen[A.stencil[run] + U(1)]):
                b = origin + A.neighbour[k]
                for lane in range(lanes):
                    S[q + lane] += (
                        A.own_value[0, v + lane] * T[c0, b + lane]
                        + A.own_value[1, v + lane] * T[c1, b + lane]
                        + A.own_value[2, v + lane] * T[c2, b + lane]
                    )
                v += lanes


@register_jitable
def gradient(  # type: ignore[no-untyped-def]
    A, tile, at, f, factor, S, row
):
    """Rows ``row .. row + 8``: ``factor sum_b f_b (x) G_b`` of ``f (3, .)``."""
    for run in range(A.runs[tile], A.runs[tile + U(1)]):
        _run_gradient(A, run, at, f, factor, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        s00 = s01 = s02 = s10 = s11 = s12 = s20 = s21 = s22 = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            b = A.indices[k]
            g0, g1, g2 = A.coefficient[0, k], A.coefficient[1, k], A.coefficient[2, k]
            f0, f1, f2 = f[0, b], f[1, b], f[2, b]
            s00 += f0 * g0
            s01 += f0 * g1
            s02 += f0 * g2
            s10 += f1 * g0
            s11 += f1 * g1
            s12 += f1 * g2
            s20 += f2 * g0
            s21 += f2 * g1
            s22 += f2 * g2
        total = (s00, s01, s02, s10, s11, s12, s20, s21, s22)
        store_lane(scale(factor, total), S, row, A.exception[e] - at)


@register_jitable
def two_gradients(  # type: ignore[no-untyped-def]
    A, tile, f, factor, h, S, row_f
):
    """``factor sum_b f_b (x) G_b`` and ``sum_b h_b (x) G_b``, nine rows each, one after another."""
    at, row_h = tile * U(LANES), row_f + 9
    for run in range(A.runs[tile], A.runs[tile + U(1)]):
        _run_gradient(A, run, at, f, factor, S, row_f)
        _run_gradient(A, run, at, h, 1.0, S, row_h)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        s00 = s01 = s02 = s10 = s11 = s12 = s20 = s21 = s22 = 0.0
        r00 = r01 = r02 = r10 = r11 = r12 = r20 = r21 = r22 = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            b = A.indices[k]
            g0, g1, g2 = A.coefficient[0, k], A.coefficient[1, k], A.coefficient[2, k]
            f0, f1, f2 = f[0, b], f[1, b], f[2, b]
            s00 += f0 * g0
            s01 += f0 * g1
            s02 += f0 * g2
            s10 += f1 * g0
            s11 += f1 * g1
            s12 += f1 * g2
            s20 += f2 * g0
            s21 += f2 * g1
            s22 += f2 * g2
            h0, h1, h2 = h[0, b], h[1, b], h[2, b]
            r00 += h0 * g0
            r01 += h0 * g1
            r02 += h0 * g2
            r10 += h1 * g0
            r11 += h1 * g1
            r12 += h1 * g2
            r20 += h2 * g0
            r21 += h2 * g1
            r22 += h2 * g2
        lane = A.exception[e] - at
        total = (s00, s01, s02, s10, s11, s12, s20, s21, s22)
        store_lane(scale(factor, total), S, row_f, lane)
        store_lane((r00, r01, r02, r10, r11, r12, r20, r21, r22), S, row_h, lane)


@register_jitable
def interpolate_scalar(  # type: ignore[no-untyped-def]
    A, column, tile, at, f, S, row
):
    """Scratch row ``row``: ``sum_b w_b f_b`` of ``f (1, .)``, ``w`` the given column of ``A``."""
    for run in range(A.runs[tile], A.runs[tile + U(1)]):
        _run_interpolation(A, run, column, 1, at, f, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        total = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            total += A.coefficient[column, k] * f[0, A.indices[k]]
        S[U(row * STRIDE) + A.exception[e] - at] = total


@register_jitable
def interpolate_vector(  # type: ignore[no-untyped-def]
    A, column, tile, at, f, S, row
):
    """Three rows: ``sum_b w_b f_b`` of ``f (3, .)``, ``w`` the given column of ``A``."""
    for run in range(A.runs[tile], A.runs[tile + U(1)]):
        _run_interpolation(A, run, column, 3, at, f, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        s0 = s1 = s2 = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            b, w = A.indices[k], A.coefficient[column, k]
            s0 += w * f[0, b]
            s1 += w * f[1, b]
            s2 += w * f[2, b]
        q = U(row * STRIDE) + A.exception[e] - at
        S[q] = s0
        S[q + U(STRIDE)] = s1
        S[q + U(2 * STRIDE)] = s2


@register_jitable
def interpolate_tensor(  # type: ignore[no-untyped-def]
    A, column, tile, at, f, S, row
):
    """Nine rows: ``sum_b w_b f_b`` of a tensor ``f``, ``w`` the given column of ``A``."""
    if f.ndim == 2:
        for run in range(A.runs[tile], A.runs[tile + U(1)]):
            _run_interpolation(A, run, column, 9, at, f, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            total = axpy(A.coefficient[column, k], tensor_of(f, A.indices[k]), total)
        store_lane(total, S, row, A.exception[e] - at)


@inlined
def tensor_of(f: Any, b: Any) -> Tensor:
    """Tensor of particle ``b`` from a field in either layout."""
    if f.ndim == 2:
        return (f[0, b], f[1, b], f[2, b], f[3, b], f[4, b], f[5, b], f[6, b], f[7, b], f[8, b])
    else:
        return load(f, b)


@register_jitable
def divergence(  # type: ignore[no-untyped-def]
    A, tile, at, T, S, row
):
    """Rows ``row .. row + 2``: ``sum_b T_b g_b`` of a tensor ``T``."""
    if T.ndim == 2:
        for run in range(A.runs[tile], A.runs[tile + U(1)]):
            _run_divergence(A, run, at, T, 3, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        s0 = s1 = s2 = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            g0, g1, g2 = A.coefficient[0, k], A.coefficient[1, k], A.coefficient[2, k]
            T_b = tensor_of(T, A.indices[k])
            s0 += T_b[0] * g0 + T_b[1] * g1 + T_b[2] * g2
            s1 += T_b[3] * g0 + T_b[4] * g1 + T_b[5] * g2
            s2 += T_b[6] * g0 + T_b[7] * g1 + T_b[8] * g2
        q = U(row * STRIDE) + A.exception[e] - at
        S[q] = s0
        S[q + U(STRIDE)] = s1
        S[q + U(2 * STRIDE)] = s2


@register_jitable
def flux_divergence(  # type: ignore[no-untyped-def]
    A, tile, at, f, S, row
):
    """Scratch row ``row``: ``sum_b f_b . g_b`` of ``f (3, .)``."""
    for run in range(A.runs[tile], A.runs[tile + U(1)]):
        _run_divergence(A, run, at, f, 1, S, row)
    for e in range(A.first[tile], A.first[tile + U(1)]):
        total = 0.0
        for k in range(A.indptr[e], A.indptr[e + U(1)]):
            b = A.indices[k]
            total += f[0, b] * A.coefficient[0, k] + f[1, b] * A.coefficient[1, k] + (
                f[2, b] * A.coefficient[2, k]
            )
        S[U(row * STRIDE) + A.exception[e] - at] = total
