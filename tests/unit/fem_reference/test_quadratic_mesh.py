"""Nodes, faces and volumes of the 27-node hexahedra."""

import dataclasses

import numpy as np
import pytest
from skfem import Basis, ElementHex2, FacetBasis

from fem_reference.mesh import scikit_fem_mesh
from fem_reference.quadratic_mesh import NODES, quadratic_mesh, trilinear
from fem_reference.quadratic_tables import (
    corner_mass,
    quadratic_gradients,
    simpson_volumes,
)
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box
from tests.oracles.hexahedra import gauss_points, tensor_shapes


def brick(jitter: float) -> HexMesh:
    return Box(lower=(-1.0, 0.0, 2.0), upper=(1.0, 0.9, 3.0), jitter=jitter, seed=3).mesh(0.5)


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_nodes_are_those_of_scikit_fem_and_are_all_used(jitter: float) -> None:
    mesh = brick(jitter)
    sk = scikit_fem_mesh(mesh)
    found = quadratic_mesh(mesh, sk)
    dofs = Basis(sk, ElementHex2(), intorder=1).doflocs.T
    assert found.parts.vertices.shape == dofs.shape
    np.testing.assert_allclose(found.parts.vertices[found.node_of_dof], dofs, atol=1e-14)
    # Numbered as the elements meet them.
    assert found.cells[0].tolist() == list(range(27))
    assert np.unique(found.cells).tolist() == list(range(len(dofs)))


def test_on_a_lattice_the_nodes_are_the_vertices_of_half_the_spacing() -> None:
    mesh = Box(upper=(1.0, 2.0, 0.5)).mesh(0.5)
    parts = quadratic_mesh(mesh, scikit_fem_mesh(mesh)).parts
    fine = Box(upper=(1.0, 2.0, 0.5)).mesh(0.25)
    assert parts.is_lattice
    assert parts.spacing == fine.spacing

    def ordered(points: np.ndarray) -> np.ndarray:
        return points[np.lexsort(points.T)]

    np.testing.assert_array_equal(ordered(parts.vertices), ordered(fine.vertices))
    assert sorted(parts.faces) == sorted(fine.faces)
    for name in fine.faces:
        mine, theirs = parts.face_particles(name), fine.face_particles(name)
        np.testing.assert_array_equal(
            ordered(parts.vertices[mine]), ordered(fine.vertices[theirs])
        )


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_parts_fill_the_body_and_their_faces_look_outwards(jitter: float) -> None:
    mesh = brick(jitter)
    parts = quadratic_mesh(mesh, scikit_fem_mesh(mesh)).parts
    fine = scikit_fem_mesh(parts)
    assert np.sum(Basis(fine, ElementHex2(), intorder=5).dx) == pytest.approx(1.8, rel=1e-13)
    assert sum(map(len, fine.boundaries.values())) == len(fine.boundary_facets())
    for axis, name in enumerate("XYZ"):
        for side in "-+":
            corners = parts.vertices[parts.face(f"{name}{side}")]
            area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
            assert np.all(area[:, axis] * (1.0 if side == "+" else -1.0) > 0.0)
            surface = FacetBasis(fine, ElementHex2(), facets=fine.boundaries[f"{name}{side}"])
            assert 0.5 * np.abs(area[:, axis]).sum() == pytest.approx(np.sum(surface.dx))


def test_shapes_are_the_lagrange_polynomials() -> None:
    points, weights = gauss_points(3)
    _, expected = tensor_shapes(NODES, points)
    np.testing.assert_allclose(quadratic_gradients(points), expected, atol=1e-14)
    assert trilinear(points).sum(axis=1) == pytest.approx(1.0)
    assert weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_lumped_volumes_are_positive_and_have_the_moments_of_the_body(jitter: float) -> None:
    mesh = brick(jitter)
    nodes = quadratic_mesh(mesh, scikit_fem_mesh(mesh))
    X = nodes.parts.vertices
    V = simpson_volumes(mesh, nodes.cells, len(X))
    assert V.min() > 0.0
    assert V.sum() == pytest.approx(1.8, rel=1e-14)
    np.testing.assert_allclose(V @ X / 1.8, [0.0, 0.45, 2.5], atol=1e-13)
    if jitter == 0.0:
        # Second moments too: the rule is exact for the cubics of a brick.
        np.testing.assert_allclose(V @ X[:, 0] ** 2, 1.8 / 3.0, rtol=1e-13)
        np.testing.assert_allclose(V @ (X[:, 0] * X[:, 1]), 0.0, atol=1e-13)
    M = corner_mass(mesh)
    ones = np.ones(M.shape[0])
    assert ones @ (M @ ones) == pytest.approx(1.8, rel=1e-14)
    assert mesh.vertices[:, 0] @ (M @ ones) == pytest.approx(0.0, abs=1e-13)


def test_a_folded_element_is_refused_by_number() -> None:
    mesh = Box().mesh(0.5)
    vertices = mesh.vertices.copy()
    vertices[13] = (1.4, 0.5, 0.5)
    folded = dataclasses.replace(mesh, vertices=vertices, is_lattice=False)
    nodes = quadratic_mesh(folded, scikit_fem_mesh(folded))
    with pytest.raises(InputError, match=r"element \d+ .* folded"):
        simpson_volumes(folded, nodes.cells, len(nodes.parts.vertices))
