"""The spacing around a vertex: exact on lattices, smooth on graded meshes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.integrals import local_spacing
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh
from sphsolid.scenes import Box


def six_tetrahedra_a_cube(mesh: Mesh) -> TetMesh:
    """Kuhn's tetrahedra: one a permutation of the axes, walking from corner 0 to corner 6."""
    corner = {tuple(c): k for k, c in enumerate(CORNERS.tolist())}
    cells = []
    for order in itertools.permutations(range(3)):
        path = np.cumsum(np.concatenate([np.zeros((1, 3), int), np.eye(3, dtype=int)[[*order]]]), 0)
        local = [corner[tuple(step)] for step in path.tolist()]
        if np.linalg.det(np.diff(path, axis=0)) < 0:
            local[2:] = local[:1:-1]
        cells.append(mesh.cells[:, local])
    return TetMesh(mesh.vertices, np.concatenate(cells), {}, mesh.spacing, False)


CUBES = Box().mesh(0.25)


@pytest.mark.parametrize("mesh", [CUBES, six_tetrahedra_a_cube(CUBES)], ids=["hex", "tet"])
def test_on_cubes_it_is_their_edge_at_every_vertex(mesh: Mesh) -> None:
    np.testing.assert_allclose(local_spacing(mesh), 0.25, rtol=1e-14)


@pytest.mark.parametrize("mesh", [CUBES, six_tetrahedra_a_cube(CUBES)], ids=["hex", "tet"])
def test_it_scales_with_the_mesh_and_stands_for_the_volume_of_a_stretched_one(mesh: Mesh) -> None:
    stretched = replace(mesh, vertices=mesh.vertices * [1e-3, 2e-3, 4e-3])
    np.testing.assert_allclose(local_spacing(stretched), 0.5e-3, rtol=1e-14)


def test_between_two_sizes_the_larger_cell_weighs_more() -> None:
    """Cubes of edge 1 below, prisms of height 8 (edge of their cube 2) above."""
    mesh = Box(upper=(1, 1, 2)).mesh(1.0)
    X = mesh.vertices.copy()
    X[X[:, 2] == 2.0, 2] = 9.0
    spacing = local_spacing(replace(mesh, vertices=X))
    for z, expected in ((0.0, 1.0), (1.0, (1 * 1 + 8 * 2) / 9), (9.0, 2.0)):
        np.testing.assert_allclose(spacing[X[:, 2] == z], expected, rtol=1e-14)


def test_it_follows_the_grading_of_a_mesh() -> None:
    """Planes at ``x = e^(k s) - 1``: cells grow by ``e^s``, the spacing lies between neighbours."""
    mesh = Box(upper=(20, 1, 1)).mesh(1.0)
    s = 0.1
    X = mesh.vertices.copy()
    X = np.stack([np.exp(s * X[:, 0]) - 1.0, X[:, 1], X[:, 2]], axis=1)
    spacing = local_spacing(replace(mesh, vertices=X))
    edge = np.cbrt(np.exp(s * np.arange(20)) * (np.exp(s) - 1.0))
    k = np.rint(mesh.vertices[:, 0]).astype(int)
    inside = (k > 0) & (k < 20)
    assert np.all(spacing[inside] > edge[k[inside] - 1])
    assert np.all(spacing[inside] < edge[k[inside]])
    np.testing.assert_allclose(spacing[k == 0], edge[0], rtol=1e-13)


@dataclass(frozen=True)
class HalfFull(HexMesh):
    @property
    def filling(self):
        return np.full(len(self.cells), 0.5)


def test_how_full_a_cell_is_does_not_change_the_distance_of_its_vertices() -> None:
    half = HalfFull(CUBES.vertices, CUBES.cells, CUBES.faces, CUBES.spacing, True)
    np.testing.assert_allclose(local_spacing(half), 0.25, rtol=1e-14)


def test_a_vertex_without_a_cell_is_named() -> None:
    stray = replace(CUBES, vertices=np.concatenate([CUBES.vertices, [[7.0, 8.0, 9.0]]]))
    with pytest.raises(InputError, match=r"vertex 125 at X = \[7.0, 8.0, 9.0\] m belongs to no"):
        local_spacing(stray)
