"""Rows that see alike: the same offsets to their neighbours, and the same coefficients or not.

On a lattice almost every particle has the neighbours of the one beside it, shifted.  What repeats
is found here once, for ``pair_operator`` to store and ``tile_runs`` to cut into loops.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList

Array = NDArray[np.float64]

#: Rows whose coefficients agree to this share of the largest are one stencil.
TOLERANCE = 1.0e-12
#: Offsets must serve at least this many rows.
LEAST_ROWS = 64


class RowPattern(NamedTuple):
    """Which rows ``(R,)`` see alike.

    ``stencil`` the pattern of a row, -1 for none; ``base`` what is added to a row to get the
    particle that its offsets count from; ``prototypes`` a row of each pattern.  The first
    ``stencils`` patterns agree in the coefficients too, the others in the offsets only.
    """

    stencil: NDArray[np.int64]
    base: NDArray[np.int64]
    prototypes: list[int]
    stencils: int


def no_pattern(pairs: PairList) -> RowPattern:
    """No two rows are alike."""
    return RowPattern(np.full(pairs.rows, -1), np.zeros(pairs.rows, dtype=np.int64), [], 0)


def find_pattern(pairs: PairList, table: Array) -> RowPattern:
    """Group rows with the same offsets from their first neighbour and the same coefficients.

    ``table`` ``(P, C)`` holds all coefficients of a pair.  What is left over is grouped by the
    offsets alone.
    """
    first = pairs.indices[pairs.indptr[:-1]].astype(np.int64)
    count = np.diff(pairs.indptr)
    offset = pairs.indices.astype(np.int64) - np.repeat(first, count)
    largest = np.max(np.abs(table), axis=0)
    # Rows that are probably equal: same offsets, same coefficients to nine digits.
    signature = _row_hash(pairs, [offset, *np.rint(table / (1.0e-9 * largest)).astype(np.int64).T])
    stencil = np.full(pairs.rows, -1)
    prototypes: list[int] = []
    _, example, sizes = np.unique(signature, return_index=True, return_counts=True)
    same_offsets = _row_hash(pairs, [offset])
    for row in example[(sizes >= LEAST_ROWS)][np.argsort(-sizes[sizes >= LEAST_ROWS])]:
        left = np.flatnonzero((same_offsets == same_offsets[row]) & (stencil < 0))
        own = slice(pairs.indptr[row], pairs.indptr[row + 1])
        where = pairs.indptr[left][:, None] + np.arange(count[row])
        same = np.all(offset[where] == offset[own], axis=1)
        for c in range(table.shape[1]):
            gap = np.abs(table[where, c] - table[own, c])
            same &= np.all(gap <= TOLERANCE * largest[c], axis=1)
        if np.count_nonzero(same) >= LEAST_ROWS:
            stencil[left[same]] = len(prototypes)
            prototypes.append(int(row))
    stencils = len(prototypes)
    rest = np.where(stencil < 0, same_offsets, 0)
    kinds, example, sizes = np.unique(rest, return_index=True, return_counts=True)
    for row in example[(sizes >= LEAST_ROWS) & (kinds != 0)]:
        left = np.flatnonzero((same_offsets == same_offsets[row]) & (stencil < 0))
        own = slice(pairs.indptr[row], pairs.indptr[row + 1])
        where = pairs.indptr[left][:, None] + np.arange(count[row])
        stencil[left[np.all(offset[where] == offset[own], axis=1)]] = len(prototypes)
        prototypes.append(int(row))
    return RowPattern(stencil, first - np.arange(pairs.rows), prototypes, stencils)


def _row_hash(pairs: PairList, columns: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """A number per row; equal rows of integers ``(P,)`` have equal numbers."""
    count = np.diff(pairs.indptr)
    place = np.arange(pairs.pairs) - np.repeat(pairs.indptr[:-1], count)
    mixed = place * 7_919 + 1
    for column in columns:
        mixed = (mixed ^ column) * 1_000_003_000_003
        mixed ^= mixed >> 29
    return np.asarray(np.add.reduceat(mixed, pairs.indptr[:-1]) + count)


def offsets_of(pairs: PairList, row: int) -> NDArray[np.int64]:
    """What is added to the first neighbour of ``row`` to get each of its neighbours."""
    seen = pairs.indices[pairs.indptr[row] : pairs.indptr[row + 1]].astype(np.int64)
    return seen - seen[0]
