"""Volumes and area vectors satisfy the identities that consistency rests on."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import (
    area_vectors,
    cell_volumes_and_centroids,
    layers_from_boundary,
    vertex_volumes,
)
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box

Array = NDArray[np.float64]
VOLUME = 1.0 * 0.8 * 1.2


@pytest.fixture(params=[0.0, 0.4, 0.9], ids=lambda j: f"jitter {j}")
def mesh(request: pytest.FixtureRequest) -> HexMesh:
    return Box(upper=(1.0, 0.8, 1.2), jitter=request.param, seed=4).mesh(0.2)


def test_volumes_sum_to_the_body(mesh: HexMesh) -> None:
    V = vertex_volumes(mesh)
    assert np.all(V > 0.0)
    assert np.sum(V) == pytest.approx(VOLUME, rel=1e-14)


def test_the_first_moment_of_the_volumes_is_that_of_the_body(mesh: HexMesh) -> None:
    """``sum V_a X_a = int X dV``: isoparametric shape functions carry linears."""
    V = vertex_volumes(mesh)
    np.testing.assert_allclose(V @ mesh.vertices, VOLUME * np.array([0.5, 0.4, 0.6]), rtol=1e-13)


def test_equal_volumes_fail_the_first_moment() -> None:
    mesh = Box(upper=(1.0, 0.8, 1.2), jitter=0.4, seed=4).mesh(0.2)
    lumped = np.full(len(mesh.vertices), VOLUME / len(mesh.vertices))
    exact = VOLUME * np.array([0.5, 0.4, 0.6])
    assert np.max(np.abs(lumped @ mesh.vertices - exact)) > 1e-4


def test_corners_edges_and_faces_of_a_lattice_have_their_share() -> None:
    mesh = Box().mesh(0.25)
    on = np.sum((mesh.vertices < 1e-12) | (mesh.vertices > 1.0 - 1e-12), axis=1)
    np.testing.assert_allclose(vertex_volumes(mesh), 0.25**3 / 2.0**on, rtol=1e-13)


def test_area_vectors_close_and_carry_the_volume(mesh: HexMesh) -> None:
    """``sum A N = 0`` and ``sum A N (x) X = V I``, which make D0 solvable."""
    area = area_vectors(mesh, mesh.boundary)
    np.testing.assert_allclose(np.sum(area, axis=0), 0.0, atol=1e-14)
    np.testing.assert_allclose(area.T @ mesh.vertices, VOLUME * np.eye(3), atol=1e-14)
    inside = np.setdiff1d(np.arange(len(area)), np.unique(mesh.boundary))
    np.testing.assert_array_equal(area[inside], 0.0)
    assert len(inside) > 20


def test_the_area_vectors_of_a_face_point_out_and_sum_to_it(mesh: HexMesh) -> None:
    sizes = {"X": 0.8 * 1.2, "Y": 1.0 * 1.2, "Z": 1.0 * 0.8}
    for face in mesh.faces:
        axis, sign = "XYZ".index(face[0]), 1.0 if face[1] == "+" else -1.0
        area = area_vectors(mesh, mesh.face(face))
        expected = np.zeros(3)
        expected[axis] = sign * sizes[face[0]]
        np.testing.assert_allclose(np.sum(area, axis=0), expected, atol=1e-14)
        assert np.all(sign * area[mesh.face_particles(face), axis] > 0.0)


def test_a_warped_surface_closes_too() -> None:
    """Bilinear faces that are not plane: the identities need no flat boundary."""
    box = Box(jitter=0.3).mesh(0.25)
    X = box.vertices
    bent = X + 0.1 * np.stack([X[:, 1] * X[:, 2], X[:, 0] ** 2, X[:, 0] * X[:, 1]], axis=1)
    mesh = dataclasses.replace(box, vertices=bent)
    area, V = area_vectors(mesh, mesh.boundary), vertex_volumes(mesh)
    np.testing.assert_allclose(np.sum(area, axis=0), 0.0, atol=1e-14)
    np.testing.assert_allclose(area.T @ bent, np.sum(V) * np.eye(3), atol=1e-14)


def test_cell_volumes_and_centroids_are_those_of_the_body(mesh: HexMesh) -> None:
    V, X = cell_volumes_and_centroids(mesh)
    assert np.sum(V) == pytest.approx(VOLUME, rel=1e-14)
    np.testing.assert_allclose(V @ X, VOLUME * np.array([0.5, 0.4, 0.6]), rtol=1e-13)


def test_the_centroid_of_a_wedge_is_the_integral_not_the_mean_of_its_corners() -> None:
    """``0 <= Z <= 1 + X``: centroid ``X = 5/9, Z = 7/9``, mean of corners ``X = 1/2``."""
    box = Box().mesh(1.0)
    X = box.vertices.copy()
    X[:, 2] *= 1.0 + X[:, 0]
    V, centroid = cell_volumes_and_centroids(dataclasses.replace(box, vertices=X))
    np.testing.assert_allclose(V, [1.5], rtol=1e-14)
    np.testing.assert_allclose(centroid, [[5 / 9, 0.5, 7 / 9]], rtol=1e-13)


def test_an_inverted_cell_is_refused_and_named() -> None:
    mesh = Box().mesh(0.5)
    X = mesh.vertices.copy()
    middle = int(np.argmin(np.sum((X - 0.5) ** 2, axis=1)))
    X[middle] = [1.6, 0.5, 0.5]
    cells = np.flatnonzero((mesh.cells == middle).any(axis=1))
    with pytest.raises(InputError, match=r"cell (\d+) .* inverted or flat") as caught:
        vertex_volumes(dataclasses.replace(mesh, vertices=X))
    assert int(str(caught.value).split()[1]) in cells


def test_layers_count_cells_to_the_boundary() -> None:
    mesh = Box(upper=(1.0, 1.0, 2.0), jitter=0.3).mesh(0.1)
    lattice = Box(upper=(1.0, 1.0, 2.0)).mesh(0.1)
    steps = np.rint(lattice.vertices / 0.1).astype(int)
    expected = np.min(np.minimum(steps, [10, 10, 20] - steps), axis=1)
    np.testing.assert_array_equal(layers_from_boundary(mesh), expected)
    assert expected.max() == 5
