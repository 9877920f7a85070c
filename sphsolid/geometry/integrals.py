"""Integrals over a mesh that give particles their volume and boundary area.

With the shape functions ``N_a`` of its cells (trilinear or linear),

    V_a = int N_a dV,    A_a N_a = int_boundary N_a n dA,    B_ab = int_boundary N_a N_b n dA,

and so ``sum V_a`` is the volume of the mesh.  ``sum A_a N_a = 0``, ``sum A_a N_a (x) X_a = V I``
and ``sum_b B_ab = A_a N_a`` hold to round-off, since the quadrature of ``cell_shape`` is exact for
all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh

Array = NDArray[np.float64]


def _from_first(corners: Array) -> Array:
    """Corners ``(e, k, 3)`` of cells or facets from the first: exact, wherever the body lies.

    Slopes of shape functions add up to zero; of coordinates much larger than a cell they would do
    so to the round-off of those coordinates only.
    """
    return corners - corners[:, :1]


def _jacobians(mesh: Mesh, slopes: Array) -> Array:
    corners = _from_first(mesh.vertices[mesh.cells])
    return np.linalg.det(np.einsum("ecd,ck->edk", corners, slopes))


def vertex_volumes(mesh: Mesh) -> Array:
    """``V_a (N,)`` [m^3]; raises ``InputError`` for an inverted or flat cell."""
    volume = np.zeros(len(mesh.vertices))
    filling = mesh.corner_filling.T
    for point in mesh.shape.cell_rule:
        jacobian = _jacobians(mesh, point.slopes)
        if np.any(jacobian <= 0.0):
            cell = int(np.argmin(jacobian))
            where = mesh.vertices[mesh.cells[cell]].mean(axis=0).tolist()
            raise InputError(
                f"cell {cell} of the background mesh is inverted or flat (Jacobian "
                f"{jacobian[cell]:.3g} m^3 near X = {where} m); "
                "reduce the jitter or repair the mesh"
            )
        for corner, N, filled in zip(mesh.cells.T, point.N, filling, strict=True):
            volume += np.bincount(
                corner, weights=point.weight * N * filled * jacobian, minlength=len(volume)
            )
    return volume


def cell_volumes_and_centroids(mesh: Mesh) -> tuple[Array, Array]:
    """Cell volumes ``(C,)`` [m^3] and true centroids ``int X dV / V (C, 3)`` [m]."""
    first = mesh.vertices[mesh.cells[:, 0]]
    corners = _from_first(mesh.vertices[mesh.cells])
    volume = np.zeros(len(corners))
    moment = np.zeros((len(corners), 3))
    for point in mesh.shape.cell_rule:
        share = point.weight * _jacobians(mesh, point.slopes)
        volume += share
        moment += share[:, None] * np.einsum("ecd,c->ed", corners, point.N)
    return mesh.filling * volume, first + moment / volume[:, None]


def _facet_area(corners: Array, slopes: Array) -> Array:
    """Area vectors per reference area ``(f, 3)`` at a point of facets ``(f, m, 3)``."""
    tangents = np.einsum("fcd,ck->fkd", _from_first(corners), slopes)
    return np.asarray(np.cross(tangents[:, 0], tangents[:, 1]))


def facet_area_vectors(mesh: Mesh, facets: NDArray[np.int64]) -> Array:
    """``int n dA (f, 3)`` [m^2] over each of the given boundary facets, outward."""
    corners = mesh.vertices[facets]
    area = np.zeros((len(facets), 3))
    for point in mesh.shape.facet_rule:
        area += point.weight * _facet_area(corners, point.slopes)
    return area


def area_vectors(mesh: Mesh, facets: NDArray[np.int64]) -> Array:
    """``A_a N_a (N, 3)`` [m^2] of the given boundary facets, outward; zero elsewhere."""
    corners = mesh.vertices[facets]
    area = np.zeros((len(mesh.vertices), 3))
    for point in mesh.shape.facet_rule:
        vector = point.weight * _facet_area(corners, point.slopes)
        for corner, N in zip(facets.T, point.N, strict=True):
            for d in range(3):
                area[:, d] += np.bincount(
                    corner, weights=N * vector[:, d], minlength=len(area)
                )
    return area


def boundary_mass(mesh: Mesh, facets: NDArray[np.int64]) -> tuple[csr_array, ...]:
    """``B_ab = int N_a N_b n dA`` [m^2] of the given facets: one symmetric ``(N, N)`` a component.

    All three have the same pattern: every pair of vertices that share a facet.
    """
    corners = mesh.vertices[facets]
    m, size = facets.shape[1], len(mesh.vertices)
    entries = np.zeros((3, len(facets), m, m))
    for point in mesh.shape.facet_rule:
        vector = point.weight * _facet_area(corners, point.slopes)
        entries += np.einsum("fd,i,j->dfij", vector, point.N, point.N)
    row = np.broadcast_to(facets[:, :, None], entries.shape[1:]).ravel()
    column = np.broadcast_to(facets[:, None, :], entries.shape[1:]).ravel()
    return tuple(
        csr_array((part.ravel(), (row, column)), shape=(size, size)) for part in entries
    )


def layers_from_boundary(mesh: Mesh) -> NDArray[np.int64]:
    """Number of cells between a vertex and the boundary ``(N,)``; 0 on the boundary."""
    unreached = np.iinfo(np.int64).max
    layer = np.full(len(mesh.vertices), unreached)
    layer[np.unique(mesh.boundary)] = 0
    depth = 0
    while np.any(layer == unreached):
        touched = np.any(layer[mesh.cells] == depth, axis=1)
        reached = np.unique(mesh.cells[touched])
        fresh = reached[layer[reached] == unreached]
        if len(fresh) == 0:
            break
        depth += 1
        layer[fresh] = depth
    return layer


def local_spacing(mesh: Mesh) -> Array:
    """Distance of neighbouring vertices around each vertex ``(N,)`` [m], for graded meshes.

    Mean over the cells that meet at a vertex, weighted by their volume, of the edge of the cube
    that a cell stands for: ``V^(1/3)`` of a hexahedron, ``(6 V)^(1/3)`` of a tetrahedron (a cube
    is cut into six).  On a lattice of cubes it is the spacing at every vertex; it scales with the
    mesh and changes from vertex to vertex no faster than the cells do.  How much of a cell the
    body fills does not matter.  Raises ``InputError`` for a vertex that no cell uses.
    """
    volume = sum(
        (point.weight * _jacobians(mesh, point.slopes) for point in mesh.shape.cell_rule),
        np.zeros(len(mesh.cells)),
    )
    # A simplex on the edges of a cube is a sixth of it, a hexahedron all of it.
    cube = np.cbrt(volume / sum(point.weight for point in mesh.shape.cell_rule))
    size, around = np.zeros((2, len(mesh.vertices)))
    for corner in mesh.cells.T:
        size += np.bincount(corner, weights=volume * cube, minlength=len(size))
        around += np.bincount(corner, weights=volume, minlength=len(size))
    if np.any(around <= 0.0):
        vertex = int(np.argmin(around))
        raise InputError(
            f"vertex {vertex} at X = {mesh.vertices[vertex].tolist()} m belongs to no cell, or to "
            "inverted ones: it has no spacing; leave it out, or repair the mesh"
        )
    return np.asarray(size / around)
