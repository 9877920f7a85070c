"""The lines of a box lattice as arrays: what kernels need of the three differences."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.box import BoxLattice
from sphsolid.cloud.lattice.closures import central, difference, points_needed
from sphsolid.cloud.lattice.line_filter import filter_matrix
from sphsolid.errors import InputError

Array = NDArray[np.float64]


class Lines(NamedTuple):
    """Differences of order two along the lines of one axis of ``n`` points, ``dx`` [m] apart.

    Rows ``begin <= i < end`` are ``sum_m a_m (f_(i+m) - f_(i-m))`` [1/m], ``a = (one, two,
    three)``; the others are ``sum_m row[i, m] f_(first[i] + m)`` [1/m].  ``weight (n,)`` is the
    norm, so that ``dx weight`` are lengths of the line, and ``inverse (n,)`` its reciprocal.
    ``edge`` [1/m] is ``1 / (dx weight_0)``, what the boundary term of the adjoint takes.
    ``column`` is the direction of space along the axis: where its derivatives stand in ``F``.

    The restraint takes ``e_i = middle f_i + near (f_(i-1) + f_(i+1)) + far (f_(i-2) + f_(i+2))``,
    an eighth of the fourth difference with ``reach`` two, half of the second with ``reach`` one on
    a short axis: of a saw tooth both are twice as large as it is.

    ``smooth (n, 6)`` are the weights of a filter ``f_i + sum_m s_m (f_(i+m) - f_i)``, ``m = -3,
    -2, -1, 1, 2, 3``.
    """

    column: np.uint64
    n: np.uint64
    dx: float
    begin: np.uint64
    end: np.uint64
    one: float
    two: float
    three: float
    first: NDArray[np.uint64]
    row: Array
    weight: Array
    inverse: Array
    edge: float
    reach: np.uint64
    middle: float
    near: float
    far: float
    smooth: Array


class Lines4(Lines):
    """The same of order four: a type of its own, for which kernels are compiled."""


class Lines6(Lines):
    """The same of order six."""


#: Types of the lines by the order of their differences.
LINES_OF_ORDER: dict[int, type[Lines]] = {2: Lines, 4: Lines4, 6: Lines6}


class Grid(NamedTuple):
    """The three axes of a box lattice; particle ``(i, j, k)`` is number ``(i ny + j) nz + k``."""

    x: Lines
    y: Lines
    z: Lines


class Planes(NamedTuple):
    """What depends on the place in a plane of the two fast axes: a number for each particle of it.

    ``inverse (3, ny nz)`` are ones and the ``inverse`` of both axes; ``smooth_y``, ``smooth_z (6,
    ny nz)`` their filters, of the order ``smoothing``, which is zero without a filter.
    """

    smoothing: np.uint64
    inverse: Array
    smooth_y: Array
    smooth_z: Array


def lines(order: int, n: int, dx: float, *, column: int, smoothing: int) -> Lines:
    """The difference of ``order`` on ``n`` points, of a lower one where they are too few.

    The central coefficients are those of ``order`` whatever the rows are, so that all axes of a
    body have one kernel.  ``smoothing`` is the order of the filter, zero for none.
    """
    actual = order_of(order, n)
    h, D = difference(actual, n).arrays()
    long = n >= points_needed(actual) and actual == order
    begin = points_needed(order) // 2 if long else n
    end = n - begin if long else n
    outer = [i for i in range(n) if not begin <= i < end]
    spans = {i: (int(np.flatnonzero(D[i]).min()), int(np.flatnonzero(D[i]).max())) for i in outer}
    width = max(last - first + 1 for first, last in spans.values())
    # Kernels take the coefficients of a row two at a time.
    first, row = np.zeros(n, dtype=np.uint64), np.zeros((n, width + width % 2))
    for i, (least, _) in spans.items():
        start = min(least, n - width)
        first[i] = start
        row[i, :width] = D[i, start : start + width] / dx
    reach = 2 if n >= 5 else 1 if n >= 3 else 0
    a = [float(c) / dx for c in central(order)] + [0.0, 0.0]
    return LINES_OF_ORDER[order](
        column=np.uint64(column),
        n=np.uint64(n),
        dx=float(dx),
        begin=np.uint64(begin),
        end=np.uint64(end),
        one=a[0],
        two=a[1],
        three=a[2],
        first=first,
        row=row,
        weight=h,
        inverse=1.0 / h,
        edge=1.0 / (dx * h[0]),
        reach=np.uint64(reach),
        middle=(0.0, 1.0, 0.75)[reach],
        near=(0.0, -0.5, -0.5)[reach],
        far=(0.0, 0.0, 0.125)[reach],
        smooth=_neighbours(filter_matrix(h, smoothing)),
    )


def grid_of(order: int, box: BoxLattice, *, smoothing: int) -> Grid:
    """The lines of ``box`` along its three axes."""
    x, y, z = (
        lines(order, box.counts[d], float(box.dx[d]), column=d, smoothing=smoothing)
        for d in range(3)
    )
    return Grid(x, y, z)


def _neighbours(matrix: Array) -> Array:
    n = len(matrix)
    weights = np.zeros((n, 6))
    for column, m in enumerate((-3, -2, -1, 1, 2, 3)):
        inside = [i for i in range(n) if 0 <= i + m < n]
        weights[inside, column] = matrix[inside, [i + m for i in inside]]
    return weights


def planes(grid: Grid, smoothing: int) -> Planes:
    """The tables of the planes of a grid whose lines have this ``smoothing``."""
    ny, nz = int(grid.y.n), int(grid.z.n)
    ones = np.ones(ny * nz)
    return Planes(
        smoothing=np.uint64(smoothing),
        inverse=np.array([ones, np.repeat(grid.y.inverse, nz), np.tile(grid.z.inverse, ny)]),
        smooth_y=np.ascontiguousarray(np.repeat(grid.y.smooth, nz, axis=0).T),
        smooth_z=np.ascontiguousarray(np.tile(grid.z.smooth, (ny, 1)).T),
    )


def order_of(order: int, n: int) -> int:
    """The order that ``n`` points in a row allow: at most ``order``; raises ``InputError``."""
    for lower in range(order, 0, -2):
        if n >= max(2, lower):
            return lower
    raise InputError(f"{n} points in a row have no difference: a lattice needs two or more")


def norm(grid: Grid) -> Array:
    """Volumes of the particles ``(nx ny nz,)`` [m^3]: products of the norms."""
    x, y, z = (axis.dx * axis.weight for axis in grid)
    volume: Any = x[:, None, None] * y[:, None] * z
    return np.asarray(volume.ravel())
