"""Which straight lines between two points of a body leave it: slots, notches, gaps, cracks.

Two points *see* each other when a path inside the body joins them that is nowhere further than
``SLACK`` times their distance from the straight line between them.  So a chord over a shallow
hollow, the surface of a wide hole, counts as inside.  A chord over a slot does not, however narrow
the slot is, unless the slot ends within that distance.  Neither does one over a crack, whose two
sides lie at one place.

The path is never made.  Take the tube around the segment, and the pieces of the boundary within it
that hang together there.  A piece in which the segment crosses as often outward as inward has both
ends on the same side of it.  In a tube, which has no holes, two points that no single piece
separates are not separated by all of them together, so they are joined inside the body.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.inside import ranges
from sphsolid.geometry.outline import Outline
from sphsolid.geometry.triangle_balls import Balls, blocks

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
#: Radius of the tube around a segment in which a way round is looked for, over its length.
SLACK = 0.1
#: A segment counts as at least so many.
_LEAST = 25


def leaving(outline: Outline, points: Array, ends: Indices) -> Mask:
    """Which segments ``ends (P, 2)`` between ``points (n, 3)`` [m] inside the body leave it.

    The points must be inside (see ``Outline.seats``); the order of the two ends does not matter.
    """
    out = np.zeros(len(ends), dtype=bool)
    if len(outline.hiding) == 0 or len(ends) == 0:
        return out
    segment, triangle, sense = _crossings(outline, points, ends)
    crossed = np.unique(segment)
    balls = Balls.around(outline, np.arange(len(outline.triangles)))
    tube = _tubes(points[ends[crossed]])
    for block in blocks(np.maximum(_LEAST, balls.count(*tube))):
        chosen = crossed[block]
        first, last = np.searchsorted(segment, [chosen[0], chosen[-1] + 1])
        out[chosen] = _separated(
            outline,
            balls,
            points[ends[chosen]],
            np.searchsorted(chosen, segment[first:last]),
            triangle[first:last],
            sense[first:last],
        )
    return out


def near_hiding(outline: Outline, points: Array, reach: float) -> Mask:
    """Which points ``(n, 3)`` a segment of length ``reach`` [m] can start from and be hidden."""
    if len(outline.hiding) == 0:
        return np.zeros(len(points), dtype=bool)
    balls = Balls.around(outline, outline.hiding)
    distance, _ = cKDTree(balls.centre).query(
        points, distance_upper_bound=(1.0 + 1.0e-9) * (reach + float(balls.radius.max()))
    )
    return np.asarray(np.isfinite(distance))


def _crossings(
    outline: Outline, points: Array, ends: Indices
) -> tuple[Indices, Indices, Indices]:
    """``(segment, triangle, sense)`` of every crossing by segment; sense 1 outward, -1 inward."""
    X, hiding = outline.mesh.vertices, outline.hiding
    length = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    reach = np.zeros(len(points))
    for side in (0, 1):
        np.maximum.at(reach, ends[:, side], length)
    balls = Balls.around(outline, hiding)
    # Each crossing has one end above the triangle's plane: the segments of that end are tried.
    corner = X[outline.triangles[hiding]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    order = np.argsort(ends.ravel(), kind="stable")
    begin = np.searchsorted(ends.ravel()[order], np.arange(len(points) + 1))
    served = np.diff(begin)

    def above(of: Indices, triangles: Indices) -> Mask:
        offset = points[of] - corner[triangles, 0]
        return np.asarray(np.einsum("nd,nd->n", offset, normal[triangles]) > 0.0)

    def crossed(start: Indices, which: Indices) -> tuple[Indices, Indices, Indices]:
        """``(segment, its upper end, triangle)`` from the points ``start`` above triangles."""
        owner, slot = ranges(begin[start], served[start])
        segment, upper = order[slot] // 2, order[slot] % 2
        which = which[owner]
        under = ~above(ends[segment, 1 - upper], which)
        segment, upper, which = segment[under], upper[under], which[under]
        through = _through(X, outline.triangles[hiding[which]], points[ends[segment]])
        return segment[through], upper[through], which[through]

    nothing = np.zeros(0, dtype=np.int64)
    found = [(nothing, nothing, nothing)]
    held = np.flatnonzero(served > 0)
    for block in blocks(balls.count(points[held], reach[held])):
        here = held[block]
        start, which = balls.near(points[here], reach[here])
        start = here[start]
        over = above(start, which)
        start, which = start[over], which[over]
        found += [crossed(start[part], which[part]) for part in blocks(served[start])]
    segment, upper, which = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.lexsort((which, segment))
    return segment[order], hiding[which[order]], np.where(upper == 1, 1, -1)[order]


def _through(X: Array, triangles: Indices, ends: Array) -> Mask:
    """Whether the lines through ``ends (n, 2, 3)`` pass through their triangles ``(n, 3)``.

    Both triangles at an edge ask about it with the same numbers, so that a line through the edge
    passes through one of them.
    """
    p, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    sides = []
    for k in range(3):
        u, v = triangles[:, k], triangles[:, (k + 1) % 3]
        low, high = X[np.minimum(u, v)] - p, X[np.maximum(u, v)] - p
        side = np.einsum("nd,nd->n", np.cross(low, high), along) >= 0.0
        sides.append(side == (u < v))
    return np.asarray((sides[0] == sides[1]) & (sides[1] == sides[2]))


def _tubes(ends: Array) -> tuple[Array, Array]:
    """Middles ``(P, 3)`` of segments and radii ``(P,)`` [m] of balls around their tubes."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return ends.mean(axis=1), (0.5 + SLACK) * length


def _separated(
    outline: Outline,
    balls: Balls,
    ends: Array,
    segment: Indices,
    triangle: Indices,
    sense: Indices,
) -> Mask:
    """Which segments ``ends (P, 2, 3)`` a piece of the boundary in their tube parts from itself.

    The crossings of ``segment`` with ``triangle``, in the ``sense``.
    """
    X, count = outline.mesh.vertices, len(outline.triangles)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    tube = SLACK * length
    seg, tri = balls.near(*_tubes(ends))
    to = balls.centre[tri] - ends[seg, 0]
    share = np.einsum("nd,nd->n", to, along[seg]) / length[seg] ** 2
    off = np.linalg.norm(to - np.clip(share, 0.0, 1.0)[:, None] * along[seg], axis=1)
    near = off <= (1.0 + 1.0e-9) * (tube[seg] + balls.radius[tri])
    seg, tri = seg[near], tri[near]
    # Triangles hang together where a vertex or an edge that they share is within the tube.
    ties = [(seg * count + tri, seg * len(X) + outline.triangles[tri, k]) for k in range(3)]
    corner = X[outline.triangles[tri]]
    hit = [_apart(ends[seg], corner[:, [k, k]]) <= tube[seg] for k in range(3)]
    edges = outline.triangles[tri][:, [[0, 1], [1, 2], [2, 0]]]
    number = same_vertices(edges.reshape(-1, 2)).reshape(-1, 3)
    base = len(ends) * len(X)
    size = int(number.max(initial=0)) + 1
    for k in range(3):
        hit.append(_apart(ends[seg], corner[:, [k, (k + 1) % 3]]) <= tube[seg])
        ties.append((seg * count + tri, base + seg * size + number[:, k]))
    own = np.unique(np.concatenate([seg * count + tri, segment * count + triangle]))
    one = np.concatenate([tie[0][mask] for tie, mask in zip(ties, hit, strict=True)])
    two = np.concatenate([tie[1][mask] for tie, mask in zip(ties, hit, strict=True)])
    shared, two = np.unique(two, return_inverse=True)
    nodes = len(own) + len(shared)
    link = coo_array(
        (np.ones(len(one)), (np.searchsorted(own, one), len(own) + two)), shape=(nodes, nodes)
    )
    _, piece = connected_components(link, directed=False)
    of = piece[np.searchsorted(own, segment * count + triangle)]
    total = np.bincount(of, weights=sense, minlength=nodes)
    out = np.zeros(len(ends), dtype=bool)
    out[segment[total[of] != 0.0]] = True
    return out


def _apart(one: Array, two: Array) -> Array:
    """Distance ``(n,)`` [m] of segments ``(n, 2, 3)``; the second may be a point."""
    p, d = one[:, 0], one[:, 1] - one[:, 0]
    q, e = two[:, 0], two[:, 1] - two[:, 0]
    r = p - q
    dd, ee, de, dr, er = (
        np.einsum("nd,nd->n", u, v) for u, v in ((d, d), (e, e), (d, e), (d, r), (e, r))
    )
    ee = np.where(ee > 0.0, ee, 1.0)
    bottom = dd * ee - de * de
    flat = bottom <= 1.0e-14 * dd * ee
    s = np.where(flat, 0.0, np.clip((de * er - dr * ee) / np.where(flat, 1.0, bottom), 0.0, 1.0))
    t = np.clip((de * s + er) / ee, 0.0, 1.0)
    s = np.clip((de * t - dr) / dd, 0.0, 1.0)
    return np.asarray(np.linalg.norm(r + s[:, None] * d - t[:, None] * e, axis=1))
