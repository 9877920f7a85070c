"""Which rows of a tile one loop serves.

A *tile* is ``LANES`` consecutive rows.  A *run* applies one set of offsets to consecutive rows of a
tile; rows that no run serves are exceptions, also where they lie between rows that one serves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.pairs.row_pattern import RowPattern, offsets_of
from sphsolid.compiled import serial_kernel
from sphsolid.fields import GRAIN, LANES, leading

Index = NDArray[np.uint64]

#: A run must serve at least this many rows.
LEAST_RUN = 12


class TileRuns(NamedTuple):
    """Where the runs of tile ``t`` begin, ``runs (T + 1,)``, and what each one does.

    ``stencil`` its pattern, ``base`` as of the pattern, ``lane`` the first of its rows within the
    tile and ``lanes`` how many it works on, a multiple of ``GRAIN``.
    """

    runs: Index
    stencil: Index
    base: Index
    lane: Index
    lanes: Index


def runs_of_tiles(
    pairs: PairList, pattern: RowPattern, columns: int
) -> tuple[TileRuns, NDArray[np.uint32]]:
    """Runs of every tile, and the run that serves each row ``(R,)``, or the number of runs.

    ``columns`` is the number of particles that are read.  Pieces too short for a run are struck
    out of ``pattern.stencil``.
    """
    rows = len(pattern.stencil)
    tiles = -(-rows // LANES)
    reach = np.array([offsets_of(pairs, row)[-1] for row in pattern.prototypes], dtype=np.int64)
    table = np.empty((rows + 1, 4), dtype=np.int64)
    runs = np.zeros(tiles + 1, dtype=np.int64)
    run_of_row = np.empty(rows, dtype=np.uint32)
    count = _find_runs(
        pattern.stencil, pattern.base, reach, leading(columns), table, runs, run_of_row
    )
    stencil, base, lane, lanes = table[:count].T.astype(np.uint64)
    return TileRuns(runs.astype(np.uint64), stencil, base, lane, lanes), run_of_row


@serial_kernel
def _find_runs(  # type: ignore[no-untyped-def]
    stencil, base, reach, length, table, runs, run_of_row
):
    rows = len(stencil)
    count = 0
    unserved = np.uint32(rows)
    # Short pieces would only cut the runs on both sides of them.
    row = 0
    while row < rows:
        end = row + 1
        while end < rows and stencil[end] == stencil[row] and base[end] == base[row]:
            end += 1
        if end - row < LEAST_RUN:
            for other in range(row, end):
                stencil[other] = -1
        row = end
    for tile in range(len(runs) - 1):
        at = tile * LANES
        stop = min(at + LANES, rows)
        for row in range(at, stop):
            run_of_row[row] = unserved
        row = at
        while row < stop:
            if stencil[row] < 0:
                row += 1
                continue
            # Rows of no stencil may lie between; a row of another one ends the run.
            last = row
            served = 0
            for other in range(row, stop):
                if stencil[other] < 0:
                    continue
                if stencil[other] != stencil[row] or base[other] != base[row]:
                    break
                last = other
                served += 1
            lanes = (last - row + GRAIN) // GRAIN * GRAIN
            begin = row + base[row]
            # Every lane must read inside the field, those too many as well.
            inside = begin >= 0 and begin + lanes + reach[stencil[row]] <= length
            if served >= LEAST_RUN and inside:
                table[count, 0] = stencil[row]
                table[count, 1] = base[row]
                table[count, 2] = row - at
                table[count, 3] = lanes
                for other in range(row, last + 1):
                    if stencil[other] == stencil[row] and base[other] == base[row]:
                        run_of_row[other] = count
                count += 1
            row = last + 1
        runs[tile + 1] = count
    for row in range(rows):
        if run_of_row[row] == unserved:
            run_of_row[row] = count
    return count


def run_counts(runs: Index) -> NDArray[np.int64]:
    """Number of runs of every tile ``(T,)``."""
    return np.asarray(runs[1:] - runs[:-1], dtype=np.int64)
