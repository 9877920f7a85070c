"""A sum over pairs, ``out_r = sum_b c_rb f_b``, stored so that regular particles cost little.

On the regular rows of a cloud who sees whom and with which coefficient repeats from particle to
particle.  There are three ways to store a row:

* a *stencil*: offsets and values stored once for all rows that agree in both; zeros left out;
* *own values*: the offsets repeat but the values do not, as near the boundary of a lattice where a
  consistent operator corrects them; values lie side by side for consecutive rows;
* an *exception*: compressed sparse rows (CSR), for all others.

Rows are worked on in *tiles* of ``LANES`` consecutive rows.  A *run* of a tile applies one set of
offsets to consecutive rows, exceptions among them included, in loops over consecutive particles;
then the exceptions are done again, each from its own pairs.  On a cloud that is not a lattice all
rows are exceptions and a tile is just a piece of the cloud.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.pairs.row_pattern import TOLERANCE, find_pattern, no_pattern, offsets_of
from sphsolid.cloud.pairs.tile_runs import TileRuns, run_counts, runs_of_tiles
from sphsolid.fields import LANES

Array = NDArray[np.float64]
Index = NDArray[np.uint64]

#: Stencils are padded to a multiple of this many terms; see ``scheme.tile``.
UNROLL = 4


class PairOperator(NamedTuple):
    """``C`` coefficients a pair, ``R`` rows; unsigned indices, so that no test for a sign is made.

    ``runs (T + 1,)`` says where the runs of a tile begin in the four arrays of runs.

    * ``stencil``: the stencil of the run;
    * ``base``: what is added to a row to get the particle that offsets count from, modulo 2^64;
    * ``lane``: the first lane;
    * ``lanes``: how many, a multiple of ``GRAIN``; too many are written over later.

    ``term (S + 1,)`` says where the terms of a stencil begin in ``offset`` and ``value (C, .)``.
    ``seen (S + 1,)`` says where the offsets of all whom a stencil sees begin in ``neighbour``,
    those with coefficient zero included.  Patterns of offsets from the number ``stencils`` on have
    own values: ``own`` says where those of a run begin in ``own_value (C, .)``, neighbour by
    neighbour, ``lanes`` each.  ``first (T + 1,)`` says where the exceptions of a tile begin in
    ``exception (E,)``.  Their pairs are ``indices[indptr[e]:indptr[e + 1]]`` with ``coefficient (C,
    pairs)``.  ``run_of_row (R,)`` is the run that serves a row, or the number of runs.
    """

    runs: Index
    stencil: Index
    base: Index
    lane: Index
    lanes: Index
    term: Index
    offset: Index
    value: Array
    first: Index
    exception: Index
    indptr: Index
    indices: NDArray[np.uint32]
    coefficient: Array
    seen: Index
    neighbour: Index
    run_of_row: NDArray[np.uint32]
    stencils: np.uint64
    own: Index
    own_value: Array

    @property
    def rows(self) -> int:
        """Number of rows ``R``."""
        return len(self.run_of_row)

    @property
    def mean_neighbours(self) -> float:
        """Pairs per row, those with coefficient zero included."""
        served = np.diff(self.seen.astype(np.int64))[self.stencil.astype(np.int64)]
        rows = np.bincount(self.run_of_row, minlength=len(served) + 1)[: len(served)]
        return float((len(self.indices) + np.sum(served * rows)) / self.rows)

    @property
    def stencil_share(self) -> float:
        """Share of the rows that a stencil serves."""
        return 1.0 - len(self.exception) / max(1, self.rows)


def pair_operators(
    pairs: PairList, coefficients: list[Array], columns: int, *, stencils: bool = True
) -> list[PairOperator]:
    """Operators on one pair list, for ``coefficients`` ``(P, C)`` each, with common tiles.

    ``columns`` is the number of particles that are read.  ``stencils=False`` stores every row as
    an exception: the oracle of the tests.
    """
    table = np.concatenate(coefficients, axis=1)
    pattern = find_pattern(pairs, table) if stencils else no_pattern(pairs)
    runs, run_of_row = runs_of_tiles(pairs, pattern, columns)
    exception = np.flatnonzero(run_of_row == len(runs.stencil))
    first = np.searchsorted(exception, LANES * np.arange(-(-pairs.rows // LANES) + 1))
    count = np.diff(pairs.indptr)
    chosen = np.repeat(run_of_row == len(runs.stencil), count)
    indptr = np.concatenate([[0], np.cumsum(count[exception])])
    offsets = [offsets_of(pairs, row) for row in pattern.prototypes]
    common: dict[str, Any] = {
        "seen": np.cumsum([0, *(len(o) for o in offsets)]).astype(np.uint64),
        "neighbour": np.concatenate([np.zeros(0, np.int64), *offsets]).astype(np.uint64),
        **runs._asdict(),
        "run_of_row": run_of_row,
        "stencils": np.uint64(pattern.stencils),
        "first": first.astype(np.uint64),
        "exception": exception.astype(np.uint64),
        "indptr": indptr.astype(np.uint64),
        "indices": np.ascontiguousarray(pairs.indices[chosen]),
    }
    return [
        PairOperator(
            **common,
            **_terms(pairs, values, pattern.prototypes[: pattern.stencils]),
            **_own_values(pairs, values, runs, run_of_row, pattern.stencils),
            coefficient=np.ascontiguousarray(values[chosen].T),
        )
        for values in coefficients
    ]


def _own_values(
    pairs: PairList,
    values: Array,
    runs: TileRuns,
    run_of_row: NDArray[np.uint32],
    stencils: int,
) -> dict[str, Any]:
    """``own`` and ``own_value``; lanes that the run does not serve keep zeros."""
    has_own = np.flatnonzero(runs.stencil >= stencils)
    tile_of_run = np.repeat(np.arange(len(runs.runs) - 1), run_counts(runs.runs))
    rows = np.flatnonzero(np.isin(run_of_row, has_own))
    run = run_of_row[rows].astype(np.int64)
    length = np.zeros(len(runs.stencil), dtype=np.int64)
    length[run] = np.diff(pairs.indptr)[rows]
    lanes = runs.lanes.astype(np.int64)
    own = np.concatenate([[0], np.cumsum(length * lanes)])
    table = np.zeros((values.shape[1], own[-1]))
    count = length[run]
    place = np.arange(np.sum(count)) - np.repeat(np.cumsum(count) - count, count)
    lane = rows - LANES * tile_of_run[run] - runs.lane[run].astype(np.int64)
    to = np.repeat(own[run] + lane, count) + place * np.repeat(lanes[run], count)
    table[:, to] = values[np.repeat(pairs.indptr[rows], count) + place].T
    return {"own": own[:-1].astype(np.uint64), "own_value": table}


def _terms(
    pairs: PairList, values: Array, prototypes: list[int]
) -> dict[str, Any]:
    """``term``, ``offset`` and ``value`` of the stencils of one operator."""
    term: list[int] = [0]
    offsets, entries = [np.zeros(0, np.int64)], [np.zeros((0, values.shape[1]))]
    for row in prototypes:
        own = slice(pairs.indptr[row], pairs.indptr[row + 1])
        offset = offsets_of(pairs, row)
        prototype = _antisymmetric(offset - (row - int(pairs.indices[own][0])), values[own])
        prototype = np.where(
            np.abs(prototype) > TOLERANCE * np.max(np.abs(prototype), axis=0), prototype, 0.0
        )
        kept = np.any(prototype != 0.0, axis=1)
        count = int(np.count_nonzero(kept))
        padding = -count % UNROLL
        offsets += [offset[kept], np.zeros(padding, np.int64)]
        entries += [prototype[kept], np.zeros((padding, values.shape[1]))]
        term.append(term[-1] + count + padding)
    return {
        "term": np.array(term, dtype=np.uint64),
        "offset": np.concatenate(offsets).astype(np.uint64),
        "value": np.ascontiguousarray(np.concatenate(entries).T),
    }


def _antisymmetric(offset: NDArray[np.int64], values: Array) -> Array:
    """Make ``c(-o) = -c(o)`` exact where it holds but for round-off.

    One rounded stencil serves all rows: what is left of it would add up over them, one way, and
    momentum drift with it.
    """
    mirror = np.searchsorted(offset, -offset)
    if np.any(mirror >= len(offset)) or np.any(offset[mirror] != -offset):
        return values
    half = 0.5 * (values - values[mirror])
    if np.max(np.abs(half - values)) > TOLERANCE * np.max(np.abs(values)):
        return values
    return half


def expanded(operator: PairOperator) -> tuple[PairList, Array]:
    """The pair list and coefficients ``(P, C)`` that an operator applies, row by row."""
    C = len(operator.coefficient)
    count = np.zeros(operator.rows, dtype=np.int64)
    exception = operator.exception.astype(np.int64)
    count[exception] = np.diff(operator.indptr.astype(np.int64))
    regular = operator.run_of_row < len(operator.stencil)
    run = operator.run_of_row[regular]
    stencil = np.full(operator.rows, -1)
    base = np.zeros(operator.rows, dtype=np.int64)
    stencil[regular] = operator.stencil[run].astype(np.int64)
    base[regular] = operator.base[run].astype(np.int64)
    seen = operator.seen.astype(np.int64)
    count[regular] = np.diff(seen)[stencil[regular]]
    indptr = np.concatenate([[0], np.cumsum(count)])
    indices = np.empty(indptr[-1], dtype=np.uint32)
    table = np.zeros((indptr[-1], C))
    own = np.repeat(~regular, count)
    indices[own] = operator.indices
    table[own] = operator.coefficient.T
    for s in range(len(seen) - 1):
        rows = np.flatnonzero(stencil == s)
        offset = operator.neighbour[seen[s] : seen[s + 1]].astype(np.int64)
        where = indptr[rows][:, None] + np.arange(len(offset))
        first = rows + base[rows]
        indices[where] = first[:, None] + offset
        if s >= operator.stencils:
            table[where] = operator.own_value.T[_own_places(operator, rows, len(offset))]
            continue
        values = np.zeros((len(offset), C))
        terms = slice(int(operator.term[s]), int(operator.term[s + 1]))
        place = np.searchsorted(offset, operator.offset[terms].astype(np.int64))
        np.add.at(values, place, operator.value[:, terms].T)
        table[where] = values
    return PairList(indptr.astype(np.int64), indices), table


def _own_places(
    operator: PairOperator, rows: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """Where the own values of ``rows`` stand ``(rows, count)``."""
    run = operator.run_of_row[rows].astype(np.int64)
    tile_of_run = np.repeat(
        np.arange(len(operator.runs) - 1), run_counts(operator.runs)
    )
    lane = rows - LANES * tile_of_run[run] - operator.lane[run].astype(np.int64)
    lanes = operator.lanes[run].astype(np.int64)
    first = operator.own[run].astype(np.int64) + lane
    return np.asarray(first[:, None] + np.arange(count) * lanes[:, None])
