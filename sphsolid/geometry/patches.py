"""Where a boundary turns sharply: the smooth patches of its facets.

A vertex of one patch has one outward normal.  On a sharp edge a mean of the normals is the normal
of neither side, so what acts along a normal, or over an area, has to take the sides one by one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from sphsolid.geometry.integrals import facet_area_vectors
from sphsolid.geometry.mesh import Mesh

Indices = NDArray[np.int64]
#: Facets at one vertex whose normals differ by more belong to different sides [degrees].  Curved
#: boundaries of coarse meshes turn by up to half a right angle from facet to facet.
SHARP = 50.0


def smooth_patches(mesh: Mesh, facets: Indices) -> list[Indices]:
    """The facets ``(f, m)`` in groups, of which no vertex has facets that meet sharply.

    Facets that meet at a vertex and turn by less than :data:`SHARP` degrees are of one side; sides
    that share no vertex may be of one group.  A flat or smooth boundary is one group, itself.
    """
    side = _sides(mesh, facets)
    colour = _coloured(facets, side)
    return [facets[colour[side] == number] for number in range(int(colour.max(initial=0)) + 1)]


def _sides(mesh: Mesh, facets: Indices) -> Indices:
    """Number of the side ``(f,)`` that a facet belongs to."""
    area = facet_area_vectors(mesh, facets)
    normal = area / np.linalg.norm(area, axis=1, keepdims=True)
    first, other = _meeting(facets, len(mesh.vertices))
    smooth = np.einsum("pd,pd->p", normal[first], normal[other]) > math.cos(math.radians(SHARP))
    graph = coo_array(
        (np.ones(int(smooth.sum())), (first[smooth], other[smooth])), shape=(len(facets),) * 2
    )
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _meeting(facets: Indices, vertices: int) -> tuple[Indices, Indices]:
    """Pairs of facets that share a vertex."""
    rows = np.repeat(np.arange(len(facets)), facets.shape[1])
    at = csr_array((np.ones(facets.size), (rows, facets.ravel())), shape=(len(facets), vertices))
    pairs = coo_array(at @ at.T)
    return np.asarray(pairs.row, dtype=np.int64), np.asarray(pairs.col, dtype=np.int64)


def _coloured(facets: Indices, side: Indices) -> Indices:
    """A colour ``(s,)`` for each side, the smallest that no side at one of its vertices has."""
    corner, of = facets.ravel(), np.repeat(side, facets.shape[1])
    corner, of = np.unique(np.stack([corner, of]), axis=1)
    together: list[set[int]] = [set() for _ in range(int(side.max(initial=-1)) + 1)]
    _, starts = np.unique(corner, return_index=True)
    for sides in np.split(of, starts[1:]):
        for each in sides.tolist():
            together[each].update(sides.tolist())
    colour = np.full(max(len(together), 1), -1, dtype=np.int64)
    for each, others in enumerate(together):
        taken = {int(colour[other]) for other in others}
        colour[each] = next(n for n in range(len(together) + 1) if n not in taken)
    return np.maximum(colour, 0)
