"""Which facets of a boundary a set of nodes stands for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Facets whose normals differ by less are parts of one smooth face.
SMOOTH = np.cos(np.radians(30.0))


class _Lists:
    """For each key from zero the values that come with it, found without a search of all."""

    def __init__(self, keys: Indices, values: Indices, count: int) -> None:
        order = np.argsort(keys, kind="stable")
        self._values = values[order]
        self._starts = np.searchsorted(keys[order], np.arange(count + 1))

    def of(self, keys: Indices) -> tuple[Indices, Indices]:
        """Positions in ``keys`` and values, one after the other."""
        low, high = self._starts[keys], self._starts[keys + 1]
        owner = np.repeat(np.arange(len(keys)), high - low)
        first = np.cumsum(high - low) - (high - low)
        return owner, self._values[np.arange(len(owner)) - first[owner] + low[owner]]


class NodeSetFaces:
    """Facets ``boundary (f, m)`` of a closed boundary, ready to be asked by nodes.

    Each question costs what its set is large, whatever the size of the body.
    """

    def __init__(self, vertices: Array, boundary: Indices) -> None:
        """Find the neighbours of every facet across its edges, and where they meet smoothly."""
        facets, count = boundary.shape
        self.boundary = boundary
        ends = np.stack([boundary, np.roll(boundary, -1, axis=1)], axis=-1).reshape(-1, 2)
        low, high = ends.min(axis=1), ends.max(axis=1)
        order = np.lexsort((high, low))
        same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
        pairs = np.stack([order[:-1][same], order[1:][same]], axis=1) // count
        corners = vertices[boundary]
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        a, b = pairs[np.sum(normal[pairs[:, 0]] * normal[pairs[:, 1]], axis=1) > SMOOTH].T
        self._smooth = _Lists(np.concatenate([a, b]), np.concatenate([b, a]), facets)
        of_facet = np.repeat(np.arange(facets), count)
        self._around = _Lists(boundary.ravel(), of_facet, len(vertices))

    def of(self, nodes: Indices) -> Indices:
        """Facets ``(k,)``, sorted, of the faces that the nodes ``(n,)``, each once, stand for.

        A facet is one of them when all its vertices are.  At an edge of the body a facet of the
        next face can have all its vertices on the edge (the end of a cylinder at its wall).  Such
        facets are left out.  They are pieces that go on smoothly outside the set, and whose
        vertices all belong to other faces of it.
        """
        corners = self.boundary.shape[1]
        touched, times = np.unique(self._around.of(nodes)[1], return_counts=True)
        whole = touched[times == corners]
        if len(whole) == 0:
            return whole
        one, neighbour = self._smooth.of(whole)
        other = np.minimum(np.searchsorted(whole, neighbour), len(whole) - 1)
        inner = whole[other] == neighbour
        link = coo_array(
            (np.ones(inner.sum()), (one[inner], other[inner])), shape=(len(whole), len(whole))
        )
        count, piece = connected_components(link, directed=False)
        goes_on = np.zeros(count, dtype=bool)
        goes_on[piece[one[~inner]]] = True
        # In how many pieces of the set a vertex is.
        _, vertex = np.unique(self.boundary[whole], return_inverse=True)
        owner = np.repeat(piece, corners)
        pair = np.unique(owner.astype(np.int64) * len(nodes) + vertex.ravel())
        shared = np.bincount(pair % len(nodes), minlength=len(nodes)) > 1
        alone = np.zeros(count, dtype=bool)
        alone[(pair // len(nodes))[~shared[pair % len(nodes)]]] = True
        return np.asarray(whole[~(goes_on & ~alone)[piece]])
