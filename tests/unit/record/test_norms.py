"""Norms on fields whose norm is known, and errors of states whose error is known."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.record import PointField, instant_errors, l2_norm, period_errors
from sphsolid.scenes import swinging_cube


def lattice(n):
    """Vertices and tributary volumes of ``n^3`` cells in the unit cube."""
    axis = np.linspace(0.0, 1.0, n + 1)
    weight = np.full(n + 1, 1.0 / n)
    weight[[0, -1]] *= 0.5
    X = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    return X, np.einsum("i,j,k->ijk", weight, weight, weight).ravel()


@pytest.mark.parametrize("n", [1, 2, 5])
def test_exact_where_the_square_is_trilinear(n):
    """Tributary volumes integrate trilinear functions exactly, so ``f^2`` may be one."""
    X, V = lattice(n)
    x, y, z = X.T
    squares = {
        1.0: np.ones_like(x),
        0.5: x,
        2.5: 1.0 + 3.0 * z,
        0.125: x * y * z,
        5.25: 4.0 + x + y * z + 4.0 * x * y * z,
    }
    field = np.stack([np.sqrt(square) for square in squares.values()], axis=1)
    exact = [math.sqrt(integral) for integral in squares]
    np.testing.assert_allclose(l2_norm(PointField(X, V, field)), exact, rtol=1e-14)


@pytest.mark.parametrize("n", [2, 4, 8])
def test_linear_field_has_the_known_quadrature_error(n):
    """The trapezoidal rule gives ``int x^2 = 1/3 + h^2/6``."""
    X, V = lattice(n)
    norm = l2_norm(PointField(X, V, X))
    np.testing.assert_allclose(norm**2, 1.0 / 3.0 + 1.0 / (6.0 * n * n), rtol=1e-13)


def test_shape_follows_the_field():
    X, V = lattice(2)
    assert l2_norm(PointField(X, V, X[:, 0])).shape == ()
    assert l2_norm(PointField(X, V, X)).shape == (3,)
    tensor = np.arange(9.0).reshape(3, 3) * np.ones((len(X), 1, 1))
    norm = l2_norm(PointField(X, V, tensor))
    np.testing.assert_allclose(norm, np.arange(9.0).reshape(3, 3), rtol=1e-14)


@pytest.fixture
def exact_state(make_snapshot):
    scene = swinging_cube(amplitude=1e-3)
    wave, t = scene.exact, 0.2 * scene.exact.period
    X, V = lattice(4)
    snapshot = make_snapshot(
        X,
        V,
        wave.velocity(X, t),
        x=X + wave.displacement(X, t),
        time=t,
        density=scene.material.density,
        P=wave.first_piola(X, t),
    )
    return snapshot, wave


def test_the_exact_state_has_no_error(exact_state):
    errors = instant_errors(*exact_state)
    assert list(errors)[:4] == ["p_x", "p_y", "p_z", "P_xx"]
    assert len(errors) == 12
    assert max(errors.values()) < 1e-14


def test_a_known_error_is_found_in_its_own_component(exact_state):
    snapshot, wave = exact_state
    velocity, P = snapshot.velocity.copy(), snapshot.P.copy()
    velocity[:, 1] += 0.5
    P[:, 2, 0] += 300.0
    errors = instant_errors(dataclasses.replace(snapshot, velocity=velocity, P=P), wave)
    # A constant error c has the norm c on a body of volume one.
    assert errors.pop("p_y") == pytest.approx(snapshot.density * 0.5 / wave.momentum_scale)
    assert errors.pop("P_zx") == pytest.approx(300.0 / wave.stress_scale)
    assert max(errors.values()) < 1e-14


def test_an_error_counts_by_the_volume_it_is_found_in(exact_state):
    """Wrong at the corners alone, which stand for an eighth of an inner particle's volume each."""
    snapshot, wave = exact_state
    corner = np.isclose(snapshot.V, snapshot.V.min())
    assert 8 == np.count_nonzero(corner) < len(corner)
    velocity, P = snapshot.velocity.copy(), snapshot.P.copy()
    velocity[corner, 1] += 0.5
    P[corner, 2, 0] += 300.0
    errors = instant_errors(dataclasses.replace(snapshot, velocity=velocity, P=P), wave)
    share = np.sqrt(np.sum(snapshot.V[corner]))
    assert errors["p_y"] == pytest.approx(
        share * snapshot.density * 0.5 / wave.momentum_scale
    )
    assert errors["P_zx"] == pytest.approx(share * 300.0 / wave.stress_scale)


def test_stress_has_volumes_of_its_own(exact_state):
    snapshot, wave = exact_state
    centroids = np.array([[0.1, 0.5, 0.5], [0.6, 0.5, 0.5]])
    there = dataclasses.replace(
        snapshot,
        stress_X=centroids,
        stress_V=np.array([0.2, 0.8]),
        P=wave.first_piola(centroids, snapshot.time) + np.array([1.0, 3.0])[:, None, None],
    )
    errors = instant_errors(there, wave)
    assert errors["P_xy"] == pytest.approx(math.sqrt(0.2 + 0.8 * 9.0) / wave.stress_scale)


def test_stress_may_live_on_other_points(exact_state):
    snapshot, wave = exact_state
    centroids = np.array([[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]])
    there = dataclasses.replace(
        snapshot,
        stress_X=centroids,
        stress_V=np.array([0.5, 0.5]),
        P=wave.first_piola(centroids, snapshot.time) + np.array([1.0, -1.0])[:, None, None],
    )
    errors = instant_errors(there, wave)
    assert errors["P_xy"] == pytest.approx(1.0 / wave.stress_scale)
    assert errors["p_x"] < 1e-14


def test_period_error_is_a_root_mean_square():
    instants = [{"p_x": float(k), "P_xx": 2.0} for k in range(12)]
    errors = period_errors(iter(instants))
    assert errors["p_x"] == pytest.approx(math.sqrt(506.0 / 12.0))
    assert errors["P_xx"] == pytest.approx(2.0)


@pytest.mark.parametrize("count", [0, 1, 11])
def test_fewer_than_twelve_instants_are_refused(count):
    with pytest.raises(InputError, match=f"got {count}"):
        period_errors([{"p_x": 1.0}] * count)


def test_unknown_field_is_refused(exact_state):
    with pytest.raises(InputError, match="'enthalpy'"):
        exact_state[0].field("enthalpy")
