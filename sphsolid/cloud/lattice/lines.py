"""The lines of a box lattice as arrays: what kernels need of the three differences."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.closures import central, difference, points_needed
from sphsolid.errors import InputError

Array = NDArray[np.float64]


class Lines(NamedTuple):
    """Differences of order two along the lines of one axis of ``n`` points, ``dx`` [m] apart.

    Rows ``begin <= i < end`` are ``sum_m a_m (f_(i+m) - f_(i-m))`` [1/m], ``a = (one, two,
    three)``; the others are ``sum_m row[i, m] f_(first[i] + m)`` [1/m].  ``weight (n,)`` is the
    norm, so that ``dx weight`` are lengths of the line.  ``edge`` [1/m] is ``1 / (dx weight_0)``,
    what the boundary term of the adjoint takes.  ``reach`` is half the width of the restraint's
    difference: two for the fourth, one for the second, none where there are too few points.
    """

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
    edge: float
    reach: np.uint64


class Lines4(Lines):
    """The same of order four: a type of its own, for which kernels are compiled."""


class Lines6(Lines):
    """The same of order six."""


_OF_ORDER: dict[int, type[Lines]] = {2: Lines, 4: Lines4, 6: Lines6}


class Grid(NamedTuple):
    """The three axes of a box lattice; particle ``(i, j, k)`` is number ``(i ny + j) nz + k``."""

    x: Lines
    y: Lines
    z: Lines


def lines(order: int, n: int, dx: float) -> Lines:
    """The difference of ``order`` on ``n`` points, of a lower one where they are too few.

    The central coefficients are those of ``order`` whatever the rows are, so that all axes of a
    body have one kernel.
    """
    actual = order_of(order, n)
    h, D = difference(actual, n).arrays()
    long = n >= points_needed(actual) and actual == order
    begin = points_needed(order) // 2 if long else n
    end = n - begin if long else n
    outer = [i for i in range(n) if not begin <= i < end]
    spans = {i: (int(np.flatnonzero(D[i]).min()), int(np.flatnonzero(D[i]).max())) for i in outer}
    width = max(last - first + 1 for first, last in spans.values())
    first, row = np.zeros(n, dtype=np.uint64), np.zeros((n, width))
    for i, (least, _) in spans.items():
        start = min(least, n - width)
        first[i] = start
        row[i] = D[i, start : start + width] / dx
    reach = 2 if n >= 5 else 1 if n >= 3 else 0
    a = [float(c) / dx for c in central(order)] + [0.0, 0.0]
    return _OF_ORDER[order](
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
        edge=1.0 / (dx * h[0]),
        reach=np.uint64(reach),
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
