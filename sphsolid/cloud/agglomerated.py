"""Secondary particles without hexahedra: tetrahedra joined, about one to a primary particle.

Delaunay tetrahedra with one circumsphere are parts of one cavity between the particles.  On a
lattice of cubes they make up its cubes, and the points are those of ``H1``.  In disorder the
centres part.  Cells that share a facet are then joined two by two, those first whose centres differ
least.  With their volumes ``V`` and centres ``C``, the pair goes first that has the smallest

    V_1 V_2 / (V_1 + V_2)  |C_1 - C_2|^2.

That is the growth of the sum of squares [Ward1963].  So slivers and small cells go into their
neighbours, and no cell becomes much larger than the others.

Regular meshes have many equal costs.  Costs that differ by round-off alone count as equal and the
numbers of the cells decide, so that the points are the same in every unit, place and mirror.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sphsolid.errors import InputError, require
from sphsolid.geometry.cell_shape import TETRAHEDRON
from sphsolid.geometry.delaunay import circumspheres
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import Mesh, TetMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Circumcentres closer than this, over the spacing, are one.
_SAME = 1.0e-6
#: How far from its centroid the centre of a cell counts as being, over its size.
_REACH = 0.5
#: Joined in one round: pairs of which each is the other's best, up to this multiple of the least
#: cost, or of the fifth power of the spacing.
_STEP, _CHEAP = 1.2, 1.0e-3
#: Costs are equal that differ by less than this part of them, or of the fifth power of the spacing.
_TIE, _NOTHING = 1.0e-7, 1.0e-12


@dataclass(frozen=True)
class Agglomerated:
    """``per_particle`` secondary particles for each primary one, from a mesh of tetrahedra.

    A primary particle is counted as the cube of the spacing: on a face half a one.
    """

    per_particle: float = 1.0

    @property
    def name(self) -> str:
        """``A1``; ``A2`` for two a particle."""
        return f"A{self.per_particle:g}"

    def place(self, mesh: Mesh) -> tuple[Array, Array]:
        """Positions ``X_q (M, 3)``, centroids of the joined cells, and volumes ``V_q (M,)``.

        ``sum V_q`` and ``sum V_q X_q`` are those of the mesh.  Raises ``InputError`` for a mesh
        of other cells.
        """
        if not isinstance(mesh, TetMesh):
            raise InputError(
                f"secondary = Agglomerated() needs tetrahedra and the body is meshed with cells of "
                f"type {mesh.shape.name}; use H1() or H6()"
            )
        require(
            0.1 <= self.per_particle <= 6.0,
            f"Agglomerated(per_particle={self.per_particle}) is outside [0.1, 6]",
        )
        # About the middle, so that sums of moments keep their digits wherever the body lies.
        middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
        mesh = replace(mesh, vertices=mesh.vertices - middle)
        volume, centroid = cell_volumes_and_centroids(mesh)
        group = clusters(mesh, self.per_particle)
        total: Array = np.bincount(group, weights=volume).astype(np.float64)
        moment = [np.bincount(group, weights=volume * x) for x in centroid.T]
        return middle + np.stack(moment, axis=1) / total[:, None], total


def clusters(mesh: TetMesh, per_particle: float) -> Indices:
    """The cluster ``(C,)`` of every cell, numbered in the order of their first cells."""
    # About the middle and in spacings: digits and tolerances are those of the shape alone.
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    mesh = replace(mesh, vertices=(mesh.vertices - middle) / mesh.spacing, spacing=1.0)
    volume, centroid = cell_volumes_and_centroids(mesh)
    centre, _ = circumspheres(mesh.vertices, mesh.cells)
    offset = centre - centroid
    # Slivers have their centre anywhere; half of the size of a cell away is where it counts.
    reach = _REACH * np.cbrt(6.0 * volume)
    length = np.linalg.norm(offset, axis=1)
    near = centroid + offset * np.minimum(1.0, reach / np.maximum(length, 1e-300))[:, None]
    group = _one_cavity(mesh.cells, centre)
    # A half is rounded the same way whatever its last digits.
    wanted = max(1, round(round(per_particle * float(volume.sum()), 6)))
    facets = cell_facets(mesh.cells, TETRAHEDRON)
    number = same_vertices(facets)
    order = np.argsort(number, kind="stable")
    shared = np.flatnonzero(np.diff(number[order]) == 0)
    links = np.stack([order[shared], order[shared + 1]], axis=1) // len(TETRAHEDRON.facets)
    return _joined(group, links, volume, near, wanted)


def _one_cavity(cells: Indices, centre: Array) -> Indices:
    """Cells whose circumcentres coincide and that have a vertex in common.

    The emptiness of the spheres makes them neighbours, but for those on both sides of a gap.
    """
    pairs = cKDTree(centre).query_pairs(_SAME, output_type="ndarray")
    i, j = pairs.T
    touch = np.any(cells[i][:, :, None] == cells[j][:, None, :], axis=(1, 2))
    pairs = pairs[touch]
    size = len(centre)
    _, group = connected_components(
        coo_array((np.ones(len(pairs)), pairs.T), shape=(size, size)), directed=False
    )
    return group.astype(np.int64)


def _joined(
    group: Indices, links: Indices, volume: Array, centre: Array, wanted: int
) -> Indices:
    """Merge ``group (C,)`` over ``links (n, 2)`` of cells until ``wanted`` clusters are left.

    In every round each cluster chooses its best neighbour, and pairs that chose each other are
    joined if that is about as cheap as any: nearly as one by one, and much faster.
    """
    V = np.bincount(group, weights=volume)
    M = np.stack([np.bincount(group, weights=volume * x) for x in centre.T], axis=1)
    links = group[links]
    while len(V) > wanted:
        links = np.sort(links[links[:, 0] != links[:, 1]], axis=1)
        _, first = np.unique(links[:, 0] * len(V) + links[:, 1], return_index=True)
        links = links[first]
        if len(links) == 0:
            break
        i, j = links.T
        apart = M[i] / V[i, None] - M[j] / V[j, None]
        cost = V[i] * V[j] / (V[i] + V[j]) * np.einsum("nd,nd->n", apart, apart)
        order = np.lexsort((j, i, _level(cost)))
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        best = np.full(len(V), len(order))
        np.minimum.at(best, i, rank)
        np.minimum.at(best, j, rank)
        mutual = np.flatnonzero((best[i] == rank) & (best[j] == rank))
        mutual = mutual[np.argsort(rank[mutual])]
        most = max(_STEP * cost[mutual[0]], _CHEAP) * (1.0 + 2.0 * _TIE)
        count = min(len(V) - wanted, int(np.count_nonzero(cost[mutual] <= most)))
        into = np.arange(len(V))
        into[j[mutual[:count]]] = i[mutual[:count]]
        _, number = np.unique(into, return_inverse=True)
        group, links = number[group], number[links]
        V = np.bincount(number, weights=V)
        M = np.stack([np.bincount(number, weights=x) for x in M.T], axis=1)
    return group


def _level(cost: Array) -> Indices:
    """Numbers ``(n,)`` in the order of the costs, equal where they differ by round-off alone."""
    order = np.argsort(cost, kind="stable")
    ascending = cost[order]
    step = np.diff(ascending) > _TIE * ascending[1:] + _NOTHING
    level = np.empty(len(cost), dtype=np.int64)
    level[order] = np.concatenate([[0], np.cumsum(step)])
    return level
