"""Which triangles are near a point: a search of balls around them, in blocks of bounded size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.geometry.outline import Outline

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Candidates that are worked on at a time, so that memory is bounded whatever the body.
MOST = 500_000


@dataclass(frozen=True)
class Balls:
    """Balls around triangles, searched by size: a few large ones would make every search wide."""

    centre: Array
    radius: Array
    members: tuple[Indices, ...]
    trees: tuple[cKDTree, ...]

    @classmethod
    def around(cls, outline: Outline, triangles: Indices) -> Balls:
        """Around the centroids of triangles of the outline."""
        corner = outline.mesh.vertices[outline.triangles[triangles]]
        centre = corner.mean(axis=1)
        radius = np.linalg.norm(corner - centre[:, None], axis=2).max(axis=1)
        size = np.floor(np.log2(radius)).astype(int)
        members = tuple(np.flatnonzero(size == k) for k in np.unique(size))
        return cls(centre, radius, members, tuple(cKDTree(centre[own]) for own in members))

    def count(self, points: Array, reach: Array) -> Indices:
        """How many balls are within ``reach (n,)`` of each point ``(n,)``."""
        total = np.zeros(len(points), dtype=np.int64)
        for own, tree in zip(self.members, self.trees, strict=True):
            within = (1.0 + 1.0e-9) * (reach + self.radius[own].max())
            total += tree.query_ball_point(points, within, return_length=True)
        return total

    def near(self, points: Array, reach: Array) -> tuple[Indices, Indices]:
        """``(point, ball)`` of all points within their ``reach (n,)`` of a ball."""
        found_points, found_balls = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        for own, tree in zip(self.members, self.trees, strict=True):
            within = (1.0 + 1.0e-9) * (reach + self.radius[own].max())
            near = tree.query_ball_point(points, within, return_sorted=True)
            count = np.array([len(found) for found in near], dtype=np.int64)
            if count.sum() == 0:
                continue
            found_points.append(np.repeat(np.arange(len(points)), count))
            found_balls.append(own[np.concatenate(near).astype(np.int64)])
        return np.concatenate(found_points), np.concatenate(found_balls)


def blocks(count: Indices) -> Iterator[slice]:
    """Consecutive items of no more than ``MOST`` in all, or single ones."""
    total = np.concatenate([[0], np.cumsum(count)])
    begin = 0
    while begin < len(count):
        end = int(np.searchsorted(total, total[begin] + MOST, side="right")) - 1
        end = max(begin + 1, end)
        yield slice(begin, end)
        begin = end
