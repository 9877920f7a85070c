"""The shared mesh as scikit-fem sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex, MeshTet
from skfem.refdom import RefHex

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh, TetMesh

#: scikit-fem's local node ``k`` is corner ``CORNER_OF_NODE[k]`` of a ``HexMesh`` cell: scikit-fem
#: counts from (1, 1, 1) down to (0, 0, 0), so the two orders are matched by coordinates.
CORNER_OF_NODE: NDArray[np.int64] = np.array(
    [int(np.flatnonzero((node == CORNERS).all(axis=1))[0]) for node in RefHex.p.T]
)


def scikit_fem_mesh(mesh: HexMesh) -> MeshHex:
    """``MeshHex`` with the vertices and cells of ``mesh`` in the same numbering.

    Boundary tags become named boundaries (``sk.boundaries[name]``, facet numbers).  Raises
    ``InputError`` where a tagged quadrilateral is no boundary facet of the cells.
    """
    points = np.ascontiguousarray(mesh.vertices.T)
    cells = np.ascontiguousarray(mesh.cells[:, CORNER_OF_NODE].T)
    # Named boundaries are facet numbers, which exist only once the facets have been built.
    untagged = MeshHex(points, cells)
    boundaries = {name: _facets(untagged, name, quads) for name, quads in mesh.faces.items()}
    return MeshHex(points, cells, _boundaries=boundaries)


def scikit_fem_tetrahedra(mesh: TetMesh) -> MeshTet:
    """``MeshTet`` of ``mesh``, as :func:`scikit_fem_mesh` makes it of hexahedra."""
    points, cells = np.ascontiguousarray(mesh.vertices.T), np.ascontiguousarray(mesh.cells.T)
    untagged = MeshTet(points, cells)
    boundaries = {name: _facets(untagged, name, loops) for name, loops in mesh.faces.items()}
    return MeshTet(points, cells, _boundaries=boundaries)


def _facets(sk: MeshHex | MeshTet, name: str, quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Boundary facet numbers of loops ``(f, m)``, matched by their set of vertices."""
    candidates = sk.boundary_facets()
    known = {tuple(sorted(sk.facets[:, facet])): int(facet) for facet in candidates}
    numbers = np.empty(len(quads), dtype=np.int64)
    for row, quad in enumerate(quads):
        key = tuple(sorted(quad))
        if key not in known:
            raise InputError(
                f"boundary tag {name!r}: facet {quad.tolist()} is no boundary facet of "
                "the cells; tag only faces that belong to exactly one cell"
            )
        numbers[row] = known[key]
    return numbers
