"""The parts of a cloud: sets of particles that no chain of pairs joins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from sphsolid.cloud.pairs.neighbours import PairList


def parts_of(pairs: PairList) -> NDArray[np.int64]:
    """Number of the part of every particle ``(N,)``, from 0, in the order of first particles.

    ``pairs`` is a list of the particles among themselves.  Two particles are of one part when a
    chain of pairs leads from one to the other.  Every operator acts within parts only.  So what is
    undetermined in one of them (a constant, a rigid motion) is so in each by itself.
    """
    links = csr_array(
        (np.ones(pairs.pairs, dtype=np.int8), pairs.indices.astype(np.int64), pairs.indptr),
        shape=(pairs.rows, pairs.rows),
    )
    _, label = connected_components(links, directed=False)
    # Which number scipy gives to which part is not promised: count in the order of the particles.
    _, first = np.unique(label, return_index=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[label])
