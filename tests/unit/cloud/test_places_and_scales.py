"""One body in another unit, mirrored, turned, renumbered or far away has the same operators."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, OperatorKind, build_cloud
from sphsolid.cloud.boundary_weights import quadratically_exact_areas
from sphsolid.cloud.pairs.parts import parts_of
from sphsolid.geometry import Box, TetBox
from sphsolid.geometry.integrals import cell_volumes_and_centroids, vertex_volumes
from sphsolid.geometry.mesh import Mesh
from tests.oracles import moved_meshes as moved
from tests.oracles.dense import dense

Array = NDArray[np.float64]
#: The operators of a body agree to this, relative to their largest entry.
SAME = 1e-8
BODIES = {
    "disordered": Box(upper=(1.0, 0.75, 0.75), jitter=0.4, seed=3).mesh(0.25),
    "sheared": moved.sheared(Box(upper=(1.0, 0.75, 0.75), jitter=0.4, seed=5).mesh(0.25)),
    "tetrahedra": TetBox(upper=(1.0, 0.75, 0.75)).mesh(0.25),
    "lattice": Box(upper=(1.0, 0.75, 0.75)).mesh(0.25),
}


def built(mesh: Mesh, operator: OperatorKind) -> Cloud:
    return build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=operator)


def gradient(cloud: Cloud) -> Array:
    """``G_b(X_a)`` in every pair's place ``(N, N, 3)`` [1/m]."""
    return dense(cloud.pairs, cloud.gradients.kinematic, cloud.size)


def largest_difference(a: Array, b: Array) -> float:
    return float(np.max(np.abs(a - b)) / np.max(np.abs(a)))


@pytest.fixture(scope="module", params=BODIES)
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return BODIES[request.param]


@pytest.fixture(scope="module", params=["SummationByParts", "Consistent"])
def operator(request: pytest.FixtureRequest) -> OperatorKind:
    return {"SummationByParts": sph.SummationByParts(), "Consistent": sph.Consistent()}[
        request.param
    ]


@pytest.fixture(scope="module")
def G(mesh: Mesh, operator: OperatorKind) -> Array:
    return gradient(built(mesh, operator))


@pytest.mark.parametrize("unit", [1e-3, 1e3, 0.3048])
def test_in_another_unit(mesh: Mesh, operator: OperatorKind, G: Array, unit: float) -> None:
    other = gradient(built(moved.scaled(mesh, unit), operator))
    assert largest_difference(G, unit * other) < SAME


def test_in_a_mirror(mesh: Mesh, operator: OperatorKind, G: Array) -> None:
    other = gradient(built(moved.mirrored(mesh), operator))
    assert largest_difference(G, other * [-1.0, 1.0, 1.0]) < SAME


def test_with_other_axes(mesh: Mesh, operator: OperatorKind, G: Array) -> None:
    other = gradient(built(moved.turned(mesh), operator))
    assert largest_difference(G[:, :, [1, 2, 0]], other) < SAME


def test_with_other_numbers(mesh: Mesh, operator: OperatorKind, G: Array) -> None:
    order = np.random.default_rng(8).permutation(len(mesh.vertices))
    other = gradient(built(moved.renumbered(mesh, order), operator))
    assert largest_difference(G[np.ix_(order, order)], other) < SAME


@pytest.mark.parametrize("far", [1e4, 1e6])
def test_far_from_the_origin(mesh: Mesh, operator: OperatorKind, far: float) -> None:
    """Against the body whose positions are rounded as they are there, brought back."""
    there = moved.elsewhere(mesh, (far, -far, far))
    back = moved.elsewhere(there, (-far, far, -far))
    G = gradient(built(back, operator))
    assert largest_difference(G, gradient(built(there, operator))) < SAME


def test_volumes_and_centroids_do_not_depend_on_the_place(mesh: Mesh) -> None:
    there = moved.elsewhere(mesh, (1e6, 1e6, -1e6))
    back = moved.elsewhere(there, (-1e6, -1e6, 1e6))
    np.testing.assert_allclose(vertex_volumes(there), vertex_volumes(back), rtol=1e-12)
    volume, centroid = cell_volumes_and_centroids(there)
    there_volume, there_centroid = cell_volumes_and_centroids(back)
    np.testing.assert_allclose(volume, there_volume, rtol=1e-12)
    np.testing.assert_allclose(centroid - [1e6, 1e6, -1e6], there_centroid, atol=1e-9)


@pytest.mark.parametrize("by", [(0.0, 0.0, 4.0), (9.0, -7.0, 0.5)])
def test_two_parts_have_the_operators_of_each_alone(
    mesh: Mesh, operator: OperatorKind, G: Array, by: tuple[float, float, float]
) -> None:
    both = built(dataclasses.replace(moved.twice(mesh, by), is_lattice=False), operator)
    assert parts_of(both.pairs).max() == 1
    n = len(mesh.vertices)
    other = gradient(both)
    assert not np.any(other[:n, n:])
    assert not np.any(other[n:, :n])
    if mesh.is_lattice:  # which confines the change of Consistent to its boundary
        G = gradient(built(dataclasses.replace(mesh, is_lattice=False), operator))
    assert largest_difference(G, other[:n, :n]) < SAME
    assert largest_difference(G, other[n:, n:]) < SAME


def test_the_areas_of_parts_are_those_of_each_alone() -> None:
    mesh = BODIES["disordered"]
    alone = quadratically_exact_areas(mesh)
    both = quadratically_exact_areas(moved.twice(mesh, (5.0, 1.0, 0.0)))
    for name, area in alone.items():
        np.testing.assert_allclose(both[name][: len(area)], area, atol=1e-12)
        np.testing.assert_allclose(both[name][len(area) :], area, atol=1e-12)


@pytest.mark.parametrize(("around", "layers"), [(12, 8), (16, 12)])
def test_a_block_of_flat_cells_with_a_hole_is_ordinary(around: int, layers: int) -> None:
    """What a mesher extrudes: layers of half the width.  The support reaches second neighbours."""
    mesh = moved.block_with_hole(around=around, layers=layers)
    cloud = built(mesh, sph.SummationByParts())
    assert cloud.iterations < 200
    other = built(moved.scaled(mesh, 1e3), sph.SummationByParts())
    assert largest_difference(gradient(cloud), 1e3 * gradient(other)) < SAME
