"""Voronoi volumes of the vertices of Delaunay tetrahedra, cell by cell.

The planes half-way along the edges of a cell cut it, and meet in its circumcentre.  Six simplices
make up the part of a corner.  Each goes from the corner over the middle of an edge and the centre
of a facet to that of the cell.  The part is the sum of their signed volumes.

The parts add up to the cell.  Around an inner vertex they add up to its Voronoi cell, the room that
is nearer to it than to any other.  That holds whatever way points on one sphere are cut into
tetrahedra.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.delaunay import circumspheres, tetrahedron_volumes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Least volume of a vertex, over a quarter of its cells', that Voronoi's is taken for.
_LEAST = 0.25


def dual_parts(points: Array, cells: Indices) -> Array:
    """Part ``(C, 4)`` [m^3] of every cell for its corners; some near the boundary are negative."""
    centre, _ = circumspheres(points, cells)
    parts = np.zeros(cells.shape)
    for order in itertools.permutations(range(4)):
        a, b, c = (points[cells[:, k]] for k in order[:3])
        u, v = b - a, c - a
        normal = np.cross(u, v)
        uu, vv, nn = (np.einsum("nd,nd->n", e, e)[:, None] for e in (u, v, normal))
        facet = (vv * np.cross(normal, u) + uu * np.cross(v, normal)) / (2.0 * nn)
        sense = round(np.linalg.det(np.eye(4)[list(order)]))
        triple = np.einsum("nd,nd->n", np.cross(0.5 * u, facet), centre - a)
        parts[:, order[0]] += sense * triple / 6.0
    return parts


def corner_parts(points: Array, cells: Indices) -> Array:
    """:func:`dual_parts`, or quarters of the cells around a vertex that would get too little.

    Too little is less than a quarter of what quarters give it: next to the boundary centres may
    lie outside the body.
    """
    quarters = np.repeat(tetrahedron_volumes(points, cells)[:, None] / 4.0, 4, axis=1)
    least = _LEAST * np.bincount(cells.ravel(), weights=quarters.ravel(), minlength=len(points))
    parts = dual_parts(points, cells)
    plain = np.zeros(len(cells), dtype=bool)
    while True:
        mixed = np.where(plain[:, None], quarters, parts)
        held = np.bincount(cells.ravel(), weights=mixed.ravel(), minlength=len(points))
        poor = np.any((held < least)[cells], axis=1) & ~plain
        if not np.any(poor):
            return mixed
        plain |= poor
