"""Hexahedra of 20 nodes on any mesh of hexahedra: its vertices, and the middles of its edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Ends of the edges on which nodes 9 to 20 lie, in the order of Abaqus and CalculiX.
EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
)


@dataclass(frozen=True)
class QuadraticHexahedra:
    """``nodes (n, 3)`` [m], the vertices of the mesh first; ``cells (C, 20)``.

    ``faces`` name -> ``(f, 8)``: four corners, counter-clockwise from outside, then the middle of
    the edge after each.
    """

    nodes: Array
    cells: Indices
    faces: dict[str, Indices]


def quadratic(mesh: HexMesh) -> QuadraticHexahedra:
    """The hexahedra of ``mesh``, with straight edges."""
    count = len(mesh.vertices)
    ends = np.sort(mesh.cells[:, EDGES].reshape(-1, 2), axis=1)
    # One number an edge, ascending: searched for below.
    numbers, first = np.unique(ends[:, 0] * count + ends[:, 1], return_index=True)

    def middles(pairs: Indices) -> Indices:
        low, high = pairs.min(axis=-1), pairs.max(axis=-1)
        return count + np.searchsorted(numbers, low * count + high)

    def loops(quads: Indices) -> Indices:
        around = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1)
        return np.concatenate([quads, middles(around)], axis=1)

    edges = ends[first]
    return QuadraticHexahedra(
        nodes=np.concatenate([mesh.vertices, mesh.vertices[edges].mean(axis=1)]),
        cells=np.concatenate([mesh.cells, middles(mesh.cells[:, EDGES])], axis=1),
        faces={name: loops(quads) for name, quads in mesh.faces.items()},
    )


def face_shapes(r: float, s: float) -> tuple[Array, Array]:
    """``N (8,)`` and ``dN (8, 2)`` of the quadrilateral of eight nodes at ``r, s`` in [-1, 1].

    Corners first, then the middles of its sides, in the order of :class:`QuadraticHexahedra`.
    """
    N, slope = np.empty(8), np.empty((8, 2))
    for k, (a, b) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        u, v = 1 + a * r, 1 + b * s
        N[k] = 0.25 * u * v * (a * r + b * s - 1)
        slope[k] = 0.25 * a * v * (2 * a * r + b * s), 0.25 * b * u * (a * r + 2 * b * s)
    for k, b in ((4, -1), (6, 1)):
        N[k] = 0.5 * (1 - r * r) * (1 + b * s)
        slope[k] = -r * (1 + b * s), 0.5 * b * (1 - r * r)
    for k, a in ((5, 1), (7, -1)):
        N[k] = 0.5 * (1 - s * s) * (1 + a * r)
        slope[k] = 0.5 * a * (1 - s * s), -s * (1 + a * r)
    return N, slope
