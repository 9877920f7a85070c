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
from sphsolid.fields import LANES
from sphsolid.scheme.tile import STRIDE, U, load_lane, store_lane


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

    ``base`` is the number of the first of them on the line with index 0 along the axis.  Written
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
def _along(f, c, line, at, k0, count, add, S, q):  # type: ignore[no-untyped-def]
    """Difference of row ``c`` of ``f`` along the line that begins at ``at``, from ``k0`` on."""
    if not add:
        for k in range(count):
            S[q + k] = 0.0
    end = k0 + count
    low, high = max(k0, line.begin), min(end, line.end)
    for k in range(low, high):
        S[q + k - k0] += central(f, c, at + k, U(1), line)
    for side in range(2):
        first = k0 if side == 0 else max(k0, line.end)
        last = min(end, line.begin) if side == 0 else end
        for k in range(first, last):
            total = 0.0
            for m in range(U(line.row.shape[1])):
                total += line.row[k, m] * f[c, at + line.first[k] + m]
            S[q + k - k0] += total


@inlined
def _gradient(f, grid, i, j, k0, count, row, S):  # type: ignore[no-untyped-def]
    """``grad f`` of the three rows of ``f`` on a piece of line ``(i, j)``, to scratch rows."""
    ny, nz = grid.y.n, grid.z.n
    plane = ny * nz
    for c in range(U(3)):
        q = U(row * STRIDE) + c * U(3 * STRIDE)
        _across(f, c, grid.x, i, j * nz + k0, plane, count, False, S, q)
        _across(f, c, grid.y, j, i * plane + k0, nz, count, False, S, q + U(STRIDE))
        _along(f, c, grid.z, i * plane + j * nz, k0, count, False, S, q + U(2 * STRIDE))


@inlined
def _smooth_line(S, q, line):  # type: ignore[no-untyped-def]
    """Filter a scratch line along itself, in place."""
    n = line.n
    before = S[q]
    for k in range(n - U(1)):
        here, after = S[q + k], S[q + k + U(1)]
        S[q + k] = here + (0.25 * (after - here) - 0.25 * (here - before)) / line.weight[k]
        before = here
    last = n - U(1)
    S[q + last] -= 0.25 * (S[q + last] - before) / line.weight[last]


@inlined
def _smooth_plane(S, plane, line_y, line_z, out, at):  # type: ignore[no-untyped-def]
    """Filter a plane of scratch lines along both axes, and write it to ``out`` from ``at``."""
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


#: Scratch rows of a piece of a line; a plane of lines follows them.
_F, _L, _P, _E, _V, _R, _PT = 0, 9, 18, 27, 30, 33, 36
_ROWS = 37
_PLANE = _ROWS * STRIDE


@kernel
def dilatation(along_x, along_y, along_z, x, out, scratch):  # type: ignore[no-untyped-def]
    """``J`` of positions ``x (3, .)``, filtered in the planes of the two fast axes, ``(1, .)``."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers = len(scratch)
    for t in prange(workers):
        S = scratch[t]
        # Made here: numba takes no tuple of tuples into a parallel loop.
        grid = Grid(along_x, along_y, along_z)
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                for k0 in range(U(0), nz, U(LANES)):
                    count = min(U(LANES), nz - k0)
                    _gradient(x, grid, i, j, k0, count, 0, S)
                    for k in range(count):
                        S[U(_PT * STRIDE) + k] = determinant(load_lane(S, _F, k))
                    q = U(_PLANE) + j * nz + k0
                    for k in range(count):
                        S[q + k] = S[U(_PT * STRIDE) + k]
            _smooth_plane(S, U(_PLANE), grid.y, grid.z, out, i * ny * nz)


@kernel
def smoothed_pressure(along_x, along_y, along_z, material, J, out, scratch):  # type: ignore[no-untyped-def]
    """``U'(S J)`` filtered in the planes ``(1, .)``; ``J (1, .)`` is what ``dilatation`` wrote."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers = len(scratch)
    for t in prange(workers):
        S = scratch[t]
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                q = U(_PLANE) + j * nz
                _smooth_across(J, along_x, i, (i * ny + j) * nz, ny * nz, nz, S, q)
                for k in range(nz):
                    S[q + k] = law.volumetric_pressure(material, S[q + k])
            _smooth_plane(S, U(_PLANE), along_y, along_z, out, i * ny * nz)


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
def _restrain(parts, line, axis, x, p, density, at, stride, low, high, count, inside, own, S, R):  # type: ignore[no-untyped-def]
    """``R`` of one axis on a piece of a line, and what its viscous part adds to the stress.

    ``at`` is the first of ``count`` particles; those from ``low`` to ``high`` have a difference
    about them.  The reciprocal weights of the middles along the axis are in the scratch at ``own``.
    """
    if not inside or high <= low:
        for c in range(U(3)):
            for k in range(count):
                R[U(3 * axis) + c, at + k] = 0.0
        return
    for c in range(U(3)):
        q = U(_E * STRIDE) + c * U(STRIDE)
        r = U(_V * STRIDE) + c * U(STRIDE)
        for k in range(count):
            S[q + k] = 0.0
            S[r + k] = 0.0
        if line.reach == U(2):
            _fourth(x, c, at + low, stride, high - low, S, q + low)
            _fourth(p, c, at + low, stride, high - low, S, r + low)
        else:
            _second(x, c, at + low, stride, high - low, S, q + low)
            _second(p, c, at + low, stride, high - low, S, r + low)
    stiffness = parts.stiffness / (line.dx * line.dx * line.dx * line.dx)
    viscosity = parts.viscosity / line.dx
    per_mass = 1.0 / density
    for k in range(count):
        e0 = S[U(_E * STRIDE) + k]
        e1 = S[U((_E + 1) * STRIDE) + k]
        e2 = S[U((_E + 2) * STRIDE) + k]
        v0 = S[U(_V * STRIDE) + k] * per_mass
        v1 = S[U((_V + 1) * STRIDE) + k] * per_mass
        v2 = S[U((_V + 2) * STRIDE) + k] * per_mass
        F, L, P = load_lane(S, _F, k), load_lane(S, _L, k), load_lane(S, _P, k)
        s0 = F[0] * v0 + F[3] * v1 + F[6] * v2 + (L[0] * e0 + L[3] * e1 + L[6] * e2) * per_mass
        s1 = F[1] * v0 + F[4] * v1 + F[7] * v2 + (L[1] * e0 + L[4] * e1 + L[7] * e2) * per_mass
        s2 = F[2] * v0 + F[5] * v1 + F[8] * v2 + (L[2] * e0 + L[5] * e1 + L[8] * e2) * per_mass
        s0, s1, s2 = viscosity * s0, viscosity * s1, viscosity * s2
        spring = stiffness * (e0 * e0 + e1 * e1 + e2 * e2)
        S[U(_R * STRIDE) + k] = spring * e0 + (F[0] * s0 + F[1] * s1 + F[2] * s2)
        S[U((_R + 1) * STRIDE) + k] = spring * e1 + (F[3] * s0 + F[4] * s1 + F[5] * s2)
        S[U((_R + 2) * STRIDE) + k] = spring * e2 + (F[6] * s0 + F[7] * s1 + F[8] * s2)
        # The middle of the difference is a particle: the share of its own norm along the axis.
        w = S[own + k]
        e0, e1, e2 = w * e0, w * e1, w * e2
        added = (
            P[0] + e0 * s0, P[1] + e0 * s1, P[2] + e0 * s2,
            P[3] + e1 * s0, P[4] + e1 * s1, P[5] + e1 * s2,
            P[6] + e2 * s0, P[7] + e2 * s1, P[8] + e2 * s2,
        )  # fmt: skip
        store_lane(added, S, _P, k)
    for c in range(U(3)):
        q = U(_R * STRIDE) + c * U(STRIDE)
        for k in range(count):
            R[U(3 * axis) + c, at + k] = S[q + k]


@kernel
def stress(  # type: ignore[no-untyped-def]
    along_x, along_y, along_z, material, parts, x, p, pressure, P, R, scratch
):
    """``P (9, .)`` and ``R (9, .)``; ``pressure (1, .)`` is what ``smoothed_pressure`` wrote."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers, plane = len(scratch), ny * nz
    for t in prange(workers):
        S = scratch[t]
        grid = Grid(along_x, along_y, along_z)
        own = U(_PT * STRIDE)
        rho = material.density
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            in_x = grid.x.reach > U(0) and grid.x.reach <= i and i + grid.x.reach < nx
            for j in range(ny):
                in_y = grid.y.reach > U(0) and grid.y.reach <= j and j + grid.y.reach < ny
                for k0 in range(U(0), nz, U(LANES)):
                    count = min(U(LANES), nz - k0)
                    at = (i * ny + j) * nz + k0
                    _gradient(x, grid, i, j, k0, count, _F, S)
                    _gradient(p, grid, i, j, k0, count, _L, S)
                    _smooth_across(pressure, grid.x, i, at, plane, count, S, U(_PT * STRIDE))
                    for k in range(count):
                        F = load_lane(S, _F, k)
                        H, J = cofactor(F), determinant(F)
                        excess = S[U(_PT * STRIDE) + k] - law.volumetric_pressure(material, J)
                        store_lane(axpy(excess, H, law.first_piola(material, F, H, J)), S, _P, k)
                    for k in range(count):
                        S[own + k] = 1.0 / grid.x.weight[i]
                    _restrain(
                        parts, grid.x, 0, x, p, rho, at, plane, U(0), count, count, in_x, own, S, R
                    )
                    for k in range(count):
                        S[own + k] = 1.0 / grid.y.weight[j]
                    _restrain(
                        parts, grid.y, 1, x, p, rho, at, nz, U(0), count, count, in_y, own, S, R
                    )
                    for k in range(count):
                        S[own + k] = 1.0 / grid.z.weight[k0 + k]
                    reach, past = grid.z.reach, nz - grid.z.reach
                    low = reach - k0 if reach > k0 else U(0)
                    high = count if k0 + count <= past else past - k0 if past > k0 else U(0)
                    _restrain(
                        parts, grid.z, 2, x, p, rho, at, U(1), low, high, count, reach > U(0), own,
                        S, R,
                    )  # fmt: skip
                    for c in range(U(9)):
                        q = U(_P * STRIDE) + c * U(STRIDE)
                        for k in range(count):
                            P[c, at + k] = S[q + k]


@inlined
def _take_back(R, c, line, index, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    """Subtract ``H^-1 D^T R`` across lines; ``D`` is symmetric about its middle."""
    reach = line.reach
    share = 1.0 / line.weight[index]
    if reach == U(2) and U(2) <= index and index + U(2) < line.n:
        for k in range(count):
            a = at + k
            value = (
                (R[c, a + U(2) * stride] + R[c, a - U(2) * stride])
                - 4.0 * (R[c, a + stride] + R[c, a - stride])
                + 6.0 * R[c, a]
            )
            S[q + k] -= share * value
        return
    for m in range(U(2) * reach + U(1)):
        if reach == U(2):
            w = 6.0 if m == U(2) else (-4.0 if m == U(1) or m == U(3) else 1.0)
        else:
            w = 2.0 if m == U(1) else -1.0
        if index + m >= reach and index + m - reach < line.n:
            b = at + m * stride - reach * stride
            for k in range(count):
                S[q + k] -= share * w * R[c, b + k]


@inlined
def _take_back_along(R, c, line, at, k0, count, S, q):  # type: ignore[no-untyped-def]
    """The same along the line, from ``k0`` on; ``at`` is its first particle."""
    n, reach = line.n, line.reach
    if reach == U(0):
        return
    low, high = max(k0, reach), min(k0 + count, n - reach)
    if reach == U(2):
        for k in range(low, high):
            a = at + k
            value = (
                (R[c, a + U(2)] + R[c, a - U(2)])
                - 4.0 * (R[c, a + U(1)] + R[c, a - U(1)])
                + 6.0 * R[c, a]
            )
            S[q + k - k0] -= value / line.weight[k]
    else:
        for k in range(low, high):
            a = at + k
            S[q + k - k0] -= (2.0 * R[c, a] - (R[c, a + U(1)] + R[c, a - U(1)])) / line.weight[k]
    for side in range(2):
        first = k0 if side == 0 else max(k0, n - reach)
        last = min(k0 + count, reach) if side == 0 else k0 + count
        for k in range(first, last):
            total = 0.0
            for m in range(U(2) * reach + U(1)):
                if reach == U(2):
                    w = 6.0 if m == U(2) else (-4.0 if m == U(1) or m == U(3) else 1.0)
                else:
                    w = 2.0 if m == U(1) else -1.0
                if k + m >= reach and k + m - reach < n:
                    total += w * R[c, at + k + m - reach]
            S[q + k - k0] -= total / line.weight[k]


@kernel
def force(along_x, along_y, along_z, P, R, out, scratch):  # type: ignore[no-untyped-def]
    """``DIV P - H^-1 D^T R  (3, .)`` [N/m^3], the free boundary included."""
    nx, ny, nz = along_x.n, along_y.n, along_z.n
    workers, plane = len(scratch), ny * nz
    for t in prange(workers):
        S = scratch[t]
        grid = Grid(along_x, along_y, along_z)
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            for j in range(ny):
                line = (i * ny + j) * nz
                for k0 in range(U(0), nz, U(LANES)):
                    count = min(U(LANES), nz - k0)
                    at = line + k0
                    for c in range(U(3)):
                        q = c * U(STRIDE)
                        r = U(3) * c
                        _across(P, r, grid.x, i, j * nz + k0, plane, count, False, S, q)
                        _across(P, r + U(1), grid.y, j, i * plane + k0, nz, count, True, S, q)
                        _along(P, r + U(2), grid.z, line, k0, count, True, S, q)
                        if i == U(0) or i == nx - U(1):
                            w = grid.x.edge if i == U(0) else -grid.x.edge
                            for k in range(count):
                                S[q + k] += w * P[r, at + k]
                        if j == U(0) or j == ny - U(1):
                            w = grid.y.edge if j == U(0) else -grid.y.edge
                            for k in range(count):
                                S[q + k] += w * P[r + U(1), at + k]
                        if k0 == U(0):
                            S[q] += grid.z.edge * P[r + U(2), line]
                        if k0 + count == nz:
                            S[q + count - U(1)] -= grid.z.edge * P[r + U(2), line + nz - U(1)]
                        _take_back(R, c, grid.x, i, at, plane, count, S, q)
                        _take_back(R, U(3) + c, grid.y, j, at, nz, count, S, q)
                        _take_back_along(R, U(6) + c, grid.z, line, k0, count, S, q)
                        for k in range(count):
                            out[c, at + k] = S[q + k]


def make_scratch(grid: Grid, workers: int) -> Any:
    """Scratch ``(workers, .)``: some rows and a plane for every thread."""
    return np.ones((workers, _PLANE + int(grid.y.n) * int(grid.z.n)))
