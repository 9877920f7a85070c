"""Parts that were meant to touch: so near each other that only round-off keeps them apart.

A file with six or seven digits rounds a coordinate by up to a millionth of the size of the body,
which is some 1e-4 of an edge where a hundred edges go across it.  A gap that is meant has to be
wider than :data:`NEAR` of the edges beside it: a narrower one is closed, or opened tenfold, by a
strain of that size in the first cells next to it.  So the gap is no shape that a mesh with such
edges can hold, and the parts are refused like parts that touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.geometry.inside import distance_to_triangle

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: What is nearer than this, over the shortest edges on both sides, was meant to touch.
NEAR = 1.0e-3


@dataclass(frozen=True)
class NearPairs:
    """Vertices ``pairs (p, 2)`` that no edge joins, and their largest distance ``gap`` [m]."""

    pairs: Indices
    gap: float


def near_vertices(vertices: Array, loops: Indices) -> NearPairs:
    """Pairs of vertices nearer than :data:`NEAR` of the shortest edge at either of them.

    ``loops (f, m)``: all facets of the cells, so that every edge is in one.  An edge is as long
    as the shortest edge at its ends, or longer, so its ends are no such pair.
    """
    after = np.roll(loops, -1, axis=1)
    length = np.linalg.norm(vertices[loops] - vertices[after], axis=2).ravel()
    shortest = np.full(len(vertices), np.inf)
    for ends in (loops, after):
        np.minimum.at(shortest, ends.ravel(), length)
    reach = NEAR * float(shortest.max(where=np.isfinite(shortest), initial=0.0))
    distance, other = cKDTree(vertices).query(vertices, k=2, distance_upper_bound=reach)
    one = np.flatnonzero(np.isfinite(distance[:, 1]))
    distance, two = distance[one, 1], other[one, 1]
    near = distance < NEAR * np.minimum(shortest[one], shortest[two])
    pairs = np.unique(np.sort(np.stack([one, two], axis=1)[near], axis=1), axis=0)
    return NearPairs(pairs.astype(np.int64), float(distance[near].max(initial=0.0)))


def shortest_sides(corner: Array) -> Array:
    """The shortest side ``(n,)`` [m] of triangles ``corner (n, 3, 3)``."""
    return np.asarray(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).min(axis=1))


def triangle_distance(one: Array, two: Array) -> Array:
    """Distances ``(n,)`` [m] of pairs of triangles ``(n, 3, 3)`` that do not pierce each other.

    That of a corner from the other triangle, or of two sides where both run on, whichever is
    least.
    """
    least = np.full(len(one), np.inf)
    for a, b in ((one, two), (two, one)):
        for k in range(3):
            least = np.minimum(least, distance_to_triangle(a[:, k], b))
    for k in range(3):
        for m in range(3):
            p, u = one[:, k], one[:, (k + 1) % 3] - one[:, k]
            q, v = two[:, m], two[:, (m + 1) % 3] - two[:, m]
            least = np.minimum(least, _across(p, u, q, v))
    return least


def _across(p: Array, u: Array, q: Array, v: Array) -> Array:
    """Distance of segments ``p + s u`` and ``q + t v`` where both go on; infinite elsewhere."""
    normal = np.cross(u, v)
    square = np.einsum("nd,nd->n", normal, normal)
    size = np.einsum("nd,nd->n", u, u) * np.einsum("nd,nd->n", v, v)
    crossing = square > 1.0e-12 * size
    square = np.where(crossing, square, 1.0)
    way = q - p
    s = np.einsum("nd,nd->n", np.cross(way, v), normal) / square
    t = np.einsum("nd,nd->n", np.cross(way, u), normal) / square
    crossing &= (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    apart = np.abs(np.einsum("nd,nd->n", way, normal)) / np.sqrt(square)
    return np.where(crossing, apart, np.inf)
