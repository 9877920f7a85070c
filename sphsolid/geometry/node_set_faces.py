"""Which facets of a boundary a set of nodes stands for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Facets whose normals differ by less are parts of one smooth face.
SMOOTH = np.cos(np.radians(30.0))


class NodeSetFaces:
    """Facets ``boundary (f, m)`` of a closed boundary, ready to be asked by nodes."""

    def __init__(self, vertices: Array, boundary: Indices) -> None:
        """Find the neighbours of every facet across its edges, and where they meet smoothly."""
        count = boundary.shape[1]
        self.vertices = vertices
        self.boundary = boundary
        ends = np.stack([boundary, np.roll(boundary, -1, axis=1)], axis=-1).reshape(-1, 2)
        low, high = ends.min(axis=1), ends.max(axis=1)
        order = np.lexsort((high, low))
        same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
        pairs = np.stack([order[:-1][same], order[1:][same]], axis=1) // count
        corners = vertices[boundary]
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        self.smooth = pairs[np.sum(normal[pairs[:, 0]] * normal[pairs[:, 1]], axis=1) > SMOOTH]

    def of(self, member: Mask) -> Mask:
        """Facets ``(f,)`` of the faces that the nodes ``member (N,)`` were chosen on.

        A facet is one of them when all its vertices are.  At an edge of the body a facet of the
        next face can have all its vertices on the edge (the end of a cylinder at its wall); such
        facets are left out: pieces that go on smoothly outside the set, and whose vertices all
        belong to other faces of it.
        """
        whole = np.asarray(member[self.boundary].all(axis=1))
        a, b = self.smooth.T
        inner = whole[a] & whole[b]
        link = coo_array(
            (np.ones(inner.sum()), (a[inner], b[inner])), shape=(len(whole), len(whole))
        )
        count, piece = connected_components(link, directed=False)
        goes_on = np.zeros(count, dtype=bool)
        goes_on[piece[a[whole[a] & ~whole[b]]]] = True
        goes_on[piece[b[whole[b] & ~whole[a]]]] = True
        # In how many pieces of the set a vertex is.
        vertex = self.boundary[whole].ravel()
        owner = np.repeat(piece[whole], self.boundary.shape[1])
        pair = np.unique(owner * len(self.vertices) + vertex)
        shared = np.bincount(pair % len(self.vertices), minlength=len(self.vertices)) > 1
        alone = np.zeros(count, dtype=bool)
        alone[(pair // len(self.vertices))[~shared[pair % len(self.vertices)]]] = True
        return np.asarray(whole & ~(goes_on & ~alone)[piece])
