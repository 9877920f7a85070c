"""The displacement form on a box lattice: the passes of a launch (see ``lattice_step``).

Forces from positions.  With ``F = grad x`` by differences that sum by parts along the axes, a
filter ``S`` that is symmetric in the norm, and the restraint of ``lattice_restraint``,

    dilatation   J = det F, filtered in the planes
    pressure     U'(S J), filtered in the planes
    stress       P and R of the restraint, and what both do in the planes
    force        rho0 a = DIV P - H^-1 D^T R, the part across the planes added

Without a filter there are the last two.  Of ``P`` and ``R``, only what acts across planes is kept
for all particles; the rest is used up while it is in a core's cache.  Vectors and tensors are
component-major rows ``(components, .)`` (see ``fields``).  Threads take planes of the slowest axis,
and every sum is over one line in order, so the bits do not depend on their number.

The pressure is that of the energy ``U(S J) + k (J - S J)^2 / 2``: filtered once more,

    S U'(S J) + k (I - S) (J - S J).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sphsolid.cloud.lattice.lines import Grid
from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, determinant
from sphsolid.fields import leading
from sphsolid.scheme.lattice_arguments import unpacked_grid
from sphsolid.scheme.lattice_filter import smooth_across, smooth_in_plane
from sphsolid.scheme.lattice_restraint import (
    restrain,
    shares,
    subtract_across,
    subtract_in_plane,
)
from sphsolid.scheme.lattice_stretch import mark
from sphsolid.scheme.lattice_sums import (
    STRIDE,
    U,
    divergence_across,
    divergence_in_plane,
    extent,
    gradient,
    make_tile,
    share,
    tensor_at,
    tensor_to,
)

#: Scratch rows of a tile; two planes with three lines around each follow them.
_F, _L, _P, _E, _ROW = 0, 9 * STRIDE, 18 * STRIDE, 27 * STRIDE, 33 * STRIDE
_PLANE = 34 * STRIDE


class Work(NamedTuple):
    """What the passes hand on.

    ``J``, ``difference``, ``pressure (.)`` of the filter; ``P (3, .)`` the stress on planes of the
    slow axis; ``R (3, .)`` of that axis, two planes of zeros before and after.  ``planes (12, .)``
    has for each of ``workers`` one plane of what acts in it, ``P`` and ``R`` of the middle and of
    the fast axis; ``scratch (.)`` has the rows of a tile and two planes.
    """

    J: Any
    difference: Any
    pressure: Any
    P: Any
    R: Any
    planes: Any
    scratch: Any
    workers: int


def make_work(grid: Grid, *, workers: int, filtered: bool, restrained: bool, beta: bool) -> Work:
    """Work arrays of one body; what is not used is empty."""
    nx, ny, nz = (int(axis.n) for axis in grid)
    row, plane = leading(nx * ny * nz), ny * nz
    planes = 2 * plane + 9 * nz + 8 if filtered else 0
    return Work(
        J=np.ones(row if filtered else 0),
        difference=np.zeros(row if filtered and beta else 0),
        pressure=np.zeros(row if filtered else 0),
        P=np.zeros((3, row)),
        R=np.zeros((3, leading((nx + 4) * plane) if restrained else 0)),
        planes=np.zeros((12 if restrained else 6, workers * leading(plane + 4 * nz))),
        # Ones: what stands beside a plane must be a number.
        scratch=np.ones(workers * (_PLANE + planes)),
        workers=workers,
    )


@inlined
def dilatation(  # type: ignore[no-untyped-def]
    t, marker, whole, real, of_x, of_y, of_z, tables, x, work, limit
):
    """``J`` of positions ``x (3, .)``, filtered in the planes of worker ``t``, and ``limit``."""
    grid, S = unpacked_grid(marker, whole, real, of_x, of_y, of_z), work.scratch
    ny, nz = grid.y.n, grid.z.n
    base = U(t) * (U(len(S)) // U(work.workers))
    q, one = base + U(_F), base + U(_PLANE) + U(3) * nz
    two = one + ny * nz + U(3) * nz
    first, last = share(t, work.workers, grid.x.n)
    lines, width = extent(grid)
    for i in range(first, last):
        for j in range(U(0), ny, lines):
            for k0 in range(U(0), nz, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                gradient(x, grid, tile, S, q)
                for k in range(tile.count):
                    S[one + tile.lane + k] = determinant(tensor_at(S, q + k))
                if len(work.difference) > 0:
                    for k in range(tile.count):
                        work.difference[tile.at + k] = S[one + tile.lane + k]
                if len(limit) > 0:
                    mark(S, q, tile, limit)
        smooth_in_plane(S, one, two, nz, tables, work.J, i * ny * nz)


@inlined
def pressure(  # type: ignore[no-untyped-def]
    t, marker, whole, real, of_x, of_y, of_z, tables, material, rest, work
):
    """``U'(S J)``, filtered in the planes."""
    S, J, difference = work.scratch, work.J, work.difference
    grid = unpacked_grid(marker, whole, real, of_x, of_y, of_z)
    ny, nz = grid.y.n, grid.z.n
    plane = ny * nz
    base = U(t) * (U(len(S)) // U(work.workers))
    one = base + U(_PLANE) + U(3) * nz
    two = one + plane + U(3) * nz
    first, last = share(t, work.workers, grid.x.n)
    for i in range(first, last):
        at = i * plane
        smooth_across(J, grid.x, i, at, plane, plane, tables.smoothing, S, one)
        if len(difference) > 0:
            for k in range(plane):
                difference[at + k] -= S[one + k]
                S[one + k] = law.volumetric_pressure(material, S[one + k]) - (
                    rest * difference[at + k]
                )
        else:
            for k in range(plane):
                S[one + k] = law.volumetric_pressure(material, S[one + k])
        smooth_in_plane(S, one, two, nz, tables, work.pressure, at)


@inlined
def _answer(material, grid, tables, rest, tile, work, limit, F, row, P):  # type: ignore[no-untyped-def]
    """The law at every particle of a tile: nine scratch rows from ``P`` on."""
    S = work.scratch
    if tables.smoothing > U(0):
        plane = grid.y.n * grid.z.n
        smooth_across(
            work.pressure, grid.x, tile.i, tile.at, plane, tile.count, tables.smoothing, S, row
        )
        if len(work.difference) > 0:
            for k in range(tile.count):
                S[row + k] += rest * work.difference[tile.at + k]
        for k in range(tile.count):
            A = tensor_at(S, F + k)
            H, J = cofactor(A), determinant(A)
            excess = S[row + k] - law.volumetric_pressure(material, J)
            tensor_to(axpy(excess, H, law.first_piola(material, A, H, J)), S, P + k)
    else:
        for k in range(tile.count):
            A = tensor_at(S, F + k)
            tensor_to(law.first_piola(material, A, cofactor(A), determinant(A)), S, P + k)
        if len(limit) > 0:
            mark(S, F, tile, limit)


@inlined
def _hand_on(S, q, grid, tile, P, planes, to):  # type: ignore[no-untyped-def]
    """Stresses of a tile: the slow axis' column for all to see, the others to the plane."""
    for c in range(U(3)):
        row = q + c * U(3 * STRIDE)
        q_x = row + grid.x.column * U(STRIDE)
        q_y = row + grid.y.column * U(STRIDE)
        q_z = row + grid.z.column * U(STRIDE)
        for k in range(tile.count):
            P[c, tile.at + k] = S[q_x + k]
            planes[c, to + k] = S[q_y + k]
            planes[U(3) + c, to + k] = S[q_z + k]


@inlined
def stress(  # type: ignore[no-untyped-def]
    t, marker, whole, real, of_x, of_y, of_z, tables, material, rest, parts, x, p, work, limit,
    out,
):  # fmt: skip
    """Stress and restraint, and what both do in the planes, to ``out (3, .)``."""
    grid = unpacked_grid(marker, whole, real, of_x, of_y, of_z)
    S, planes = work.scratch, work.planes
    ny, nz = grid.y.n, grid.z.n
    plane, base = ny * nz, U(t) * (U(len(S)) // U(work.workers))
    F, L, P = base + U(_F), base + U(_L), base + U(_P)
    e, row = base + U(_E), base + U(_ROW)
    start = U(t) * (U(planes.shape[1]) // U(work.workers)) + U(2) * nz
    first, last = share(t, work.workers, grid.x.n)
    lines, width = extent(grid)
    restrained, per_mass = work.R.shape[1] > 0, 1.0 / material.density
    damped = restrained and parts.viscosity != 0.0
    for i in range(first, last):
        for j in range(U(0), ny, lines):
            for k0 in range(U(0), nz, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                # Code that is written once is compiled once: loops over two fields and three axes.
                for part in range(2 if damped else 1):
                    gradient(x if part == 0 else p, grid, tile, S, F if part == 0 else L)
                _answer(material, grid, tables, rest, tile, work, limit, F, row, P)
                if damped:
                    shares(parts, tile, S, F, row)
                to = start + tile.lane
                for axis in range(3 if restrained else 0):
                    low, count = restrain(
                        parts, grid, tables, axis, tile, per_mass, x, p, S, F, L, P, e, row
                    )
                    pull = e + U(3 * STRIDE) + low
                    if axis == 0:
                        at = tile.at + plane + plane + low
                        for c in range(U(3)):
                            for k in range(count):
                                work.R[c, at + k] = S[pull + c * U(STRIDE) + k]
                    else:
                        r, at = U(6) if axis == 1 else U(9), to + low
                        for c in range(U(3)):
                            for k in range(count):
                                planes[r + c, at + k] = S[pull + c * U(STRIDE) + k]
                _hand_on(S, P, grid, tile, work.P, planes, to)
        for j in range(U(0), ny, lines):
            for k0 in range(U(0), nz, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                at = start + tile.lane
                divergence_in_plane(planes, U(0), U(3), U(1), grid, tile, at, S, F)
                if restrained:
                    subtract_in_plane(planes, U(6), U(9), grid, tables, tile, at, S, F)
                for c in range(U(3)):
                    for k in range(tile.count):
                        out[c, tile.at + k] = S[F + c * U(STRIDE) + k]


@inlined
def force(t, marker, whole, real, of_x, of_y, of_z, work, out):  # type: ignore[no-untyped-def]
    """The part across the planes, added to ``out (3, .)``."""
    grid, S = unpacked_grid(marker, whole, real, of_x, of_y, of_z), work.scratch
    ny, nz = grid.y.n, grid.z.n
    q, plane = U(t) * (U(len(S)) // U(work.workers)), ny * nz
    first, last = share(t, work.workers, grid.x.n)
    lines, width = extent(grid)
    for i in range(first, last):
        for j in range(U(0), ny, lines):
            for k0 in range(U(0), nz, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                divergence_across(work.P, U(0), U(1), grid, tile, S, q)
                if work.R.shape[1] > 0:
                    subtract_across(work.R, grid, tile, tile.at + plane + plane, S, q)
                for c in range(U(3)):
                    for k in range(tile.count):
                        out[c, tile.at + k] += S[q + c * U(STRIDE) + k]


@kernel
def law_alone(material, F, P):  # type: ignore[no-untyped-def]
    """``P (9, .)`` [Pa] of ``F (9, .)`` by the law, without filter and restraint."""
    for a in prange(F.shape[1]):
        A = (
            F[0, a], F[1, a], F[2, a], F[3, a], F[4, a], F[5, a], F[6, a], F[7, a], F[8, a],
        )  # fmt: skip
        p = law.first_piola(material, A, cofactor(A), determinant(A))
        P[0, a], P[1, a], P[2, a] = p[0], p[1], p[2]
        P[3, a], P[4, a], P[5, a] = p[3], p[4], p[5]
        P[6, a], P[7, a], P[8, a] = p[6], p[7], p[8]
