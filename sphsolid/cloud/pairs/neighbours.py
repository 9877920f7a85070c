"""Who lies in whose support: pair lists in compressed sparse rows, made once.

The search is total-Lagrangian: reference positions, so one search serves the whole run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
#: A support ends this share before its radius.  Pairs at its very edge, as many of a lattice are,
#: have weight zero: round-off, that of positions far from the origin too, must not let some in.
EDGE = 1.0e-6


@dataclass(frozen=True)
class PairList:
    """Row ``r`` sees the particles ``indices[indptr[r]:indptr[r + 1]]``, ascending.

    ``indptr (R + 1,) int64``; ``indices (P,) uint32``: unsigned, because numba then leaves out
    the test for negative indices in the inner loops.
    """

    indptr: NDArray[np.int64]
    indices: NDArray[np.uint32]

    @property
    def rows(self) -> int:
        """Number of evaluation points ``R``."""
        return len(self.indptr) - 1

    @property
    def pairs(self) -> int:
        """Number of pairs ``P``."""
        return len(self.indices)

    @property
    def row_of_pair(self) -> NDArray[np.int64]:
        """Row of every pair ``(P,)``."""
        return np.repeat(np.arange(self.rows), np.diff(self.indptr))

    @property
    def mean_neighbours(self) -> float:
        """Pairs per row, the point itself included."""
        return self.pairs / self.rows


def pairs_within(points: Array, particles: Array, radius: float) -> PairList:
    """Particles strictly nearer than ``radius`` [m] to each point, in ascending order."""
    reach = radius * (1.0 - EDGE)
    coo = cKDTree(points).sparse_distance_matrix(
        cKDTree(particles), reach, output_type="coo_matrix"
    )
    matrix = csr_array(
        (np.ones(len(coo.row), dtype=np.int8), (coo.row, coo.col)),
        shape=(len(points), len(particles)),
    )
    matrix.sort_indices()
    return PairList(matrix.indptr.astype(np.int64), matrix.indices.astype(np.uint32))


def pairs_of_lengths(
    points: Array, particles: Array, reach: Array, particle_reach: Array
) -> PairList:
    """Particles nearer than the mean of both radii ``(R,)`` and ``(N,)`` [m], ascending.

    Symmetric when points and particles are the same, whatever the radii are.
    """
    tree = cKDTree(particles)
    here = [np.asarray(near) for near in tree.query_ball_point(points, reach)]
    there = cKDTree(points).query_ball_point(particles, particle_reach)
    row = np.concatenate(
        [np.repeat(np.arange(len(points)), [len(n) for n in here]), *map(np.asarray, there)]
    ).astype(np.int64)
    column = np.concatenate(
        [*here, np.repeat(np.arange(len(particles)), [len(n) for n in there])]
    ).astype(np.int64)
    distance = np.linalg.norm(points[row] - particles[column], axis=1)
    radius = 0.5 * (reach[row] + particle_reach[column])
    near = distance < radius * (1.0 - EDGE)
    matrix = csr_array(
        (np.ones(int(near.sum()), dtype=np.int8), (row[near], column[near])),
        shape=(len(points), len(particles)),
    )
    matrix.sum_duplicates()
    return PairList(matrix.indptr.astype(np.int64), matrix.indices.astype(np.uint32))


def transposed(pairs: PairList, columns: int) -> tuple[PairList, NDArray[np.int64]]:
    """The same pairs listed by column, and for each of them its place in the row list."""
    place = csr_array(
        (np.arange(pairs.pairs), pairs.indices.astype(np.int64), pairs.indptr),
        shape=(pairs.rows, columns),
    ).tocsc()
    # The rows of each column come out ascending because the row list is traversed in order.
    return (
        PairList(place.indptr.astype(np.int64), place.indices.astype(np.uint32)),
        place.data.astype(np.int64),
    )
