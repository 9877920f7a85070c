"""Secondary particles from tetrahedra: the hexahedra of a lattice, compact clusters elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sphsolid as sph
from sphsolid.cloud import Agglomerated
from sphsolid.cloud.agglomerated import clusters
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Body, Box, PointCloud, Surface, TetBox
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.delaunay import delaunay, tetrahedron_volumes
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import HexMesh, TetMesh
from tests.oracles import moved_meshes as moved

L_BLOCK = (((0, 0, 0), (3, 6, 2)), ((3, 0, 0), (5, 2, 2)))


def both(body: Body, spacing: float) -> tuple[HexMesh, TetMesh]:
    """Hexahedra, and the tetrahedra of nothing but their vertices and their boundary."""
    hexes = body.mesh(spacing)
    assert isinstance(hexes, HexMesh)
    surface = Surface.closed(vertices=hexes.vertices, faces=hexes.faces)
    return hexes, PointCloud(hexes.vertices, surface).mesh(AS_MESHED)


@pytest.mark.parametrize("body", [Box(upper=(1.0, 0.5, 0.75)), Blocks(L_BLOCK)])
def test_on_a_lattice_they_are_the_hexahedra(body: Body) -> None:
    hexes, tets = both(body, 0.125 if isinstance(body, Box) else 0.5)
    X, V = Agglomerated().place(tets)
    exact_X, exact_V = sph.H1().place(hexes)
    assert len(X) == len(exact_X)
    distance, same = cKDTree(exact_X).query(X)
    assert len(np.unique(same)) == len(X)
    assert distance.max() < 1e-12
    np.testing.assert_allclose(V, exact_V[same], rtol=1e-11)


@pytest.mark.parametrize("jitter", [1e-3, 0.05, 0.2, 0.4])
def test_in_disorder_they_stay_close_to_them(jitter: float) -> None:
    """The hexahedra are found again although nothing says where they are."""
    hexes, tets = both(Box(jitter=jitter, seed=1), 0.125)
    X, V = Agglomerated().place(tets)
    exact_X, exact_V = sph.H1().place(hexes)
    assert len(X) == len(exact_X)
    distance, same = cKDTree(exact_X).query(X)
    assert len(np.unique(same)) == len(X)
    assert distance.max() < 0.6 * jitter * tets.spacing
    assert np.std(V / exact_V[same]) < 0.15 * jitter


@pytest.mark.parametrize("per_particle", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("body", ["tet", "jitter"])
def test_sums_are_exact_and_clusters_compact(body: str, per_particle: float) -> None:
    mesh = TetBox(seed=2).mesh(0.125) if body == "tet" else both(Box(jitter=0.5), 0.125)[1]
    rule = Agglomerated(per_particle)
    X, V = rule.place(mesh)
    assert rule.name == f"A{per_particle:g}"
    assert len(X) == round(per_particle * 512)
    assert V.sum() == pytest.approx(1.0, rel=1e-13)
    np.testing.assert_allclose(V @ X, 0.5, rtol=1e-13)
    mean = 1.0 / len(X)
    assert 0.15 * mean < V.min()
    assert V.max() < 3.5 * mean
    group = clusters(mesh, per_particle)
    reach = np.zeros(len(X))
    np.maximum.at(
        reach, np.repeat(group, 4),
        np.linalg.norm(mesh.vertices[mesh.cells] - X[group][:, None], axis=2).ravel(),
    )  # fmt: skip
    # The half diagonal of a cube is 0.87 of its edge.
    assert reach.max() < 2.0 * np.cbrt(mean)
    assert cKDTree(X).query(X, k=2)[0][:, 1].min() > 0.4 * np.cbrt(mean)


def test_every_cluster_hangs_together_over_facets() -> None:
    mesh = TetBox().mesh(0.2)
    group = clusters(mesh, 1.0)
    number = same_vertices(cell_facets(mesh.cells, mesh.shape))
    owner = np.repeat(np.arange(len(mesh.cells)), 4)
    order = np.argsort(number, kind="stable")
    shared = np.flatnonzero(np.diff(number[order]) == 0)
    one, two = owner[order[shared]], owner[order[shared + 1]]
    inside = group[one] == group[two]
    root = np.arange(len(group))
    for _ in range(len(group)):
        low = np.minimum(root[one[inside]], root[two[inside]])
        before = root.copy()
        np.minimum.at(root, one[inside], low)
        np.minimum.at(root, two[inside], low)
        if np.array_equal(before, root):
            break
    assert len(np.unique(root)) == len(np.unique(group)) == group.max() + 1


def test_more_than_there_are_is_one_a_tetrahedron() -> None:
    mesh = TetBox().mesh(0.25)
    mesh = replace(mesh, spacing=0.5 * mesh.spacing)
    X, V = Agglomerated(6.0).place(mesh)
    volume, centroid = cell_volumes_and_centroids(mesh)
    np.testing.assert_allclose(np.sort(V), np.sort(volume))
    assert cKDTree(centroid).query(X)[0].max() < 1e-15


def test_it_repeats_and_moves_with_the_body() -> None:
    mesh = TetBox().mesh(0.2)
    X, V = Agglomerated().place(mesh)
    again = Agglomerated().place(TetBox().mesh(0.2))
    np.testing.assert_array_equal(X, again[0])
    moved = TetMesh(3.0 * mesh.vertices + 7.0, mesh.cells, mesh.faces, 3.0 * mesh.spacing, False)
    np.testing.assert_allclose(Agglomerated().place(moved)[0], 3.0 * X + 7.0, rtol=1e-12)
    np.testing.assert_allclose(Agglomerated().place(moved)[1], 27.0 * V, rtol=1e-10)


def test_what_it_cannot_use_is_refused() -> None:
    with pytest.raises(InputError, match="needs tetrahedra"):
        Agglomerated().place(Box().mesh(0.5))
    with pytest.raises(InputError, match="per_particle"):
        Agglomerated(0.0).place(TetBox().mesh(0.5))


def body_centred() -> TetMesh:
    """Tetrahedra of a body-centred cubic lattice, all alike inside: every cost is a tie."""
    corners = np.stack(np.meshgrid(*3 * [np.arange(5.0)], indexing="ij"), axis=-1).reshape(-1, 3)
    centres = corners[np.all(corners < 4.0, axis=1)] + 0.5
    vertices = np.concatenate([corners, centres]) / 4.0
    cells = delaunay(vertices)
    cells = cells[tetrahedron_volumes(vertices, cells) > 1e-9]
    return TetMesh(vertices, cells, {}, (2.0 / len(cells)) ** (1 / 3), is_lattice=False)


def filled_ball() -> TetMesh:
    """A lattice inside the surface of a ball."""
    box = Box((-1.0, -1.0, -1.0)).mesh(0.4)
    vertices = np.tan(box.vertices * np.pi / 4.0)
    vertices /= np.maximum(1e-9, np.linalg.norm(vertices, axis=1))[:, None]
    surface = Surface.closed(vertices=vertices, faces=box.faces)
    return PointCloud.fill(surface=surface, spacing=0.3).mesh(AS_MESHED)


def split_cubes() -> TetMesh:
    """Cubes of six tetrahedra around a diagonal: centres coincide, and volumes are equal."""
    hexes = Box(upper=(1.0, 0.75, 0.5)).mesh(0.25)
    path = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
    cells = hexes.cells[:, path].reshape(-1, 4)
    stretched = hexes.vertices * [1.0, 0.7, 1.3]
    return TetMesh(stretched, cells, {}, 0.25 * 0.91 ** (1 / 3), is_lattice=False)


@pytest.mark.parametrize("per_particle", [1.0, 2.0])
@pytest.mark.parametrize("make", [body_centred, filled_ball, split_cubes])
def test_equal_costs_are_not_left_to_round_off(
    make: Callable[[], TetMesh], per_particle: float
) -> None:
    """In any unit, at any place, in the mirror and turned the secondary points are the same."""
    mesh, points = make(), Agglomerated(per_particle)
    X, _ = points.place(mesh)
    for unit in (1e-3, 25.4, 1e3, 1.0 / 3.0):
        there, _ = points.place(moved.scaled(mesh, unit))
        np.testing.assert_allclose(there / unit, X, rtol=0.0, atol=1e-13)
    there, _ = points.place(moved.elsewhere(mesh, (1e3, -700.0, 30.1)))
    np.testing.assert_allclose(there - [1e3, -700.0, 30.1], X, rtol=0.0, atol=1e-11)
    there, _ = points.place(moved.mirrored(mesh))
    np.testing.assert_allclose(there * [-1.0, 1.0, 1.0], X, rtol=0.0, atol=1e-13)
    there, _ = points.place(moved.turned(mesh))
    np.testing.assert_allclose(there, X[:, [1, 2, 0]], rtol=0.0, atol=1e-13)
