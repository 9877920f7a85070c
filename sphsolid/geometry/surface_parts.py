"""The separate bodies that one closed surface encloses, each with the holes inside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sphsolid.geometry.inside import winding_numbers
from sphsolid.geometry.surface import Surface

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class SurfacePart:
    """The ``surface`` of one body, and the numbers ``vertices (n,)`` that its own have in all."""

    surface: Surface
    vertices: Indices


def surface_parts(surface: Surface) -> list[SurfacePart]:
    """The parts of a surface in the order of their first vertices; itself where it has one.

    Sheets of triangles that enclose a positive volume are bodies, the others holes of the
    smallest body around them.
    """
    triangles, count = surface.triangles, len(surface.vertices)
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    link = coo_array((np.ones(len(sides)), sides.T), shape=(count, count))
    sheets, sheet = connected_components(link, directed=False)
    if sheets == 1:
        return [SurfacePart(surface, np.arange(count))]
    _, first = np.unique(sheet, return_index=True)
    of = sheet[triangles[:, 0]]
    X = surface.vertices - surface.vertices.mean(axis=0)
    a, b, c = (X[triangles[:, k]] for k in range(3))
    volume = np.bincount(of, np.einsum("nd,nd->n", a, np.cross(b, c)) / 6.0, minlength=sheets)
    bodies = np.flatnonzero(volume > 0.0)
    body = np.arange(sheets)
    for hole in np.flatnonzero(volume <= 0.0):
        probe = surface.vertices[first[hole]][None]
        around = [
            k for k in bodies
            if winding_numbers(probe, surface.vertices, triangles[of == k])[0] > 0.5
        ]  # fmt: skip
        body[hole] = min(around, key=lambda k: volume[k])
    parts = []
    for k in bodies[np.argsort(first[bodies])]:
        mine = np.flatnonzero(body[sheet] == k)
        number = np.full(count, -1)
        number[mine] = np.arange(len(mine))
        faces = {
            name: number[face[body[sheet[face[:, 0]]] == k]]
            for name, face in surface.faces.items()
        }
        parts.append(SurfacePart(Surface(surface.vertices[mine], faces), mine))
    return parts
