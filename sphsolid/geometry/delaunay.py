"""Delaunay tetrahedra of a set of points, oriented, and the facets that bound a set of them.

The points of a lattice lie on common spheres, and a sphere with more than four points has several
triangulations.  Round-off would choose, another one in every unit and place.  So every point has a
small weight ``w``, by its number alone.  The cells are those of the lower hull of
``(X, |X|^2 + w)``: the same ones in all units, places, mirrors and turns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import TETRAHEDRON
from sphsolid.geometry.facets import cell_facets, same_vertices

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Largest weight of a point, over the square of the mean distance between points: far above
#: round-off, far below what would change a cell that is no tie.
_WEIGHT = 1.0e-7
#: Upward part of a normal of the lower hull above which it is that of a side.
_UPRIGHT = 1.0e-12


def delaunay(points: Array) -> Indices:
    """Cells ``(C, 4)`` of positive orientation, in the order of their vertices' numbers.

    Flat ones, of volume zero or below, are included.  Raises ``InputError`` for points that span
    no volume.
    """
    try:
        cells = np.sort(_lower_hull(points), axis=1)
    except (QhullError, ValueError) as error:
        raise InputError(
            f"{len(points)} points have no Delaunay tetrahedra: give at least four that do not "
            "lie in one plane, without NaN"
        ) from error
    cells = cells[np.lexsort(cells.T[::-1])]
    inverted = tetrahedron_volumes(points, cells) < 0.0
    cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    return cells


def _lower_hull(points: Array) -> Indices:
    """Cells ``(C, 4)`` of the lower hull of the lifted and weighted points."""
    low, high = points.min(axis=0), points.max(axis=0)
    x = (points - 0.5 * (low + high)) / (np.max(high - low) or 1.0)
    weight = _WEIGHT * len(x) ** (-2.0 / 3.0) * np.random.default_rng(0).random(len(x))
    lifted = np.concatenate([x, (np.sum(x**2, axis=1) + weight)[:, None]], axis=1)
    # One point far above, so that four points have a hull too; its facets are not of the lower.
    top = np.array([[0.0, 0.0, 0.0, 4.0]])
    hull = ConvexHull(np.concatenate([lifted, top]))
    lower = (hull.equations[:, 3] < -_UPRIGHT) & np.all(hull.simplices < len(x), axis=1)
    return np.asarray(hull.simplices[lower], dtype=np.int64)


def tetrahedron_volumes(points: Array, cells: Indices) -> Array:
    """Signed volumes ``(C,)`` [m^3]."""
    a, b, c = (points[cells[:, k]] - points[cells[:, 0]] for k in (1, 2, 3))
    return np.asarray(np.einsum("cd,cd->c", np.cross(a, b), c) / 6.0)


def circumspheres(points: Array, cells: Indices) -> tuple[Array, Array]:
    """Centres ``(C, 3)`` and radii ``(C,)`` [m]; far away and large where a cell is flat."""
    origin = points[cells[:, 0]]
    a, b, c = (points[cells[:, k]] - origin for k in (1, 2, 3))
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    twice = 2.0 * np.einsum("cd,cd->c", a, bc)
    # A cell of volume zero has its centre at a point that is far away but finite.
    size = np.sqrt(np.max(np.einsum("kcd,kcd->kc", (a, b, c), (a, b, c)), axis=0))
    twice = np.where(np.abs(twice) < 1.0e-14 * size**3, 1.0e-14 * size**3, twice)
    square = [np.einsum("cd,cd->c", e, e)[:, None] for e in (a, b, c)]
    offset = (square[0] * bc + square[1] * ca + square[2] * ab) / twice[:, None]
    return origin + offset, np.linalg.norm(offset, axis=1)


def open_facets(cells: Indices) -> tuple[Indices, Indices]:
    """Facets ``(f, 3)`` that belong to one cell only, outward, and those cells ``(f,)``."""
    facets = cell_facets(cells, TETRAHEDRON)
    number = same_vertices(facets)
    single = np.flatnonzero(np.bincount(number)[number] == 1)
    return facets[single], single // len(TETRAHEDRON.facets)
