"""Secondary particles: where they sit, how much volume they carry, how they couple."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, build_secondary
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.scenes import Box
from tests.oracles.dense import dense

Array = NDArray[np.float64]
BOX = (1.0, 0.8, 1.2)
VOLUME = 0.96


@pytest.mark.parametrize("jitter", [0.0, 0.4])
@pytest.mark.parametrize(("points", "per_cell"), [(sph.H1(), 1), (sph.H6(), 6)])
def test_volumes_are_positive_and_fill_the_body(
    points: Any, per_cell: int, jitter: float
) -> None:
    """Exactly, disordered or not: the tetrahedra of neighbouring cells share their faces."""
    mesh = Box(upper=BOX, jitter=jitter, seed=6).mesh(0.2)
    X, V = points.place(mesh)
    assert len(X) == len(V) == per_cell * len(mesh.cells)
    assert np.all(V > 0.0)
    assert np.sum(V) == pytest.approx(VOLUME, rel=1e-13)
    np.testing.assert_allclose(V @ X, VOLUME * np.array([0.5, 0.4, 0.6]), rtol=1e-12)


def test_h1_sits_at_the_centroids() -> None:
    mesh = Box(upper=BOX, jitter=0.4).mesh(0.2)
    X, V = sph.H1().place(mesh)
    volume, centroid = cell_volumes_and_centroids(mesh)
    np.testing.assert_array_equal(X, centroid)
    np.testing.assert_array_equal(V, volume)
    lattice = Box(upper=BOX).mesh(0.2)
    X, V = sph.H1().place(lattice)
    np.testing.assert_allclose(X, lattice.vertices[lattice.cells].mean(axis=1), atol=1e-15)
    np.testing.assert_allclose(V, 0.2**3, rtol=1e-12)


def test_h6_of_a_cube_is_the_six_orders_of_its_coordinates() -> None:
    """Kuhn's split: tetrahedron ``1 >= X_i >= X_j >= X_k >= 0`` for every order of the axes."""
    X, V = sph.H6().place(Box().mesh(1.0))
    np.testing.assert_allclose(V, 1.0 / 6.0, rtol=1e-14)
    expected = {(0.25, 0.5, 0.75), (0.25, 0.75, 0.5), (0.5, 0.25, 0.75)}
    expected |= {(0.5, 0.75, 0.25), (0.75, 0.25, 0.5), (0.75, 0.5, 0.25)}
    assert {tuple(np.round(x, 12)) for x in X} == expected


@pytest.mark.parametrize("points", [sph.H1(), sph.H6()], ids=lambda p: p.name)
def test_spread_is_the_adjoint_of_sample(make_cloud: Callable[..., Cloud], points: Any) -> None:
    """``V_a spread_aq = V_q G_a(X_q)``: what the dissipation conserves rests on it."""
    cloud = make_cloud(jitter=0.4)
    q = build_secondary(cloud, points)
    G = dense(q.pairs, q.sample, cloud.size)[:, :, :3]
    spread = dense(q.spread_pairs, q.spread, len(q.X))
    scaled = cloud.V[:, None, None] * spread
    np.testing.assert_allclose(scaled, np.swapaxes(q.V[:, None, None] * G, 0, 1), rtol=1e-12)


def test_a_checkerboard_is_seen_by_h6_alone(make_cloud: Callable[..., Cloud]) -> None:
    """``(-1)^(i+j+k)`` has no gradient at the centroids of inner hexahedra."""
    cloud = make_cloud()
    steps = np.rint(cloud.X / cloud.spacing).astype(int)
    sign = (-1.0) ** np.sum(steps, axis=1)

    def largest(points: Any) -> float:
        q = build_secondary(cloud, points)
        G = dense(q.pairs, q.sample, cloud.size)[:, :, :3]
        inner = np.all(np.minimum(q.X, np.array(BOX) - q.X) > 0.2, axis=1)
        return float(np.max(np.abs(np.einsum("a,qak->qk", sign, G[inner])))) * cloud.spacing

    assert largest(sph.H1()) < 1e-12
    assert largest(sph.H6()) > 0.1


def test_h6_refuses_a_tetrahedron_inside_out() -> None:
    """Strong disorder can turn one over while its hexahedron, and H1, are still sound."""
    mesh = Box(jitter=0.8, seed=1).mesh(0.125)
    assert np.all(sph.H1().place(mesh)[1] > 0.0)
    with pytest.raises(InputError, match=r"tetrahedron of cell \d+ .* H1\(\)"):
        sph.H6().place(mesh)
