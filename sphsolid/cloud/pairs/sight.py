"""Pairs whose straight line leaves the body are no pairs: what feels what is joined by material.

A support is a ball, and a ball reaches across slots, notches and the gaps between parts.  What is
decided here, for primary and secondary particles, is ``geometry.line_of_sight``'s rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.geometry.hidden import hidden_from, hidden_vertices
from sphsolid.geometry.mesh import Mesh
from sphsolid.geometry.outline import Outline

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Sight:
    """Who sees whom through the material of a body; ``outline`` is its boundary."""

    outline: Outline

    @classmethod
    def within(cls, mesh: Mesh) -> Sight:
        """The sight within the body that ``mesh`` fills; its vertices are the particles."""
        return cls(Outline.of(mesh))

    @property
    def is_clear(self) -> bool:
        """True where nothing can hide anything: a convex body in one piece."""
        return len(self.outline.hiding) == 0

    def seen(self, points: Array, pairs: PairList) -> PairList:
        """The pairs of ``points (R, 3)`` [m] with particles, without those that leave the body.

        The particles' own list (``points`` is their array) stays symmetric; that of a convex body
        is handed back as it is.
        """
        hidden = self.hidden(points, pairs)
        if not np.any(hidden):
            return pairs
        kept = np.flatnonzero(~hidden)
        count = np.bincount(pairs.row_of_pair[kept], minlength=pairs.rows)
        indptr = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        return PairList(indptr, pairs.indices[kept])

    def hidden(self, points: Array, pairs: PairList) -> Mask:
        """Which pairs ``(P,)`` of ``points (R, 3)`` with particles leave the body on their way."""
        if self.is_clear:
            return np.zeros(pairs.pairs, dtype=bool)
        row, column = pairs.row_of_pair, pairs.indices.astype(np.int64)
        if points is self.outline.mesh.vertices:
            return hidden_vertices(self.outline, row, column)
        return hidden_from(self.outline, points, row, column)

    def nearest(self, points: Array, count: int) -> Indices:
        """The ``count`` particles ``(R, count)`` nearest to every point, of those that it sees.

        Where it sees fewer among three times as many, the nearest of them stand in for the rest.
        """
        tree = cKDTree(self.outline.mesh.vertices)
        count = min(count, tree.n)
        wide = count if self.is_clear else min(3 * count, tree.n)
        near = tree.query(points, k=wide)[1].reshape(len(points), wide)
        if self.is_clear:
            return np.asarray(near)
        rows = wide * np.arange(len(points) + 1, dtype=np.int64)
        hidden = self.hidden(points, PairList(rows, near.ravel().astype(np.uint32)))
        hidden = hidden.reshape(near.shape)
        order = np.argsort(hidden, axis=1, kind="stable")[:, :count]
        seen = np.maximum(np.sum(~hidden, axis=1), 1)
        place = np.where(np.arange(count) < seen[:, None], order, order[:, :1])
        return np.asarray(np.take_along_axis(near, place, axis=1))
