"""Delaunay tetrahedra of a set of points, oriented, and the facets that bound a set of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import TETRAHEDRON
from sphsolid.geometry.facets import cell_facets, same_vertices

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def delaunay(points: Array) -> Indices:
    """Cells ``(C, 4)`` of positive orientation; flat ones (of volume zero or below) included.

    Raises ``InputError`` for points that span no volume.
    """
    try:
        cells = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    except (QhullError, ValueError) as error:
        raise InputError(
            f"{len(points)} points have no Delaunay tetrahedra: give at least four that do not "
            "lie in one plane, without NaN"
        ) from error
    inverted = tetrahedron_volumes(points, cells) < 0.0
    cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    return cells


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
