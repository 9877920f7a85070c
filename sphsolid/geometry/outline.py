"""The boundary of a body as triangles, and a place just inside the body for each of its vertices.

What lies behind a re-entrant part of a boundary, or across a gap between two parts, is found from
these (see ``line_of_sight``).  A body without either, convex and in one piece, hides nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.closed_surface import halves
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.inside import winding_numbers
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
#: How far a seat lies from its vertex, over the way to the middle of a cell.
_SHIFT = 1.0e-4
#: Height of a neighbour's corner over a facet, over its edge, that makes the edge re-entrant.
_REENTRANT = 1.0e-6
#: Uneven weights of the corners of a cell: a seat is in line with nothing.
_WEIGHTS = {
    4: np.array([1.0, 1.31, 0.83, 1.17]),
    8: np.array([1.0, 1.31, 0.83, 1.17, 0.71, 1.43, 0.93, 1.09]),
}
_OUTERMOST = 1.0e-12


@dataclass(frozen=True, eq=False)
class Outline:
    """The boundary of ``mesh``: ``triangles (T, 3)`` outward, quadrilaterals cut in two."""

    mesh: Mesh
    triangles: Indices

    @classmethod
    def of(cls, mesh: Mesh) -> Outline:
        """The outline of a mesh: its tagged facets, or those of its cells where they do not close.

        What is to be said about facets that lack, or are there twice, is not said here.
        """
        triangles = halves(mesh.boundary)
        if mesh.fits_outline and not _is_closed(triangles):
            facets = cell_facets(mesh.cells, mesh.shape)
            number = same_vertices(facets)
            triangles = halves(facets[np.bincount(number)[number] == 1])
        return cls(mesh, triangles)

    @cached_property
    def hiding(self) -> Indices:
        """Triangles that something of the body can lie behind; none where it is convex.

        Those in the planes of the box around the body are never in the way.
        """
        X = self.mesh.vertices
        low, high = X.min(axis=0), X.max(axis=0)
        corner = X[self.triangles]
        margin = _OUTERMOST * float(np.max(np.abs([low, high])))
        outermost = np.any(
            np.all(np.abs(corner - low) <= margin, axis=1)
            | np.all(np.abs(corner - high) <= margin, axis=1),
            axis=1,
        )
        found = np.flatnonzero(~outermost)
        if len(found) == 0 or self._is_convex():
            return np.zeros(0, dtype=np.int64)
        return found

    def _is_convex(self) -> bool:
        """One closed sheet without a re-entrant edge: then it is convex as a whole, too."""
        edges = self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        number = same_vertices(edges)
        if np.any(np.bincount(number) != 2):
            return False
        one, two = np.argsort(number, kind="stable").reshape(-1, 2).T
        a, b, c = (self.mesh.vertices[self.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        along = self.mesh.vertices[edges[one, 1]] - self.mesh.vertices[edges[one, 0]]
        length = np.linalg.norm(along, axis=1)
        # Corner k + 2 of a triangle is opposite its edge k.
        opposite = self.mesh.vertices[self.triangles[two // 3, (two % 3 + 2) % 3]]
        height = np.einsum("nd,nd->n", opposite - a[one // 3], normal[one // 3])
        # Two facets back to back enclose nothing, or are the sides of a slit without width.
        back = np.einsum("nd,nd->n", normal[one // 3], normal[two // 3]) < 0.0
        if np.any(height > np.where(back, -_REENTRANT, _REENTRANT) * length):
            return False
        return self._pieces(one // 3, two // 3) == 1

    def _pieces(self, one: Indices, two: Indices) -> int:
        count = len(self.triangles)
        link = coo_array((np.ones(len(one)), (one, two)), shape=(count, count))
        return int(connected_components(link, directed=False)[0])

    @cached_property
    def _largest_cell(self) -> Indices:
        """The cell ``(N,)`` of most volume at every vertex."""
        corner = self.mesh.vertices[self.mesh.cells]
        size = np.abs(np.linalg.det(_edges_of(corner)))
        # Cells of a lattice differ in the last digits only: they count as equal.
        order = np.argsort(np.rint(size / (1.0e-6 * size.max())), kind="stable")
        cell = np.zeros(len(self.mesh.vertices), dtype=np.int64)
        cell[self.mesh.cells[order].ravel()] = np.repeat(order, self.mesh.cells.shape[1])
        return cell

    def seats(self, vertices: Indices) -> Array:
        """A point ``(n, 3)`` [m] inside the body, next to each of some vertices.

        A vertex of the boundary lies neither inside nor outside, and segments between vertices
        of a grid run along its facets and through their edges.  Those between seats do not.
        """
        seats = self._toward(vertices, self._largest_cell[vertices])
        if self.mesh.fits_outline:
            return seats
        # Cells that follow the boundary only nearly may reach out of it, as across a narrow slot.
        for place in np.flatnonzero(~self.contains(seats)):
            vertex = vertices[place]
            around = np.flatnonzero(np.any(self.mesh.cells == vertex, axis=1))
            tried = self._toward(np.full(len(around), vertex), around)
            inside = np.flatnonzero(self.contains(tried))
            if len(inside):
                seats[place] = tried[inside[0]]
        return seats

    def _toward(self, vertices: Indices, cells: Indices) -> Array:
        X, corners = self.mesh.vertices, self.mesh.cells[cells]
        weights = _WEIGHTS[corners.shape[1]]
        middle = np.einsum("nkd,k->nd", X[corners], weights / weights.sum())
        return np.asarray(X[vertices] + _SHIFT * (middle - X[vertices]))

    def contains(self, points: Array) -> Mask:
        """Which points ``(n, 3)`` lie inside the boundary."""
        return np.asarray(self.windings(points) > 0.5)

    def windings(self, points: Array) -> Array:
        """How often the boundary goes round points ``(n, 3)``: once inside, twice in two parts."""
        return winding_numbers(points, self.mesh.vertices, self.triangles)


def _is_closed(triangles: Indices) -> bool:
    """Whether every edge is run through as often one way as the other."""
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    way = np.where(edges[:, 0] < edges[:, 1], 1.0, -1.0)
    return not np.any(np.bincount(same_vertices(edges), weights=way))


def _edges_of(corner: Array) -> Array:
    """Three edges ``(C, 3, 3)`` at the first corner of every cell."""
    if corner.shape[1] == 4:
        return corner[:, 1:] - corner[:, :1]
    axes = [int(np.flatnonzero((unit == CORNERS).all(axis=1))[0]) for unit in np.eye(3)]
    return corner[:, axes] - corner[:, :1]
