"""Differences along the axes of a box lattice, on one tile of a plane of particles.

A *tile* is a run of consecutive particles of one plane of the two fast axes: some whole lines, or
a piece of one long line.  Inside, a difference along any axis has the same coefficients for all of
them, so its loop runs through the tile as if there were one line; the few particles whose row is
another one are written after it.

Results go to *scratch rows* (see ``tile``) of ``STRIDE`` numbers.  ``q`` is where the first of
three rows begins and ``apart`` their distance; field rows are ``r, r + step, r + 2 step``.  Every
function is inlined, and no kernel makes a view of an array inside its parallel loop: only then
numba tells the compiler that arrays do not overlap, and loops with many of them use whole vector
registers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sphsolid.cloud.lattice.lines import Grid, Lines, Lines4, Lines6
from sphsolid.compiled import inlined, overload

U = np.uint64
#: Particles of a tile at most, and the distance of scratch rows.
LANES = 104
STRIDE = 112


class Tile(NamedTuple):
    """Lines ``begin <= j < end`` of plane ``i``, from ``k0`` on ``width`` particles of each.

    ``at`` is the number of the first particle, ``lane`` its place in the plane, ``count`` how many.
    """

    i: Any
    begin: Any
    end: Any
    k0: Any
    width: Any
    lane: Any
    at: Any
    count: Any


@inlined
def share(t, workers, planes):  # type: ignore[no-untyped-def]
    """First plane and the one after the last of worker ``t``."""
    return U(t) * planes // U(workers), (U(t) + U(1)) * planes // U(workers)


@inlined
def extent(grid: Grid) -> Any:
    """How many lines a tile has, and how many particles of each."""
    ny, nz = grid.y.n, grid.z.n
    most = max(U(1), U(LANES) // nz)
    tiles, pieces = (ny + most - U(1)) // most, (nz + U(LANES - 1)) // U(LANES)
    return (ny + tiles - U(1)) // tiles, (nz + pieces - U(1)) // pieces


@inlined
def make_tile(grid, i, j, k0, lines, width):  # type: ignore[no-untyped-def]
    """The tile of ``lines`` and ``width`` that begins at ``(i, j, k0)``, less what is outside."""
    ny, nz = grid.y.n, grid.z.n
    end = min(j + lines, ny)
    width = min(nz - k0, width)
    lane = j * nz + k0
    return Tile(i, j, end, k0, width, lane, i * ny * nz + lane, (end - j) * width)


def central(f: Any, c: Any, at: Any, stride: Any, line: Any) -> Any:
    """``sum_m a_m (f_(at + m stride) - f_(at - m stride))`` of row ``c``."""
    return sum(
        a * (f[c, at + U(m) * stride] - f[c, at - U(m) * stride])
        for m, a in enumerate((line.one, line.two, line.three), start=1)
        if a
    )


@overload(central, jit_options={"forceinline": True})
def _central(f, c, at, stride, line):  # type: ignore[no-untyped-def]
    def second(f, c, at, stride, line):  # type: ignore[no-untyped-def]
        return line.one * (f[c, at + stride] - f[c, at - stride])

    def fourth(f, c, at, stride, line):  # type: ignore[no-untyped-def]
        return line.one * (f[c, at + stride] - f[c, at - stride]) + line.two * (
            f[c, at + U(2) * stride] - f[c, at - U(2) * stride]
        )

    def sixth(f, c, at, stride, line):  # type: ignore[no-untyped-def]
        return (
            line.one * (f[c, at + stride] - f[c, at - stride])
            + line.two * (f[c, at + U(2) * stride] - f[c, at - U(2) * stride])
            + line.three * (f[c, at + U(3) * stride] - f[c, at - U(3) * stride])
        )

    return {Lines: second, Lines4: fourth, Lines6: sixth}[line.instance_class]


@inlined
def _inner(f, r, step, line, at, stride, count, add, S, q, apart):  # type: ignore[no-untyped-def]
    """Central differences at ``count`` particles from ``at`` on."""
    r1, r2, q1, q2 = r + step, r + step + step, q + apart, q + apart + apart
    if add:
        for k in range(count):
            S[q + k] += central(f, r, at + k, stride, line)
            S[q1 + k] += central(f, r1, at + k, stride, line)
            S[q2 + k] += central(f, r2, at + k, stride, line)
    else:
        for k in range(count):
            S[q + k] = central(f, r, at + k, stride, line)
            S[q1 + k] = central(f, r1, at + k, stride, line)
            S[q2 + k] = central(f, r2, at + k, stride, line)


@inlined
def _outer(f, r, step, line, index, at, stride, count, add, S, q, apart):  # type: ignore[no-untyped-def]
    """Row ``index`` of the difference, for ``count`` neighbours across lines from ``at`` on."""
    r1, r2, q1, q2 = r + step, r + step + step, q + apart, q + apart + apart
    origin = at - index * stride + line.first[index] * stride
    for m in range(U(0), U(line.row.shape[1]), U(2)):
        u, w = line.row[index, m], line.row[index, m + U(1)]
        a = origin + m * stride
        # The last of an odd number has no partner, nor needs there be a particle.
        b = a + stride if w != 0.0 else a
        if add or m > U(0):
            for k in range(count):
                S[q + k] += u * f[r, a + k] + w * f[r, b + k]
                S[q1 + k] += u * f[r1, a + k] + w * f[r1, b + k]
                S[q2 + k] += u * f[r2, a + k] + w * f[r2, b + k]
        else:
            for k in range(count):
                S[q + k] = u * f[r, a + k] + w * f[r, b + k]
                S[q1 + k] = u * f[r1, a + k] + w * f[r1, b + k]
                S[q2 + k] = u * f[r2, a + k] + w * f[r2, b + k]


@inlined
def across_planes(f, r, step, grid, tile, S, q, apart):  # type: ignore[no-untyped-def]
    """Difference along the slow axis."""
    line, stride = grid.x, grid.y.n * grid.z.n
    if line.begin <= tile.i and tile.i < line.end:
        _inner(f, r, step, line, tile.at, stride, tile.count, False, S, q, apart)
    else:
        _outer(f, r, step, line, tile.i, tile.at, stride, tile.count, False, S, q, apart)


@inlined
def across_lines(f, r, step, grid, tile, at, add, S, q, apart):  # type: ignore[no-untyped-def]
    """Difference along the middle axis, written or added; the tile begins at ``at`` in ``f``."""
    line, stride, width = grid.y, grid.z.n, tile.width
    begin, end = max(tile.begin, line.begin), min(tile.end, line.end)
    if begin < end:
        skip = (begin - tile.begin) * width
        count = (end - begin) * width
        _inner(f, r, step, line, at + skip, stride, count, add, S, q + skip, apart)
    for j in range(tile.begin, tile.end):
        if j < line.begin or j >= line.end:
            skip = (j - tile.begin) * width
            _outer(f, r, step, line, j, at + skip, stride, width, add, S, q + skip, apart)


@inlined
def along_lines(f, r, step, grid, tile, at, S, q, apart):  # type: ignore[no-untyped-def]
    """Difference along the fast axis; ``at`` as in ``across_lines``."""
    line, k0, k1 = grid.z, tile.k0, tile.k0 + tile.width
    r1, r2 = r + step, r + step + step
    low = line.begin - k0 if line.begin > k0 else U(0)
    cut = k1 - line.end if k1 > line.end else U(0)
    if line.begin < line.end and low + cut < tile.count:
        count = tile.count - low - cut
        _inner(f, r, step, line, at + low, U(1), count, False, S, q + low, apart)
    for j in range(tile.end - tile.begin):
        start, skip = at + j * tile.width - k0, q + j * tile.width - k0
        for side in range(2):
            first = k0 if side == 0 else max(k0, line.end)
            last = min(k1, line.begin) if side == 0 else k1
            if first < last:
                for k in range(first, last, U(2)):
                    n = k + U(1) if k + U(1) < last else k
                    a, b = start + line.first[k], start + line.first[n]
                    s0 = s1 = s2 = t0 = t1 = t2 = 0.0
                    for m in range(U(line.row.shape[1])):
                        u, w = line.row[k, m], line.row[n, m]
                        s0 += u * f[r, a + m]
                        s1 += u * f[r1, a + m]
                        s2 += u * f[r2, a + m]
                        t0 += w * f[r, b + m]
                        t1 += w * f[r1, b + m]
                        t2 += w * f[r2, b + m]
                    S[skip + k], S[skip + apart + k], S[skip + apart + apart + k] = s0, s1, s2
                    S[skip + n], S[skip + apart + n], S[skip + apart + apart + n] = t0, t1, t2


@inlined
def gradient(f, grid, tile, S, q):  # type: ignore[no-untyped-def]
    """``grad f  (3, 3)`` of the three rows of ``f``, to nine scratch rows from ``q`` on."""
    apart, one = U(3 * STRIDE), U(1)
    q_x, q_y, q_z = (
        q + grid.x.column * U(STRIDE), q + grid.y.column * U(STRIDE), q + grid.z.column * U(STRIDE)
    )  # fmt: skip
    across_planes(f, U(0), one, grid, tile, S, q_x, apart)
    across_lines(f, U(0), one, grid, tile, tile.at, False, S, q_y, apart)
    along_lines(f, U(0), one, grid, tile, tile.at, S, q_z, apart)


@inlined
def divergence_in_plane(P, y, z, step, grid, tile, at, S, q):  # type: ignore[no-untyped-def]
    """The fast axes' part of ``DIV P`` with the free boundary, to three scratch rows from ``q`` on.

    Their columns of ``P`` are its rows ``y, y + step, y + 2 step`` and likewise from ``z`` on; the
    tile begins at ``at`` in them.
    """
    one, apart = U(1), U(STRIDE)
    along_lines(P, z, step, grid, tile, at, S, q, apart)
    across_lines(P, y, step, grid, tile, at, True, S, q, apart)
    ny, nz, edge_y, edge_z = grid.y.n, grid.z.n, grid.y.edge, grid.z.edge
    for j in range(tile.begin, tile.end):
        skip = (j - tile.begin) * tile.width
        if j == U(0) or j == ny - one:
            w = edge_y if j == U(0) else -edge_y
            _edge(P, y, step, w, at + skip, tile.width, S, q + skip)
        if tile.k0 == U(0):
            _edge(P, z, step, edge_z, at + skip, one, S, q + skip)
        if tile.k0 + tile.width == nz:
            last = skip + tile.width - one
            _edge(P, z, step, -edge_z, at + last, one, S, q + last)


@inlined
def divergence_across(P, x, step, grid, tile, S, q):  # type: ignore[no-untyped-def]
    """The slow axis' part of ``DIV P``, of its column in rows ``x, x + step, x + 2 step``."""
    line = grid.x
    across_planes(P, x, step, grid, tile, S, q, U(STRIDE))
    if tile.i == U(0) or tile.i == line.n - U(1):
        w = line.edge if tile.i == U(0) else -line.edge
        _edge(P, x, step, w, tile.at, tile.count, S, q)


@inlined
def _edge(P, r, step, w, at, count, S, q):  # type: ignore[no-untyped-def]
    for c in range(U(3)):
        for k in range(count):
            S[q + c * U(STRIDE) + k] += w * P[r + c * step, at + k]


@inlined
def tensor_at(S, q):  # type: ignore[no-untyped-def]
    """Nine entries from scratch rows that begin at ``q``."""
    return (
        S[q], S[q + U(STRIDE)], S[q + U(2 * STRIDE)],
        S[q + U(3 * STRIDE)], S[q + U(4 * STRIDE)], S[q + U(5 * STRIDE)],
        S[q + U(6 * STRIDE)], S[q + U(7 * STRIDE)], S[q + U(8 * STRIDE)],
    )  # fmt: skip


@inlined
def tensor_to(A, S, q):  # type: ignore[no-untyped-def]
    """Nine entries to scratch rows that begin at ``q``."""
    S[q], S[q + U(STRIDE)], S[q + U(2 * STRIDE)] = A[0], A[1], A[2]
    S[q + U(3 * STRIDE)], S[q + U(4 * STRIDE)], S[q + U(5 * STRIDE)] = A[3], A[4], A[5]
    S[q + U(6 * STRIDE)], S[q + U(7 * STRIDE)], S[q + U(8 * STRIDE)] = A[6], A[7], A[8]
