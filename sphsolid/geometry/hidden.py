"""Which vertices of a mesh are hidden from each other, or from other points of the body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.geometry.line_of_sight import leaving, near_hiding
from sphsolid.geometry.outline import Outline

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]


def hidden_vertices(outline: Outline, one: Indices, two: Indices) -> Mask:
    """Whether the vertices ``one (P,)`` and ``two (P,)`` are hidden from each other; symmetric."""
    X = outline.mesh.vertices
    out = np.zeros(len(one), dtype=bool)
    asked = _asked(outline, X, one, two)
    asked = asked[one[asked] != two[asked]]
    if len(asked) == 0:
        return out
    # One question for both directions, so that they have one answer.
    low, high = np.minimum(one[asked], two[asked]), np.maximum(one[asked], two[asked])
    pair, which = np.unique(low * len(X) + high, return_inverse=True)
    used, ends = np.unique(np.stack([pair // len(X), pair % len(X)], 1), return_inverse=True)
    out[asked] = leaving(outline, outline.seats(used), ends.reshape(-1, 2))[which]
    return out


def hidden_from(outline: Outline, points: Array, row: Indices, vertex: Indices) -> Mask:
    """Whether the ``vertex (P,)`` is hidden from ``points[row]``, ``points (R, 3)`` [m].

    A point outside the body, as the centroid of cells around a corner may be, looks from the
    middle of the nearest cell.
    """
    out = np.zeros(len(row), dtype=bool)
    asked = _asked(outline, points, row, vertex)
    if len(asked) == 0:
        return out
    rows, start = np.unique(row[asked], return_inverse=True)
    used, end = np.unique(vertex[asked], return_inverse=True)
    seats = np.concatenate([_inside(outline, points[rows]), outline.seats(used)])
    out[asked] = leaving(outline, seats, np.stack([start, len(rows) + end], axis=1))
    return out


def hidden_points(outline: Outline, points: Array, one: Indices, two: Indices) -> Mask:
    """Whether ``points (R, 3)`` [m] inside the body, or vertices of it, are hidden from each other.

    ``one (P,)`` and ``two (P,)`` number them; where the points are the vertices themselves this is
    :func:`hidden_vertices`.
    """
    X = outline.mesh.vertices
    if np.array_equal(points, X):
        return hidden_vertices(outline, one, two)
    out = np.zeros(len(one), dtype=bool)
    if len(outline.hiding) and len(one):
        reach = float(np.sqrt(np.max(np.sum((points[two] - points[one]) ** 2, axis=1))))
        near = near_hiding(outline, points, reach)
        asked = np.flatnonzero(near[one] & near[two] & (one != two))
        seats = _inside(outline, points)
        out[asked] = leaving(outline, seats, np.stack([one[asked], two[asked]], axis=1))
    return out


def _asked(outline: Outline, points: Array, row: Indices, vertex: Indices) -> Indices:
    """The pairs near enough to the hiding part of the boundary."""
    X = outline.mesh.vertices
    if len(outline.hiding) == 0 or len(row) == 0:
        return np.zeros(0, dtype=np.int64)
    reach = float(np.sqrt(np.max(np.sum((X[vertex] - points[row]) ** 2, axis=1))))
    ends = near_hiding(outline, X, reach)
    starts = ends if points is X else near_hiding(outline, points, reach)
    return np.flatnonzero(starts[row] & ends[vertex])


def _inside(outline: Outline, points: Array) -> Array:
    outside = np.flatnonzero(~outline.contains(points))
    if len(outside) == 0:
        return points
    moved = points.copy()
    middles = outline.mesh.vertices[outline.mesh.cells].mean(axis=1)
    moved[outside] = middles[cKDTree(middles).query(points[outside])[1]]
    return moved
