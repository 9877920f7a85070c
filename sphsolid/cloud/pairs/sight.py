"""Pairs whose straight line leaves the body are no pairs: what feels what is joined by material.

A support is a ball, and a ball reaches across slots, notches and the gaps between parts.  What is
decided here, for primary and secondary particles, is ``geometry.line_of_sight``'s rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.geometry.line_of_sight import leaving, near_hiding
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
        """The sight within the body that ``mesh`` fills."""
        return cls(Outline.of(mesh))

    @property
    def is_clear(self) -> bool:
        """True where nothing can hide anything: a convex body in one piece."""
        return len(self.outline.hiding) == 0

    def among(self, pairs: PairList) -> PairList:
        """The pairs of the particles with each other, without those that the body does not join.

        A symmetric list stays symmetric; that of a convex body is handed back as it is.
        """
        return _without(pairs, self.hidden(self.outline.mesh.vertices, pairs))

    def of(self, points: Array, pairs: PairList) -> PairList:
        """The same for rows at other ``points (R, 3)`` [m] of the body."""
        return _without(pairs, self.hidden(points, pairs))

    def hidden(self, points: Array, pairs: PairList) -> Mask:
        """Which pairs ``(P,)`` of ``points (R, 3)`` with particles leave the body on their way."""
        out = np.zeros(pairs.pairs, dtype=bool)
        particles = self.outline.mesh.vertices
        if self.is_clear or pairs.pairs == 0:
            return out
        row, column = pairs.row_of_pair, pairs.indices.astype(np.int64)
        reach = float(np.sqrt(np.max(np.sum((particles[column] - points[row]) ** 2, axis=1))))
        among = points is particles
        ends = near_hiding(self.outline, particles, reach)
        starts = ends if among else near_hiding(self.outline, points, reach)
        asked = np.flatnonzero(starts[row] & ends[column])
        if among:
            # One question for both directions, so that they have one answer.
            asked = asked[row[asked] != column[asked]]
            low = np.minimum(row[asked], column[asked])
            high = np.maximum(row[asked], column[asked])
            one, which = np.unique(low * len(particles) + high, return_inverse=True)
            both = np.stack([one // len(particles), one % len(particles)], axis=1)
            used, ends_of = np.unique(both, return_inverse=True)
            seats = self.outline.seats(used)
            out[asked] = leaving(self.outline, seats, ends_of.reshape(-1, 2))[which]
            return out
        rows, start = np.unique(row[asked], return_inverse=True)
        used, end = np.unique(column[asked], return_inverse=True)
        seats = np.concatenate([self._inside(points[rows]), self.outline.seats(used)])
        out[asked] = leaving(self.outline, seats, np.stack([start, len(rows) + end], axis=1))
        return out

    def nearest(self, points: Array, count: int) -> Indices:
        """The ``count`` particles ``(R, count)`` nearest to every point, of those that it sees.

        Where it sees fewer among three times as many, the nearest of them stand in for the rest.
        """
        tree = cKDTree(self.outline.mesh.vertices)
        count = min(count, tree.n)
        wide = count if self.is_clear else min(3 * count, tree.n)
        near = tree.query(points, k=wide)[1].reshape(len(points), wide)
        if self.is_clear or len(points) == 0:
            return near
        rows = PairList(
            wide * np.arange(len(points) + 1, dtype=np.int64), near.ravel().astype(np.uint32)
        )
        hidden = self.hidden(points, rows).reshape(near.shape)
        order = np.argsort(hidden, axis=1, kind="stable")[:, :count]
        seen = np.maximum(np.sum(~hidden, axis=1), 1)
        place = np.where(np.arange(count) < seen[:, None], order, order[:, :1])
        return np.asarray(np.take_along_axis(near, place, axis=1))

    def _inside(self, points: Array) -> Array:
        """The points, but in the nearest cell where one lies outside, as centroids may."""
        outside = np.flatnonzero(~self.outline.contains(points))
        if len(outside) == 0:
            return points
        moved = points.copy()
        moved[outside] = self._middles[cKDTree(self._middles).query(points[outside])[1]]
        return moved

    @cached_property
    def _middles(self) -> Array:
        mesh = self.outline.mesh
        return np.asarray(mesh.vertices[mesh.cells].mean(axis=1))


def _without(pairs: PairList, hidden: Mask) -> PairList:
    if not np.any(hidden):
        return pairs
    kept = np.flatnonzero(~hidden)
    count = np.bincount(pairs.row_of_pair[kept], minlength=pairs.rows)
    return PairList(
        np.concatenate([[0], np.cumsum(count)]).astype(np.int64), pairs.indices[kept]
    )
