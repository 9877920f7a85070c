"""Facets of cells by their vertices: which belong to one cell only, and which are the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.cell_shape import CellShape

Indices = NDArray[np.int64]


def same_vertices(rows: Indices) -> Indices:
    """A number for each row ``(n,)``, equal where rows ``(n, m)`` hold the same vertices."""
    if len(rows) == 0:
        return np.zeros(0, dtype=np.int64)
    ordered = np.sort(rows, axis=1)
    size = int(ordered.max()) + 1
    # Two vertices to a key: half the columns to sort by.
    keys = [
        ordered[:, c] * size + ordered[:, c + 1] if c + 1 < rows.shape[1] else ordered[:, c]
        for c in range(0, rows.shape[1], 2)
    ]
    order = np.lexsort(keys[::-1])
    fresh = np.zeros(len(rows), dtype=bool)
    for key in keys:
        fresh[1:] |= np.diff(key[order]) != 0
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(fresh)
    return number


def cell_facets(cells: Indices, shape: CellShape) -> Indices:
    """All facets ``(C n, m)`` of cells ``(C, k)``, outward; those of a cell follow each other."""
    return np.asarray(cells[:, shape.facets].reshape(-1, shape.facets.shape[1]))


def turns(loops: Indices) -> tuple[NDArray[np.bool_], Indices]:
    """Sense of loops ``(n, m)`` and the vertex opposite the lowest one, to compare loops with.

    Two loops of the same vertices run in opposite senses exactly if the first differ, and visit
    them in the same order up to that sense exactly if the second agree.
    """
    count = loops.shape[1]
    start = np.argmin(loops, axis=1)
    turned = np.take_along_axis(loops, (start[:, None] + np.arange(count)) % count, axis=1)
    opposite = turned[:, 2] if count == 4 else np.zeros(len(loops), dtype=np.int64)
    return turned[:, 1] < turned[:, -1], opposite
