"""Uniform refinement: every cell of a mesh becomes eight, tags are kept, the body stays itself.

A hexahedron is cut at the images of its middle planes; the children of its trilinear map are
trilinear again, so they fill it exactly.  A tetrahedron keeps its four corners, and the octahedron
that is left is cut along the shortest of its three diagonals, which keeps the cells from
degenerating however often it is done.  Curved boundaries stay the facets that they were.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Body, Spacing
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh
from sphsolid.geometry.point_mesh import PointMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_TET_EDGES = tuple(combinations(range(4), 2))
#: Diagonals of the octahedron as places in ``_TET_EDGES``, and the ring of the four others.
_DIAGONALS = ((0, 5, (1, 3, 4, 2)), (1, 4, (0, 3, 5, 2)), (2, 3, (0, 4, 5, 1)))
#: The 27 points of a cut hexahedron: each the mean of the corners on its side of every axis.
_HEX_POINTS = np.stack(np.meshgrid(*([np.arange(3)] * 3), indexing="ij"), axis=-1).reshape(-1, 3)
_HEX_GROUPS = [
    tuple(np.flatnonzero(np.all((point == 1) | (point == 2 * CORNERS), axis=1)).tolist())
    for point in _HEX_POINTS
]
#: Children: the octant's corners among the 27 points.
_HEX_CHILDREN = np.array(
    [[int((octant + corner) @ (9, 3, 1)) for corner in CORNERS] for octant in CORNERS]
)
#: Children of a facet among its corners, the middles of its edges and its own middle.
_QUAD_CHILDREN = np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]])
_TRIANGLE_CHILDREN = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def _tet_children() -> Indices:
    """Eight children for each choice of the diagonal ``(3, 8, 4)``, all of positive volume.

    Points: the four corners, then the middles of ``_TET_EDGES``.
    """
    corner = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    points = np.concatenate([corner, [corner[list(edge)].mean(axis=0) for edge in _TET_EDGES]])

    def middle(a: int, b: int) -> int:
        return 4 + _TET_EDGES.index((min(a, b), max(a, b)))

    outer = [[c if c == d else middle(c, d) for d in range(4)] for c in range(4)]
    choices = []
    for p, q, ring in _DIAGONALS:
        inner = [[4 + p, 4 + q, 4 + ring[k], 4 + ring[(k + 1) % 4]] for k in range(4)]
        for child in inner:
            edges = points[child[1:]] - points[child[0]]
            if np.linalg.det(edges) < 0.0:
                child[2], child[3] = child[3], child[2]
        choices.append(outer + inner)
    return np.array(choices)


_TET_CHILDREN = _tet_children()


class _Points:
    """New vertices, one for every set of old ones of which it is the mean."""

    def __init__(self, vertices: Array) -> None:
        self.vertices = vertices

    def add(self, groups: Indices) -> Indices:
        """Number of the mean of each group ``(n, k)`` of old vertices; equal groups share one."""
        distinct, number = np.unique(np.sort(groups, axis=1), axis=0, return_inverse=True)
        first = len(self.vertices)
        self.vertices = np.concatenate([self.vertices, self.vertices[distinct].mean(axis=1)])
        return first + np.asarray(number, dtype=np.int64).reshape(-1)


def refined(mesh: Mesh) -> HexMesh | TetMesh:
    """The mesh with every cell cut into eight; old vertices keep their numbers.

    The nominal spacing is halved.  Raises ``InputError`` for a mesh of points: its cells do not
    fill the body by themselves.
    """
    if isinstance(mesh, PointMesh):
        raise InputError(
            "a cloud of points cannot be refined: its cells fill its body only together with "
            "their shares; give a finer set of points and a finer surface"
        )
    if isinstance(mesh, HexMesh):
        return _refined_hexahedra(mesh)
    if isinstance(mesh, TetMesh):
        return _refined_tetrahedra(mesh)
    raise InputError(f"cells of type {mesh.shape.name} cannot be refined")


def _refined_hexahedra(mesh: HexMesh) -> HexMesh:
    points, cells = _Points(mesh.vertices), mesh.cells
    loops = mesh.boundary
    number = np.empty((len(cells), 27), dtype=np.int64)
    on_loops = np.empty((len(loops), 9), dtype=np.int64)
    on_loops[:, :4] = loops
    for size in (1, 2, 4, 8):
        places = [k for k, group in enumerate(_HEX_GROUPS) if len(group) == size]
        groups = [cells[:, list(_HEX_GROUPS[k])] for k in places]
        if size == 1:
            for place, group in zip(places, groups, strict=True):
                number[:, place] = group[:, 0]
            continue
        # Facets are cut at the same points as the cells behind them.
        wanted = {
            2: [loops[:, [k, (k + 1) % 4]] for k in range(4)], 4: [loops], 8: [],
        }[size]  # fmt: skip
        found = points.add(np.concatenate([*groups, *wanted]))
        in_cells = found[: len(cells) * len(places)].reshape(len(places), len(cells))
        number[:, places] = in_cells.T
        if wanted:
            rest = found[len(cells) * len(places) :].reshape(len(wanted), len(loops))
            on_loops[:, {2: [4, 5, 6, 7], 4: [8]}[size]] = rest.T
    return replace(
        mesh,
        vertices=points.vertices,
        cells=number[:, _HEX_CHILDREN].reshape(-1, 8),
        faces=_cut_faces(mesh, on_loops[:, _QUAD_CHILDREN]),
        spacing=0.5 * mesh.spacing,
    )


def _refined_tetrahedra(mesh: TetMesh) -> TetMesh:
    points, cells, loops = _Points(mesh.vertices), mesh.cells, mesh.boundary
    edges = [cells[:, list(edge)] for edge in _TET_EDGES]
    around = [loops[:, [k, (k + 1) % 3]] for k in range(3)]
    found = points.add(np.concatenate([*edges, *around]))
    middle = found[: 6 * len(cells)].reshape(6, len(cells)).T
    number = np.concatenate([cells, middle], axis=1)
    on_loops = np.concatenate([loops, found[6 * len(cells) :].reshape(3, len(loops)).T], axis=1)
    X = points.vertices
    length = np.stack(
        [np.linalg.norm(X[middle[:, p]] - X[middle[:, q]], axis=1) for p, q, _ in _DIAGONALS],
        axis=1,
    )
    children = _TET_CHILDREN[np.argmin(length, axis=1)].reshape(len(cells), -1)
    return replace(
        mesh,
        vertices=points.vertices,
        cells=np.take_along_axis(number, children, axis=1).reshape(-1, 4),
        faces=_cut_faces(mesh, on_loops[:, _TRIANGLE_CHILDREN]),
        spacing=0.5 * mesh.spacing,
    )


def _cut_faces(mesh: Mesh, children: Indices) -> dict[str, Indices]:
    """Children ``(f, 4, m)`` of all boundary facets, by the tags of their parents."""
    faces, start = {}, 0
    for name in sorted(mesh.faces):
        stop = start + len(mesh.faces[name])
        faces[name] = children[start:stop].reshape(-1, children.shape[2])
        start = stop
    return faces


@dataclass(frozen=True)
class Refined:
    """A body whose mesh is refined ``times`` times; a spacing is that before refinement."""

    body: Body
    times: int = 1

    def __post_init__(self) -> None:
        require(
            0 <= self.times <= 6,
            f"Refined: times = {self.times} is outside [0, 6]; each makes eight times the cells",
        )

    def mesh(self, spacing: Spacing) -> Mesh:
        """The mesh of the body, refined; raises as :func:`refined` and the body do."""
        mesh = self.body.mesh(spacing)
        for _ in range(self.times):
            mesh = refined(mesh)
        return mesh

    @property
    def volume(self) -> float:
        """That of the body [m^3]."""
        return self.body.volume
