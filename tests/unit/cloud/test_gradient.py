"""The two gradient kinds: what they reproduce, and what they are made of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, build_secondary
from sphsolid.cloud.gradient import (
    corrected_gradient,
    linear_interpolation,
    linear_kernel_gradient,
    row_sum,
)
from sphsolid.cloud.pairs.neighbours import pairs_within
from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.scenes import Box
from tests.oracles.dense import dense

Array = NDArray[np.float64]
MakeCloud = Callable[..., Cloud]
KINDS = {"corrected_kernel": corrected_gradient, "linear_kernel": linear_kernel_gradient}
GRADIENT = np.array([[1.0, -2.0, 0.5], [0.3, 4.0, -1.0], [2.0, 0.7, -3.0]])


def linear(X: Array) -> Array:
    """A linear vector field with gradient ``GRADIENT``."""
    return X @ GRADIENT.T + [5.0, -7.0, 11.0]


@pytest.mark.parametrize("smoothing", [sph.WendlandC2(), sph.CubicSpline(), sph.QuinticSpline()])
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_constants_and_linears_are_exact_at_the_particles(
    make_cloud: MakeCloud, jitter: float, kind: Any, smoothing: Any
) -> None:
    cloud = make_cloud(jitter=jitter, operator=sph.Literal(gradient=kind), smoothing=smoothing)
    G = cloud.gradients.kinematic
    assert cloud.gradients.is_adjoint
    C0 = row_sum(cloud.pairs, G)
    C1 = row_sum(cloud.pairs, cloud.X[cloud.pairs.indices][:, :, None] * G[:, None, :])
    assert np.max(np.abs(C0)) * cloud.spacing < 1e-12
    assert np.max(np.abs(C1 - np.eye(3))) < 1e-12
    f = linear(cloud.X)[cloud.pairs.indices]
    found = row_sum(cloud.pairs, f[:, :, None] * G[:, None, :])
    np.testing.assert_allclose(found, np.broadcast_to(GRADIENT, found.shape), atol=1e-11)


@pytest.mark.parametrize("points", [sph.H1(), sph.H6()], ids=lambda p: p.name)
@pytest.mark.parametrize("jitter", [0.0, 0.2, 0.4])
def test_linears_are_exact_at_the_secondary_particles(
    make_cloud: MakeCloud, jitter: float, points: Any
) -> None:
    cloud = make_cloud(jitter=jitter)
    q = build_secondary(cloud, points)
    f = linear(cloud.X)[q.pairs.indices]
    found = row_sum(q.pairs, f[:, :, None] * q.sample[:, None, :3])
    np.testing.assert_allclose(found, np.broadcast_to(GRADIENT, found.shape), atol=1e-11)


@pytest.mark.parametrize("upper", [(1.0, 1.0, 1.0), (1.0, 0.9, 1.15)])
def test_at_an_inner_cell_centre_it_is_the_one_point_hexahedron(
    upper: tuple[float, float, float],
) -> None:
    """Eight neighbours of equal volume: ``G_b = dN_b/dX`` of the trilinear element, no more."""
    mesh = Box(upper=upper).mesh(0.2)
    cloud = sph.cloud.build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=0.75, operator=sph.Literal()
    )
    q = build_secondary(cloud, sph.H1())
    boundary = np.unique(mesh.boundary)
    inner = np.flatnonzero(~np.isin(mesh.cells, boundary).any(axis=1))
    assert len(inner) >= 18
    sample = dense(q.pairs, q.sample, cloud.size)
    edge = mesh.vertices[mesh.cells[:, 6]] - mesh.vertices[mesh.cells[:, 0]]
    for cell in inner:
        assert np.count_nonzero(sample[cell, :, 3]) == 8
        expected = (2.0 * CORNERS - 1.0) / (4.0 * edge[cell])
        np.testing.assert_allclose(sample[cell, mesh.cells[cell], :3], expected, rtol=1e-12)
        np.testing.assert_allclose(sample[cell, mesh.cells[cell], 3], 0.125, rtol=1e-12)


def by_hand(cloud: Cloud, a: int) -> Array:
    """Eq. (30) at particle ``a``, particle by particle, as the module text defines it."""
    near = cloud.pairs.indices[cloud.pairs.indptr[a] : cloud.pairs.indptr[a + 1]]
    S, sum_grad = 0.0, np.zeros(3)
    W, grad = {}, {}
    for b in near:
        d = cloud.X[a] - cloud.X[b]
        r = np.linalg.norm(d)
        W[b] = cloud.smoothing.value(np.array([r]), cloud.h)[0]
        slope = cloud.smoothing.slope(np.array([r]), cloud.h)[0]
        grad[b] = slope * d / r if r > 0.0 else np.zeros(3)
        S += cloud.V[b] * W[b]
        sum_grad += cloud.V[b] * grad[b]
    shepard = {b: (grad[b] - W[b] * sum_grad / S) / S for b in near}
    moment = sum((cloud.V[b] * np.outer(shepard[b], cloud.X[b]) for b in near), np.zeros((3, 3)))
    L = np.linalg.inv(moment)
    return np.array([cloud.V[b] * L @ shepard[b] for b in near])


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_the_corrected_kernel_is_eq_30(make_cloud: MakeCloud, jitter: float) -> None:
    cloud = make_cloud(jitter=jitter)
    for a in (0, 7, 95, cloud.size - 1):
        rows = slice(cloud.pairs.indptr[a], cloud.pairs.indptr[a + 1])
        np.testing.assert_allclose(cloud.gradients.force[rows], by_hand(cloud, a), atol=1e-11)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_the_linear_kernel_is_the_derivative_of_the_interpolation(
    make_cloud: MakeCloud, jitter: float
) -> None:
    """Central differences of the linear-corrected kernel itself, at particles and between."""
    cloud = make_cloud(jitter=jitter)
    random = np.random.default_rng(3)
    points = np.concatenate([cloud.X[::7], random.uniform(0.1, 0.7, (30, 3))])
    # Pairs of a wider radius, so that the list does not change while a point is moved.
    pairs = pairs_within(points, cloud.X, 1.05 * cloud.smoothing.support * cloud.h)
    common = (cloud.X, cloud.V, pairs, cloud.smoothing, cloud.h)
    G = linear_kernel_gradient(points, *common)
    step = 1e-6 * cloud.spacing
    for k in range(3):
        shift = step * np.eye(3)[k]
        ahead = linear_interpolation(points + shift, *common)
        behind = linear_interpolation(points - shift, *common)
        difference = (ahead - behind) / (2.0 * step)
        np.testing.assert_allclose(G[:, k], difference, atol=1e-7 * np.max(np.abs(G)))


def test_the_two_kinds_differ_where_neighbours_are_not_symmetric(make_cloud: MakeCloud) -> None:
    one, other = (
        make_cloud(jitter=0.4, operator=sph.Literal(gradient=kind)).gradients.force
        for kind in KINDS
    )
    assert np.max(np.abs(one - other)) > 0.05 * np.max(np.abs(one))


@pytest.mark.parametrize("kind", list(KINDS))
def test_it_does_not_lose_digits_far_from_the_origin(make_cloud: MakeCloud, kind: str) -> None:
    cloud = make_cloud(jitter=0.4)
    rest = (cloud.V, cloud.pairs, cloud.smoothing, cloud.h)
    near = KINDS[kind](cloud.X, cloud.X, *rest)
    far = cloud.X + 1000.0
    np.testing.assert_allclose(KINDS[kind](far, far, *rest), near, atol=1e-9 * np.max(np.abs(near)))


def test_an_unknown_kind_is_refused(make_cloud: MakeCloud) -> None:
    with pytest.raises(InputError, match=r"'least_squares'.*corrected_kernel"):
        make_cloud(operator=sph.Literal(gradient="least_squares"))  # type: ignore[arg-type]
