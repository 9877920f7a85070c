"""The mesh handed to scikit-fem, and the arrays taken back from it."""

import dataclasses

import numpy as np
import pytest
from skfem import ElementHex1, FacetBasis, MeshHex

from fem_reference.hex_quadrature import hex_quadrature
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box

OUTWARD = {
    "X-": (-1, 0, 0),
    "X+": (1, 0, 0),
    "Y-": (0, -1, 0),
    "Y+": (0, 1, 0),
    "Z-": (0, 0, -1),
    "Z+": (0, 0, 1),
}


def brick(jitter: float) -> HexMesh:
    return Box(lower=(-1.0, 0.0, 2.0), upper=(1.0, 0.9, 3.0), jitter=jitter, seed=3).mesh(0.33)


def test_numbering_is_kept_and_every_boundary_is_named_with_its_outward_normal() -> None:
    mesh = brick(jitter=0.5)
    sk = scikit_fem_mesh(mesh)
    assert isinstance(sk, MeshHex)
    np.testing.assert_array_equal(sk.p.T, mesh.vertices)
    np.testing.assert_array_equal(np.sort(sk.t.T, axis=1), np.sort(mesh.cells, axis=1))
    assert sum(len(facets) for facets in sk.boundaries.values()) == len(sk.boundary_facets())
    for name, normal in OUTWARD.items():
        surface = FacetBasis(sk, ElementHex1(), facets=sk.boundaries[name])
        np.testing.assert_allclose(surface.normals[:, 0, 0], normal, atol=1e-14)


def test_a_tag_on_an_interior_face_is_refused() -> None:
    mesh = brick(jitter=0.0)
    inside = mesh.cells[0, [1, 2, 6, 5]][None]
    with pytest.raises(InputError, match="'cut'"):
        scikit_fem_mesh(dataclasses.replace(mesh, faces={"cut": inside}))


@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_gradients_reproduce_linear_fields_and_volumes_add_up(jitter: float) -> None:
    mesh = brick(jitter)
    quadrature = hex_quadrature(mesh, scikit_fem_mesh(mesh))
    assert quadrature.congruent == (jitter == 0.0)
    A = np.random.default_rng(0).normal(size=(3, 3))
    linear = (mesh.vertices @ A.T)[mesh.cells]
    centroid = np.broadcast_to(quadrature.centroid_gradients, (len(mesh.cells), 8, 3))
    at_centre = np.einsum("eai,eak->eik", linear, centroid)
    np.testing.assert_allclose(at_centre, np.broadcast_to(A, at_centre.shape), atol=1e-12)
    volume = 2.0 * 0.9 * 1.0
    assert quadrature.volumes.sum() == pytest.approx(volume, rel=1e-14)
    nodal = quadrature.nodal_volumes(len(mesh.vertices))
    assert nodal.sum() == pytest.approx(volume, rel=1e-14)
    # First moments of the lumped volumes are those of the body: constants and linears are exact.
    np.testing.assert_allclose(nodal @ mesh.vertices / volume, [0.0, 0.45, 2.5], atol=1e-13)


def test_length_is_the_shortest_edge_of_a_brick_and_less_when_slanted() -> None:
    mesh = Box(upper=(1.0, 2.0, 3.0)).mesh(10.0)
    assert hex_quadrature(mesh, scikit_fem_mesh(mesh)).length == pytest.approx(1.0)
    shear = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    slanted = dataclasses.replace(mesh, vertices=mesh.vertices @ shear.T, is_lattice=False)
    length = hex_quadrature(slanted, scikit_fem_mesh(slanted)).length[0]
    expected = np.linalg.svd(shear @ np.diag([1.0, 2.0, 3.0]), compute_uv=False).min()
    assert length == pytest.approx(expected)


def test_a_lattice_flag_on_unequal_cells_does_not_make_them_bricks() -> None:
    mesh = Box(jitter=0.3).mesh(0.5)
    assert not hex_quadrature(
        dataclasses.replace(mesh, is_lattice=True), scikit_fem_mesh(mesh)
    ).congruent


def test_a_folded_element_is_refused_by_number() -> None:
    mesh = Box().mesh(0.5)
    vertices = mesh.vertices.copy()
    vertices[13] = (1.4, 0.5, 0.5)
    folded = dataclasses.replace(mesh, vertices=vertices, is_lattice=False)
    with pytest.raises(InputError, match=r"element \d+ .* folded"):
        hex_quadrature(folded, scikit_fem_mesh(folded))
