"""Near pairs, the edges of the cells, in compact tiles of particles.

A tile holds every edge that touches one of its particles.  So whatever a pair does is found once in
a tile, for both ends, and added up there: nothing of a pair is kept.  An edge from tile to tile is
found in both, which is one in four or five on hexahedra.  Sums do not depend on where tiles end: a
pair is the same in both, and a particle adds its own in the order of their other ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.fields import components, vector_field
from sphsolid.geometry.compact_parts import compact_parts
from sphsolid.geometry.edges import Edges

Array = NDArray[np.float64]
#: Particles of a tile at most.  More have fewer edges across, until they leave the cache.
PARTICLES = 512
#: The number of tiles is a multiple of this, so that two threads or four have equal shares.
SHARES = 4


class NearPairs(NamedTuple):
    """Tile ``t`` has the *places* ``tile[t] .. tile[t + 1]`` and the rows ``row[t] .. row[t + 1]``.

    At a place is a ``particle (N,)``; a row is a pair of particles ``a < b`` of ``volume`` [m^3]
    and ``per_square`` [1/m^2], which is ``1 / |X|^2``, since a division takes as long as twenty
    products.  The pairs of place ``i`` are ``slot[begin[2 i] .. begin[2 i + 2]]``, rows of its tile
    counted from the first, by rising numbers of the other end: from ``begin[2 i + 1]`` on the
    particle is ``a``.

    ``X (3, .)`` [m] are the particles, ``V (N,)`` [m^3] their volumes.
    """

    tile: NDArray[np.uint64]
    particle: NDArray[np.uint32]
    row: NDArray[np.uint64]
    a: NDArray[np.uint32]
    b: NDArray[np.uint32]
    volume: Array
    per_square: Array
    begin: NDArray[np.uint32]
    slot: NDArray[np.uint32]
    X: Array
    V: Array

    @property
    def most_rows(self) -> int:
        """Of a tile."""
        return int(np.max(np.diff(self.row.astype(np.int64)), initial=0))


def near_pairs(edges: Edges, X: Array, V: Array) -> NearPairs:
    """The edges between particles at ``X (N, 3)``, in tiles."""
    n, shares = len(X), -(-len(X) // (SHARES * PARTICLES))
    parts = compact_parts(X, SHARES * shares)
    particle = np.concatenate(parts)
    tile = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    tile_of, place = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    tile_of[particle] = np.repeat(np.arange(len(parts)), np.diff(tile))
    place[particle] = np.arange(n)

    order = np.lexsort((edges.b, edges.a))
    a, b, volume = edges.a[order], edges.b[order], edges.volume[order]
    per_square = 1.0 / np.sum((X[b] - X[a]) ** 2, axis=1)
    size = max(len(a), 1)
    both = tile_of[a] * size + np.arange(len(a)), tile_of[b] * size + np.arange(len(a))
    rows = np.unique(np.concatenate(both))
    edge = rows % size
    row = np.searchsorted(rows, np.arange(len(parts) + 1) * size)

    # Ends at b first: there the other end has the smaller number.
    end, other = place[np.concatenate([b, a])], np.concatenate([a, b])
    is_a = np.repeat([0, 1], len(a))
    slot = np.searchsorted(rows, np.concatenate(both[::-1]))
    slot -= row[tile_of[particle[end]]]
    begin = np.concatenate([[0], np.cumsum(np.bincount(2 * end + is_a, minlength=2 * n))])
    places = vector_field(n)
    places[:] = X
    return NearPairs(
        tile.astype(np.uint64), particle.astype(np.uint32), row.astype(np.uint64),
        a[edge].astype(np.uint32), b[edge].astype(np.uint32), volume[edge], per_square[edge],
        begin.astype(np.uint32), slot[np.lexsort((other, end))].astype(np.uint32),
        components(places), V,
    )  # fmt: skip
