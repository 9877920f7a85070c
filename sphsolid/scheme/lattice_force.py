"""The displacement form on a box lattice in four passes over its lines.

With ``F = grad x`` by differences that sum by parts along the axes, a filter ``S`` that is
symmetric in the norm, and the fourth difference ``e = D x`` along each axis,

    dilatation          J = det F, filtered in the planes
    smoothed_pressure   U'(S J), filtered in the planes
    stress              P, and R of the restraint along each axis
    force               rho0 a = DIV P - H^-1 D^T R

Fields are component-major rows ``(components, .)`` (see ``fields``).  ``S`` along a line is
``I - (1/4) H^-1 D1^T D1``: weights 1/4, 1/2, 1/4 inside.  Threads take planes of the slowest axis,
and every sum is over one line in order, so the bits do not depend on their number.

**The restraint.**  Its potential is ``V c_4 mu |e|^4 / (4 dx^4)`` and its dissipation potential
``V c_v rho0 c |d(F^T e)/dt|^2 / (2 dx)``, with ``F`` at the middle of the difference.  Both are
invariant under rigid motions, so their forces have neither resultant nor moment, and the second
takes energy at any state.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sphsolid.cloud.lattice.lines import Grid, Lines, Lines4, Lines6
from sphsolid.compiled import inlined, kernel, overload, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, determinant

U = np.uint64


class RestraintParts(NamedTuple):
    """``stiffness`` is ``c_4 mu`` [Pa], ``viscosity`` is ``c_v rho0 c`` [kg/(m^2 s)]."""

    stiffness: float
    viscosity: float


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
def _across(f, c, line, i, base, stride, count, add, S, q):  # type: ignore[no-untyped-def]
    """Difference of row ``c`` of ``f`` across lines, at ``count`` neighbours on a line.

    ``base`` is the number of the first particle of the line with index 0 along the axis.  Written
    to the scratch at ``q``, or added.
    """
    if line.begin <= i and i < line.end:
        at = base + i * stride
        if add:
            for k in range(count):
                S[q + k] += central(f, c, at + k, stride, line)
        else:
            for k in range(count):
                S[q + k] = central(f, c, at + k, stride, line)
    else:
        if not add:
            for k in range(count):
                S[q + k] = 0.0
        for m in range(U(line.row.shape[1])):
            w = line.row[i, m]
            if w != 0.0:
                at = base + (line.first[i] + m) * stride
                for k in range(count):
                    S[q + k] += w * f[c, at + k]


@inlined
def _along(f, c, line, at, add, S, q):  # type: ignore[no-untyped-def]
    """Difference of row ``c`` of ``f`` along the line that begins at ``at``."""
    n = line.n
    if not add:
        for k in range(n):
            S[q + k] = 0.0
    for k in range(line.begin, line.end):
        S[q + k] += central(f, c, at + k, U(1), line)
    for side in range(2):
        low, high = (U(0), line.begin) if side == 0 else (line.end, n)
        for k in range(low, high):
            total = 0.0
            for m in range(U(line.row.shape[1])):
                total += line.row[k, m] * f[c, at + line.first[k] + m]
            S[q + k] += total


@inlined
def _gradient(f, grid, i, j, row, S, width):  # type: ignore[no-untyped-def]
    """``grad f`` of the three rows of ``f`` on line ``(i, j)``, to nine scratch rows."""
    ny, nz = grid.y.n, grid.z.n
    plane = ny * nz
    for c in range(U(3)):
        q = (U(row) + U(3) * c) * width
        _across(f, c, grid.x, i, j * nz, plane, nz, False, S, q)
        _across(f, c, grid.y, j, i * plane, nz, nz, False, S, q + width)
        _along(f, c, grid.z, i * plane + j * nz, False, S, q + U(2) * width)


@inlined
def _tensor(S, row, width, k):  # type: ignore[no-untyped-def]
    q = U(row) * width + k
    return (
        S[q], S[q + width], S[q + U(2) * width],
        S[q + U(3) * width], S[q + U(4) * width], S[q + U(5) * width],
        S[q + U(6) * width], S[q + U(7) * width], S[q + U(8) * width],
    )  # fmt: skip


@inlined
def _smooth_line(S, q, line):  # type: ignore[no-untyped-def]
    """Filter a scratch row along itself, in place."""
    n = line.n
    before = S[q]
    for k in range(n - U(1)):
        here, after = S[q + k], S[q + k + U(1)]
        flux = 0.25 * (after - here)
        left = 0.25 * (here - before)
        S[q + k] = here + (flux - left) / line.weight[k]
        before = here
    last = n - U(1)
    S[q + last] -= 0.25 * (S[q + last] - before) / line.weight[last]


@inlined
def _smooth_plane(S, plane, T, line_y, line_z, out, at):  # type: ignore[no-untyped-def]
    """Filter a plane of scratch lines along both of its axes, and write it to ``out`` from ``at``.

    ``T`` is room for one line.
    """
    ny, nz = line_y.n, line_z.n
    for j in range(ny):
        _smooth_line(S, plane + j * nz, line_z)
    for j in range(ny):
        q = plane + j * nz
        share = 0.25 / line_y.weight[j]
        to = at + j * nz
        if j == U(0):
            for k in range(nz):
                out[0, to + k] = S[q + k] + share * (S[q + nz + k] - S[q + k])
        elif j == ny - U(1):
            for k in range(nz):
                out[0, to + k] = S[q + k] + share * (S[q - nz + k] - S[q + k])
        else:
            for k in range(nz):
                here = S[q + k]
                out[0, to + k] = here + share * ((S[q + nz + k] - here) + (S[q - nz + k] - here))


@inlined
def _smooth_across(f, line, i, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    """Filter ``f (1, .)`` across lines: the line that begins at ``at``, to the scratch at ``q``."""
    share = 0.25 / line.weight[i]
    if i == U(0):
        for k in range(count):
            here = f[0, at + k]
            S[q + k] = here + share * (f[0, at + stride + k] - here)
    elif i == line.n - U(1):
        for k in range(count):
            here = f[0, at + k]
            S[q + k] = here + share * (f[0, at - stride + k] - here)
    else:
        for k in range(count):
            here = f[0, at + k]
            S[q + k] = here + share * (
                (f[0, at + stride + k] - here) + (f[0, at - stride + k] - here)
            )


@kernel
def dilatation(along_x, along_y, along_z, x, out, scratch):  # type: ignore[no-untyped-def]
    """``J`` of positions ``x (3, .)``, filtered in the planes of the two fast axes, ``(1, .)``."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers = len(scratch)
    for t in prange(workers):
        S = scratch[t]
        # Made here: numba takes no tuple of tuples into a parallel loop.
        grid = Grid(along_x, along_y, along_z)
        plane = U(9) * nz
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                _gradient(x, grid, i, j, 0, S, nz)
                for k in range(nz):
                    S[plane + j * nz + k] = determinant(_tensor(S, 0, nz, k))
            _smooth_plane(S, plane, U(0), grid.y, grid.z, out, i * ny * nz)


@kernel
def smoothed_pressure(along_x, along_y, along_z, material, J, out, scratch):  # type: ignore[no-untyped-def]
    """``U'(S J)`` filtered in the planes ``(1, .)``; ``J (1, .)`` is what ``dilatation`` wrote."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers = len(scratch)
    for t in prange(workers):
        S = scratch[t]
        # Made here: numba takes no tuple of tuples into a parallel loop.
        grid = Grid(along_x, along_y, along_z)
        plane = U(9) * nz
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                q = plane + j * nz
                _smooth_across(J, grid.x, i, (i * ny + j) * nz, ny * nz, nz, S, q)
                for k in range(nz):
                    S[q + k] = law.volumetric_pressure(material, S[q + k])
            _smooth_plane(S, plane, U(0), grid.y, grid.z, out, i * ny * nz)


# Scratch rows of ``stress``.
_F, _L, _P, _E, _V, _PT = 0, 9, 18, 27, 30, 33
#: Scratch lines that a thread needs, and as many planes.
ROWS = 34


@inlined
def _fourth(f, c, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    for k in range(count):
        a = at + k
        S[q + k] = (
            (f[c, a + U(2) * stride] + f[c, a - U(2) * stride])
            - 4.0 * (f[c, a + stride] + f[c, a - stride])
            + 6.0 * f[c, a]
        )


@inlined
def _second(f, c, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    for k in range(count):
        a = at + k
        S[q + k] = 2.0 * f[c, a] - (f[c, a + stride] + f[c, a - stride])


@inlined
def _restrain(parts, line, index, axis, x, p, density, at, stride, low, high, S, width, R):  # type: ignore[no-untyped-def]
    """``R`` of one axis on a line, and what its viscous part adds to the stress."""
    nz = width
    reach = line.reach
    for c in range(U(3)):
        for k in range(nz):
            R[U(3) * axis + c, at + k] = 0.0
    inside = reach > U(0) and reach <= index and index + reach < line.n
    if not inside or high <= low:
        return
    count = high - low
    for c in range(U(3)):
        q = U(_E) * width + c * width + low
        r = U(_V) * width + c * width + low
        if reach == U(2):
            _fourth(x, c, at + low, stride, count, S, q)
            _fourth(p, c, at + low, stride, count, S, r)
        else:
            _second(x, c, at + low, stride, count, S, q)
            _second(p, c, at + low, stride, count, S, r)
    stiffness = parts.stiffness / (line.dx * line.dx * line.dx * line.dx)
    viscosity = parts.viscosity / line.dx
    e, v = U(_E) * width, U(_V) * width
    w2 = width + width
    for k in range(low, high):
        e0, e1, e2 = S[e + k], S[e + width + k], S[e + w2 + k]
        v0, v1, v2 = S[v + k] / density, S[v + width + k] / density, S[v + w2 + k] / density
        F, L, P = _tensor(S, _F, width, k), _tensor(S, _L, width, k), _tensor(S, _P, width, k)
        s0 = F[0] * v0 + F[3] * v1 + F[6] * v2 + L[0] * e0 + L[3] * e1 + L[6] * e2
        s1 = F[1] * v0 + F[4] * v1 + F[7] * v2 + L[1] * e0 + L[4] * e1 + L[7] * e2
        s2 = F[2] * v0 + F[5] * v1 + F[8] * v2 + L[2] * e0 + L[5] * e1 + L[8] * e2
        s0, s1, s2 = viscosity * s0, viscosity * s1, viscosity * s2
        spring = stiffness * (e0 * e0 + e1 * e1 + e2 * e2)
        a = at + k
        R[U(3) * axis, a] = spring * e0 + F[0] * s0 + F[1] * s1 + F[2] * s2
        R[U(3) * axis + U(1), a] = spring * e1 + F[3] * s0 + F[4] * s1 + F[5] * s2
        R[U(3) * axis + U(2), a] = spring * e2 + F[6] * s0 + F[7] * s1 + F[8] * s2
        # The middle of the difference is a particle of this line: its own weight, or that of k.
        own = 1.0 / (line.weight[k] if axis == U(2) else line.weight[index])
        q = U(_P) * width + k
        S[q] = P[0] + own * e0 * s0
        S[q + width] = P[1] + own * e0 * s1
        S[q + U(2) * width] = P[2] + own * e0 * s2
        S[q + U(3) * width] = P[3] + own * e1 * s0
        S[q + U(4) * width] = P[4] + own * e1 * s1
        S[q + U(5) * width] = P[5] + own * e1 * s2
        S[q + U(6) * width] = P[6] + own * e2 * s0
        S[q + U(7) * width] = P[7] + own * e2 * s1
        S[q + U(8) * width] = P[8] + own * e2 * s2


@kernel
def stress(along_x, along_y, along_z, material, parts, x, p, pressure, P, R, scratch):  # type: ignore[no-untyped-def]
    """``P (9, .)`` and ``R (9, .)``; ``pressure (1, .)`` is what ``smoothed_pressure`` wrote."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers, plane = len(scratch), ny * nz
    for t in prange(workers):
        S = scratch[t]
        # Made here: numba takes no tuple of tuples into a parallel loop.
        grid = Grid(along_x, along_y, along_z)
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                at = (i * ny + j) * nz
                _gradient(x, grid, i, j, _F, S, nz)
                _gradient(p, grid, i, j, _L, S, nz)
                for q in range(U(_L) * nz, U(_P) * nz):
                    S[q] /= material.density
                _smooth_across(pressure, grid.x, i, at, plane, nz, S, U(_PT) * nz)
                for k in range(nz):
                    F = _tensor(S, _F, nz, k)
                    H, J = cofactor(F), determinant(F)
                    excess = S[U(_PT) * nz + k] - law.volumetric_pressure(material, J)
                    A = axpy(excess, H, law.first_piola(material, F, H, J))
                    q = U(_P) * nz + k
                    S[q] = A[0]
                    S[q + nz] = A[1]
                    S[q + U(2) * nz] = A[2]
                    S[q + U(3) * nz] = A[3]
                    S[q + U(4) * nz] = A[4]
                    S[q + U(5) * nz] = A[5]
                    S[q + U(6) * nz] = A[6]
                    S[q + U(7) * nz] = A[7]
                    S[q + U(8) * nz] = A[8]
                rho = material.density
                _restrain(
                    parts, grid.x, i, U(0), x, p, rho, at, plane, U(0), nz, S, nz, R
                )
                _restrain(parts, grid.y, j, U(1), x, p, rho, at, nz, U(0), nz, S, nz, R)
                reach = grid.z.reach
                _restrain(
                    parts, grid.z, reach, U(2), x, p, rho, at, U(1), reach, nz - reach, S, nz, R
                )
                for c in range(U(9)):
                    for k in range(nz):
                        P[c, at + k] = S[(U(_P) + c) * nz + k]


@inlined
def _take_back(R, c, line, index, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    """Subtract ``H^-1 D^T R`` across lines."""
    reach = line.reach
    for m in range(U(2) * reach + U(1)):
        # D is symmetric about its middle, so D^T has the same coefficients.
        if reach == U(2):
            w = 6.0 if m == U(2) else (-4.0 if m == U(1) or m == U(3) else 1.0)
        else:
            w = 2.0 if m == U(1) else -1.0
        if index + m >= reach and index + m - reach < line.n:
            share = w / line.weight[index]
            b = at + m * stride - reach * stride
            for k in range(count):
                S[q + k] -= share * R[c, b + k]


@inlined
def _take_back_along(R, c, line, at, S, q):  # type: ignore[no-untyped-def]
    """The same along the line; ``R`` is zero at its ends."""
    n, reach = line.n, line.reach
    if reach == U(2):
        for k in range(U(2), n - U(2)):
            a = at + k
            value = (
                (R[c, a + U(2)] + R[c, a - U(2)])
                - 4.0 * (R[c, a + U(1)] + R[c, a - U(1)])
                + 6.0 * R[c, a]
            )
            S[q + k] -= value / line.weight[k]
        last = n - U(1)
        S[q] -= R[c, at + U(2)] / line.weight[0]
        S[q + last] -= R[c, at + last - U(2)] / line.weight[last]
        near = last - U(1)
        one = -4.0 * R[c, at + U(2)] + (R[c, at + U(3)] if n > U(5) else 0.0)
        S[q + U(1)] -= one / line.weight[1]
        other = -4.0 * R[c, at + last - U(2)] + (R[c, at + last - U(3)] if n > U(5) else 0.0)
        S[q + near] -= other / line.weight[near]
    elif reach == U(1):
        last = n - U(1)
        for k in range(U(1), last):
            a = at + k
            S[q + k] -= (2.0 * R[c, a] - (R[c, a + U(1)] + R[c, a - U(1)])) / line.weight[k]
        S[q] += R[c, at + U(1)] / line.weight[0]
        S[q + last] += R[c, at + last - U(1)] / line.weight[last]


@kernel
def force(along_x, along_y, along_z, P, R, out, scratch):  # type: ignore[no-untyped-def]
    """``DIV P - H^-1 D^T R  (3, .)`` [N/m^3], the free boundary included."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers, plane = len(scratch), ny * nz
    for t in prange(workers):
        S = scratch[t]
        # Made here: numba takes no tuple of tuples into a parallel loop.
        grid = Grid(along_x, along_y, along_z)
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                at = (i * ny + j) * nz
                for c in range(U(3)):
                    q = c * nz
                    r = U(3) * c
                    _across(P, r, grid.x, i, j * nz, plane, nz, False, S, q)
                    _across(P, r + U(1), grid.y, j, i * plane, nz, nz, True, S, q)
                    _along(P, r + U(2), grid.z, at, True, S, q)
                    if i == U(0) or i == nx - U(1):
                        w = grid.x.edge if i == U(0) else -grid.x.edge
                        for k in range(nz):
                            S[q + k] += w * P[r, at + k]
                    if j == U(0) or j == ny - U(1):
                        w = grid.y.edge if j == U(0) else -grid.y.edge
                        for k in range(nz):
                            S[q + k] += w * P[r + U(1), at + k]
                    S[q] += grid.z.edge * P[r + U(2), at]
                    S[q + nz - U(1)] -= grid.z.edge * P[r + U(2), at + nz - U(1)]
                    _take_back(R, c, grid.x, i, at, plane, nz, S, q)
                    _take_back(R, U(3) + c, grid.y, j, at, nz, nz, S, q)
                    _take_back_along(R, U(6) + c, grid.z, at, S, q)
                    for k in range(nz):
                        out[c, at + k] = S[q + k]


def make_scratch(grid: Grid, workers: int) -> Any:
    """Scratch ``(workers, .)``: some lines and a plane for every thread."""
    ny, nz = int(grid.y.n), int(grid.z.n)
    return np.ones((workers, (ROWS + ny) * nz))
