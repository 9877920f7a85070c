"""Tetrahedra for a body that is meshed with hexahedra: six of each, without new nodes.

In every hexahedron the corner of the lowest number is the apex; each of the three quadrilaterals
that do not touch it is cut along the diagonal through its own lowest corner, and every triangle
makes one tetrahedron with the apex.  A quadrilateral is cut in the same way from both sides, so the
tetrahedra fit whatever the hexahedra ([Dompierre1999]); on a grid it is the Kuhn split.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh

Indices = NDArray[np.int64]


def tetrahedra(mesh: Mesh) -> TetMesh:
    """The mesh itself where its cells are tetrahedra; otherwise its hexahedra, split.

    The vertices are those of ``mesh``; tags keep their names.  Raises ``InputError`` where a
    tetrahedron is flat or inside out, which a strongly distorted hexahedron brings about.
    """
    if isinstance(mesh, TetMesh):
        cells, made = mesh.cells, mesh
    else:
        assert isinstance(mesh, HexMesh)
        cells = _split(mesh.cells)
        faces = {name: _triangles(quads).reshape(-1, 3) for name, quads in mesh.faces.items()}
        made = TetMesh(mesh.vertices, cells, faces, mesh.spacing, False, unusable=mesh.unusable)
    X = mesh.vertices[cells]
    volume = np.linalg.det(X[:, 1:] - X[:, :1])
    worst = int(np.argmin(volume))
    require(
        bool(volume[worst] > 1.0e-12 * mesh.spacing**3),
        f"tetrahedron {worst} with vertices {cells[worst].tolist()} is flat or inside out in the "
        "undeformed body; reduce the jitter or repair the mesh",
    )
    return made


def _triangles(quads: Indices) -> Indices:
    """``(f, 4)`` loops to two triangles each ``(f, 2, 3)``, cut through the lowest vertex."""
    first = np.argmin(quads, axis=-1)
    turned = np.take_along_axis(quads, (first[..., None] + np.arange(4)) % 4, axis=-1)
    return turned[..., [[0, 1, 2], [0, 2, 3]]]


def _split(cells: Indices) -> Indices:
    """``(E, 8)`` to ``(6 E, 4)`` of positive volume."""
    apex = cells.min(axis=1)
    quads = cells[:, HEXAHEDRON.facets]
    away = ~(quads == apex[:, None, None]).any(axis=2)
    triangles = _triangles(quads[away].reshape(-1, 3, 4)).reshape(-1, 6, 3)
    # A facet's loop turns outward, so seen from the apex inside it turns the other way.
    tops = np.broadcast_to(apex[:, None, None], (len(cells), 6, 1))
    return np.concatenate([tops, triangles], axis=2).reshape(-1, 4)
