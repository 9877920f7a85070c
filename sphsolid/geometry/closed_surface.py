"""From loose triangles to the closed, outward surface of a body, or one clear error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from sphsolid.errors import InputError, require
from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.inside import ranges, winding_numbers
from sphsolid.geometry.near_contact import NEAR, shortest_sides, triangle_distance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
_TOUCH = 1.0e-9


def halves(loops: Indices) -> Indices:
    """Triangles ``(f, 3)``, or quadrilaterals ``(f, 4)`` cut along their first diagonal."""
    if loops.shape[1] == 3:
        return loops.astype(np.int64)
    return loops[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).astype(np.int64)


def joined(vertices: Array, triangles: Indices, tolerance: float) -> Indices:
    """Triangles on the first of each set of vertices closer than ``tolerance`` [m]."""
    pairs = cKDTree(vertices).query_pairs(tolerance, output_type="ndarray")
    count = len(vertices)
    link = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    _, group = connected_components(link, directed=False)
    first = np.full(count, count)
    np.minimum.at(first, group, np.arange(count))
    return np.asarray(first[group][triangles])


def check_triangles(vertices: Array, triangles: Indices) -> None:
    """Refuse what no surface may have: NaN, doubled vertices, triangles without area."""
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    require(
        len(bad) == 0,
        f"the surface has {len(bad)} vertices that are not finite, the first of them number "
        f"{bad[:1].tolist()}; repair the file",
    )
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    pairs = cKDTree(vertices).query_pairs(_TOUCH * size, output_type="ndarray")
    if len(pairs):
        a, b = pairs[0].tolist()
        raise InputError(
            f"the surface has {len(pairs)} pairs of vertices at the same place, for instance {a} "
            f"and {b} at X = {vertices[a].tolist()} m: merge them (save it as .stl, whose vertices "
            "are merged here, if the program cannot)"
        )
    corner = vertices[triangles]
    a, b, c = (corner[:, k] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max(np.sum((corner - np.roll(corner, 1, axis=1)) ** 2, axis=2), axis=1)
    flat = np.flatnonzero(area <= _TOUCH * longest)
    require(
        len(flat) == 0,
        f"{len(flat)} triangles of the surface have no area, for instance one near X = "
        f"{_where(corner[flat[:1]])} m; remove them or mesh the surface again",
    )


def oriented(vertices: Array, triangles: Indices) -> Indices:
    """The same triangles, all turned outward of the body (into the holes of a hollow one).

    Raises ``InputError`` where the surface is open, has more than two triangles at an edge or
    more than one sheet at a vertex, crosses itself, has two sheets that only round-off keeps apart
    (:mod:`~sphsolid.geometry.near_contact`), or has one side only.
    """
    count = len(triangles)
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    number = same_vertices(edges)
    uses = np.bincount(number)[number]
    once = np.flatnonzero(uses == 1)
    require(
        len(once) == 0,
        f"the surface is open: {len(once)} edges belong to one triangle only, for instance the one "
        f"at X = {_where(vertices[edges[once[:1]]])} m; close the hole, or merge vertices that "
        "should be one",
    )
    many = np.flatnonzero(uses > 2)
    require(
        len(many) == 0,
        f"the surface touches itself: more than two triangles meet in an edge, for instance at X = "
        f"{_where(vertices[edges[many[:1]]])} m; a body needs one sheet around it",
    )
    one, two = np.argsort(number, kind="stable").reshape(-1, 2).T
    # Neighbours that agree run through their edge in opposite directions.
    agree = edges[one, 0] != edges[two, 0]
    component, parity = _parity(count, one // 3, two // 3, agree)
    turned = np.where(parity[:, None], triangles[:, ::-1], triangles)
    _one_sheet_at_each_vertex(vertices, triangles, one, two)
    _no_crossing(vertices, triangles, component)
    return _outward(vertices, turned, component)


def _where(corners: Array) -> list[float]:
    if len(corners) == 0:
        return []
    return [float(f"{x:.6g}") for x in corners.reshape(-1, 3).mean(axis=0)]


def _parity(
    count: int, one: Indices, two: Indices, agree: NDArray[np.bool_]
) -> tuple[Indices, NDArray[np.bool_]]:
    """Component of every triangle, and which to turn so that neighbours agree."""
    both = (np.r_[one, two], np.r_[two, one])
    graph = coo_array((np.ones(2 * len(one)), both), shape=(count, count)).tocsr()
    _, component = connected_components(graph, directed=False)
    sense = dict(zip(zip(one.tolist(), two.tolist(), strict=True), agree.tolist(), strict=True))
    parity = [False] * count
    _, starts = np.unique(component, return_index=True)
    for start in starts.tolist():
        order, before = breadth_first_order(graph, start, directed=False)
        for triangle in order[1:].tolist():
            known = int(before[triangle])
            same = sense.get((known, triangle), sense.get((triangle, known)))
            parity[triangle] = parity[known] ^ (not same)
    turn = np.array(parity)
    require(
        bool(np.all((turn[one] == turn[two]) == agree)),
        "the surface has one side only (like a Moebius strip or a Klein bottle): it bounds no body",
    )
    return component, turn


def _one_sheet_at_each_vertex(
    vertices: Array, triangles: Indices, one: Indices, two: Indices
) -> None:
    """The triangles around a vertex must be one fan: corners linked over shared edges."""
    following = np.array([1, 2, 0])
    ends = []
    for edge in (one, two):
        first = edge
        second = edge // 3 * 3 + following[edge % 3]
        swap = triangles.ravel()[first] > triangles.ravel()[second]
        ends.append((np.where(swap, second, first), np.where(swap, first, second)))
    rows = np.r_[ends[0][0], ends[0][1]]
    columns = np.r_[ends[1][0], ends[1][1]]
    size = triangles.size
    _, fan = connected_components(
        coo_array((np.ones(len(rows)), (rows, columns)), shape=(size, size)), directed=False
    )
    _, corner = np.unique(fan, return_index=True)
    fans = np.bincount(triangles.ravel()[corner], minlength=len(vertices))
    touching = np.flatnonzero(fans > 1)
    require(
        len(touching) == 0,
        f"the surface touches itself in {len(touching)} vertices, for instance at X = "
        f"{vertices[touching[:1]].ravel().tolist()} m; a body needs one sheet around it",
    )


def _no_crossing(vertices: Array, triangles: Indices, component: Indices) -> None:
    """No edge may pierce a triangle, no vertex lie on one that it is not a corner of.

    Triangles of two components may not be so near that they were meant to touch, either.
    """
    tolerance = _TOUCH * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    corner = vertices[triangles]
    near = NEAR * shortest_sides(corner)
    alone = int(component.max()) == 0
    margin = (np.full(len(near), tolerance) if alone else np.maximum(tolerance, near))[:, None]
    low, high = corner.min(axis=1) - margin, corner.max(axis=1) + margin
    order = np.argsort(low[:, 0], kind="stable")
    reach = np.searchsorted(low[order, 0], high[order, 0], side="right")
    after = np.arange(1, len(order) + 1)
    step = max(1, 4_000_000 // max(1, int(np.max(reach - after, initial=1))))
    for begin in range(0, len(order), step):
        part = slice(begin, begin + step)
        owner, slot = ranges(after[part], np.maximum(reach - after, 0)[part])
        i, j = order[part][owner], order[slot]
        meet = np.all((low[i, 1:] <= high[j, 1:]) & (low[j, 1:] <= high[i, 1:]), axis=1)
        i, j = i[meet], j[meet]
        for edges_of, plane_of in ((i, j), (j, i)):
            for k in range(3):
                _refuse_piercing(vertices, triangles, edges_of, plane_of, k, tolerance)
        apart = component[i] != component[j]
        i, j = i[apart], j[apart]
        _refuse_near(corner[i], corner[j], np.minimum(near[i], near[j]))


def _refuse_near(one: Array, two: Array, near: Array) -> None:
    """Triangles ``(n, 3, 3)`` of two sheets must be further apart than ``near (n,)`` [m]."""
    distance = triangle_distance(one, two)
    bad = np.flatnonzero(distance < near)
    if len(bad):
        first = bad[0]
        raise InputError(
            f"the surface touches itself: two of its sheets lie within {distance[first]:.3g} m of "
            f"each other near X = {_where(one[first])} m, less than {NEAR:g} of the edges there: "
            "parts that touch there are not joined; unite them before meshing the surface, or "
            "move them apart"
        )


def _refuse_piercing(
    vertices: Array, triangles: Indices, edges_of: Indices, plane_of: Indices, k: int,
    tolerance: float,
) -> None:  # fmt: skip
    start, end = triangles[edges_of, k], triangles[edges_of, (k + 1) % 3]
    plane = triangles[plane_of]
    own = np.any(plane == start[:, None], axis=1)
    apart = ~own & ~np.any(plane == end[:, None], axis=1)
    a, b, c = (vertices[plane[:, m]] for m in range(3))
    p, q = vertices[start], vertices[end]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    over, under = (np.einsum("nd,nd->n", x - a, normal) for x in (p, q))
    sides = np.stack(
        [np.einsum("nd,nd->n", np.cross(u - p, v - p), q - p) for u, v in ((a, b), (b, c), (c, a))]
    )
    through = (np.all(sides > 0.0, axis=0) | np.all(sides < 0.0, axis=0)) & (over * under < 0.0)
    through &= np.minimum(np.abs(over), np.abs(under)) > tolerance
    within = np.abs(over) <= tolerance
    for u, v in ((a, b), (b, c), (c, a)):
        beside = np.einsum("nd,nd->n", np.cross(v - u, p - u), normal)
        within &= beside >= -tolerance * np.linalg.norm(v - u, axis=1)
    bad = np.flatnonzero((apart & through) | (~own & within))
    require(
        len(bad) == 0,
        f"the surface touches or crosses itself, for instance near X = {_where(p[bad[:1]])} m; a "
        "body needs one sheet around it",
    )


def _outward(vertices: Array, triangles: Indices, component: Indices) -> Indices:
    """Turn whole components: outward, or inward when they lie in an odd number of others."""
    parts = [np.flatnonzero(component == k) for k in range(int(component.max()) + 1)]
    triangles = triangles.copy()
    a, b, c = (vertices[triangles[:, k]] - vertices.mean(axis=0) for k in range(3))
    signed = np.einsum("nd,nd->n", a, np.cross(b, c))
    probes = np.stack([vertices[triangles[part[0], 0]] for part in parts])
    depth = np.zeros(len(parts), dtype=np.int64)
    for k, part in enumerate(parts):
        if len(parts) > 1:
            within = np.rint(np.abs(winding_numbers(probes, vertices, triangles[part]))) > 0
            within[k] = False
            depth += within
    for k, part in enumerate(parts):
        if (np.sum(signed[part]) > 0.0) != (depth[k] % 2 == 0):
            triangles[part] = triangles[part][:, ::-1]
    return triangles
