"""Symmetric matrices of splines on a grid, in blocks of one plane each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.splines.spline_space import WIDTH, Splines
from sphsolid.compiled import register_jitable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlaneMatrix:
    """A plane holds the splines of one index along the longest axis of the grid.

    ``blocks (planes, reach + 1, n, n)``: block ``[i, r]`` couples plane ``i`` with plane ``i - r``,
    and planes further apart than ``reach`` do not couple.  Of ``[i, 0]`` the lower half is kept.
    ``order (planes n,)`` is the spline at every row, ``row`` its inverse.
    """

    blocks: Array
    order: NDArray[np.int64]
    row: NDArray[np.int64]

    @property
    def diagonal(self) -> Array:
        """``(planes n,)``, in the order of the rows."""
        return np.asarray(np.diagonal(self.blocks[:, 0], axis1=1, axis2=2)).ravel()

    def dense(self) -> Array:
        """The whole matrix ``(size, size)``, splines in their own order."""
        planes, width, n, _ = self.blocks.shape
        lower = np.zeros((planes, n, planes, n))
        for i in range(planes):
            for r in range(min(i, width - 1) + 1):
                lower[i, :, i - r] = self.blocks[i, r]
        flat = np.tril(lower.reshape(planes * n, planes * n))
        whole = flat + np.tril(flat, -1).T
        return np.asarray(whole[np.ix_(self.row, self.row)])


def empty_plane_matrix(splines: Splines, apart: int) -> PlaneMatrix:
    """Zero, for functions of which those ``apart`` cells from each other along any axis couple."""
    shape = tuple(int(n) for n in splines.shape)
    axes = longest_first(splines)
    order = np.arange(splines.size).reshape(shape).transpose(axes).ravel()
    row = np.empty_like(order)
    row[order] = np.arange(splines.size)
    planes = shape[axes[0]]
    n = splines.size // planes
    reach = min(apart + WIDTH - 1, planes - 1)
    return PlaneMatrix(np.zeros((planes, reach + 1, n, n)), order, row)


def longest_first(splines: Splines) -> NDArray[np.int64]:
    """Axes of the grid by their number of splines; stable, so that a cube's keep their order."""
    return np.argsort(-splines.shape, kind="stable")


@register_jitable
def add_entry(blocks, first, second, value):  # type: ignore[no-untyped-def]
    """Add to the entry of two rows, in the lower half."""
    n = blocks.shape[2]
    high, low = max(first, second), min(first, second)
    plane, other = high // n, low // n
    blocks[plane, plane - other, high - plane * n, low - other * n] += value
