"""Which points lie inside a closed surface, and how far from it: exact, and fast for many points.

The winding number of a point is the number of times the surface passes over it.  It is a sum over
the triangles that a ray from the point crosses: +1 where the ray leaves and -1 where it enters.
All rays are parallel, in a direction that no mesh is aligned with, and the triangles are sorted
into columns along it.  Where a ray passes too close to an edge to tell, or starts too close to a
triangle, the solid angle of the whole surface, over 4 pi, decides [Oosterom1983].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: How near to an edge a ray may pass, over the size of the body.
_TOLERANCE = 1.0e-9
#: Height over a triangle, over the distances to its corners, that counts as none.
_FLAT = 1.0e-12
_BLOCK = 2_000_000
#: A rotation whose rows are in no simple ratio.
_TURN, _ = np.linalg.qr(
    np.array([[0.8017, 0.2345, 0.5477], [-0.4111, 0.8623, 0.3129], [0.1733, -0.5381, 0.7919]])
)
_SAMPLED_TRIANGLES = 4


def ranges(start: Indices, count: Indices) -> tuple[Indices, Indices]:
    """``(owner, value)`` of all ``start_k + 0 .. count_k - 1``, one after the other."""
    owner = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(count) - count
    return owner, np.arange(len(owner)) - first[owner] + start[owner]


def winding_numbers(points: Array, vertices: Array, triangles: Indices) -> Array:
    """Winding numbers ``(n,)`` of a closed surface: 1 inside, 0 outside, a fraction on it."""
    corner = (vertices @ _TURN.T)[triangles]
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    low = corner.min(axis=(0, 1))[:2]
    counts = int(np.clip(np.sqrt(len(triangles)), 1, 1000))
    width = np.ptp(corner[:, :, :2], axis=(0, 1)) / counts
    first = np.clip((corner.min(axis=1)[:, :2] - low) / width, 0, counts - 1).astype(np.int64)
    last = np.clip((corner.max(axis=1)[:, :2] - low) / width, 0, counts - 1).astype(np.int64)
    span = last - first + 1
    triangle, place = ranges(np.zeros(len(span), dtype=np.int64), span[:, 0] * span[:, 1])
    column = (first[triangle, 0] + place // span[triangle, 1]) * counts
    column += first[triangle, 1] + place % span[triangle, 1]
    triangle = triangle[np.argsort(column, kind="stable")]
    held = np.bincount(column, minlength=counts**2)
    begin = np.cumsum(held) - held

    seen = points @ _TURN.T
    at = np.floor((seen[:, :2] - low) / width).astype(np.int64)
    # A point on the last border belongs to the last column.
    within = np.all((at >= -1) & (at <= counts), axis=1)
    index = np.clip(at, 0, counts - 1)
    index = index[:, 0] * counts + index[:, 1]
    number = np.where(within, held[index], 0)
    winding = np.zeros(len(points))
    blocks = np.searchsorted(np.cumsum(number), np.arange(_BLOCK, number.sum() + _BLOCK, _BLOCK))
    for low_end, high_end in zip(np.r_[0, blocks], np.r_[blocks, len(points)], strict=True):
        part = slice(int(low_end), int(high_end))
        owner, slot = ranges(begin[index[part]], number[part])
        crossed, unclear = _crossings(seen[part][owner], corner[triangle[slot]], size)
        winding[part] = np.bincount(owner, weights=crossed, minlength=len(winding[part]))
        doubtful = int(low_end) + np.unique(owner[unclear])
        winding[doubtful] = solid_angles(points[doubtful], vertices, triangles)
    return winding


def _crossings(
    point: Array, corner: Array, size: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """How the ray from each point along +Z crosses its triangle, and where that is unclear."""
    a, b, c = (corner[:, k] - point for k in range(3))
    side = np.stack([u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] for u, v in ((b, c), (c, a), (a, b))])
    length = np.stack([np.hypot(*(v - u)[:, :2].T) for u, v in ((b, c), (c, a), (a, b))])
    near = np.abs(side) <= _TOLERANCE * size * length
    inside = np.all(side > 0.0, axis=0) | np.all(side < 0.0, axis=0)
    total = side.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (side[0] * a[:, 2] + side[1] * b[:, 2] + side[2] * c[:, 2]) / total
    positive = np.all((side > 0.0) | near, axis=0)
    negative = np.all((side < 0.0) | near, axis=0)
    unclear = np.any(near, axis=0) & (positive | negative) & (
        np.max(corner[:, :, 2], axis=1) >= point[:, 2] - _TOLERANCE * size
    )
    unclear |= inside & (np.abs(height) <= _TOLERANCE * size)
    return np.where(inside & (height > 0.0), np.sign(total), 0.0).astype(np.int64), unclear


def solid_angles(points: Array, vertices: Array, triangles: Indices) -> Array:
    """Solid angle of the surface seen from each point ``(n,)``, over 4 pi [Oosterom1983]."""
    result = np.empty(len(points))
    step = max(1, _BLOCK // max(1, 8 * len(triangles)))
    for begin in range(0, len(points), step):
        part = points[begin : begin + step]
        a, b, c = (vertices[triangles[:, k]] - part[:, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(e, axis=2) for e in (a, b, c))
        top = np.einsum("ptd,ptd->pt", a, np.cross(b, c))
        bottom = la * lb * lc + (
            np.einsum("ptd,ptd->pt", a, b) * lc
            + np.einsum("ptd,ptd->pt", b, c) * la
            + np.einsum("ptd,ptd->pt", c, a) * lb
        )
        # Seen from within its plane, or from itself, a triangle covers nothing.
        top[np.abs(top) <= _FLAT * la * lb * lc] = 0.0
        angle = np.where(top == 0.0, 0.0, np.arctan2(top, bottom))
        result[begin : begin + step] = angle.sum(axis=1) / (2.0 * np.pi)
    return result


@dataclass(frozen=True)
class Distance:
    """``length (n,)`` [m] from each point to its nearest triangle ``triangle (n,)``."""

    length: Array
    triangle: Indices


def distance_to_surface(
    points: Array,
    vertices: Array,
    triangles: Indices,
    *,
    resolution: float,
    reach: float = np.inf,
) -> Distance:
    """Distance to a surface; off by less than ``resolution`` where triangles meet, else exact.

    The triangles of the samples nearest to a point are tried; samples lie ``resolution`` [m] apart
    or less, as long as no edge takes more than 64.  Further away than ``reach`` [m] it may be
    infinite, which saves time.
    """
    corner = vertices[triangles]
    longest = np.max(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2), axis=1)
    pieces = np.clip(np.ceil(longest / resolution), 1, 64).astype(int)
    samples, owners = [], []
    for m in np.unique(pieces).tolist():
        i, j = np.nonzero(np.add.outer(np.arange(m + 1), np.arange(m + 1)) <= m)
        share = np.stack([m - i - j, i, j]) / m
        members = np.flatnonzero(pieces == m)
        samples.append(np.einsum("tkd,ks->tsd", corner[members], share).reshape(-1, 3))
        owners.append(np.repeat(members, len(i)))
    owner = np.concatenate(owners)
    count = min(_SAMPLED_TRIANGLES, len(owner))
    tree = cKDTree(np.concatenate(samples))
    _, near = tree.query(points, k=count, distance_upper_bound=reach + resolution)
    near = near.reshape(len(points), count)
    beyond = near == len(owner)
    candidate = owner[np.where(beyond, 0, near)]
    length = np.stack(
        [distance_to_triangle(points, corner[candidate[:, k]]) for k in range(count)], axis=1
    )
    length[beyond] = np.inf
    best = np.argmin(length, axis=1)[:, None]
    return Distance(
        np.take_along_axis(length, best, axis=1)[:, 0],
        np.take_along_axis(candidate, best, axis=1)[:, 0],
    )


def distance_to_triangle(point: Array, corner: Array) -> Array:
    """Distance ``(n,)`` from each point to its own triangle ``(n, 3, 3)``."""
    a, b, c = (corner[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.einsum("nd,nd->n", point - a, normal)
    over = np.ones(len(point), dtype=bool)
    least = np.full(len(point), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        edge, d = v - u, point - u
        over &= np.einsum("nd,nd->n", np.cross(edge, d), normal) >= 0.0
        share = np.einsum("nd,nd->n", d, edge) / np.einsum("nd,nd->n", edge, edge)
        foot = np.clip(share, 0.0, 1.0)[:, None] * edge
        least = np.minimum(least, np.linalg.norm(d - foot, axis=1))
    return np.where(over, np.abs(height), least)
