"""The lines of a grid as few arguments of a kernel.

A call unpacks every number of every argument: fifty of them take as long as a hundred particles.
Here those of three axes are the rows of two arrays.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sphsolid.cloud.lattice.lines import LINES_OF_ORDER, Grid, Lines
from sphsolid.compiled import inlined, overload

_WHOLE = ("column", "n", "begin", "end", "reach")
_REAL = ("dx", "one", "two", "three", "edge", "middle", "near", "far")
_ARRAYS = ("first", "row", "weight", "inverse", "smooth")


def packed(grid: Grid) -> tuple[Any, ...]:
    """A marker of the type, whole numbers and reals ``(3, .)``, and the arrays of each axis.

    The marker is a tuple as long as the order of the differences.
    """
    (order,) = (order for order, kind in LINES_OF_ORDER.items() if type(grid.x) is kind)
    return (
        (0,) * order,
        np.array([[getattr(axis, name) for name in _WHOLE] for axis in grid], dtype=np.uint64),
        np.array([[getattr(axis, name) for name in _REAL] for axis in grid]),
        *(tuple(getattr(axis, name) for name in _ARRAYS) for axis in grid),
    )


def _unpacking(marker):  # type: ignore[no-untyped-def]
    """What unpacks lines of the type that a marker, or its type in a kernel, stands for."""
    kind = LINES_OF_ORDER[len(marker)]

    def made(marker, whole, real, arrays, axis):  # type: ignore[no-untyped-def]
        w, r = whole[axis], real[axis]
        first, row, weight, inverse, smooth = arrays
        return kind(
            w[0], w[1], r[0], w[2], w[3], r[1], r[2], r[3], first, row, weight, inverse, r[4],
            w[4], r[5], r[6], r[7], smooth,
        )  # fmt: skip

    return made


def unpacked(marker: Any, whole: Any, real: Any, arrays: Any, axis: Any) -> Lines:
    """The lines along ``axis`` again."""
    lines: Lines = _unpacking(marker)(marker, whole, real, arrays, axis)
    return lines


@overload(unpacked)
def _unpacked(marker, whole, real, arrays, axis):  # type: ignore[no-untyped-def]
    return _unpacking(marker)


@inlined
def unpacked_grid(marker, whole, real, of_x, of_y, of_z):  # type: ignore[no-untyped-def]
    """The grid again.

    Inside a parallel loop: numba hands named tuples to it only if it knows their class by a name.
    """
    return Grid(
        unpacked(marker, whole, real, of_x, 0),
        unpacked(marker, whole, real, of_y, 1),
        unpacked(marker, whole, real, of_z, 2),
    )
