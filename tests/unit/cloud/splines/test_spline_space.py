"""The coarse space of splines: transpose, exactness, and its matrix."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud.lengths import Uniform
from sphsolid.cloud.skew_problem import SkewProblem, in_lanes
from sphsolid.cloud.splines.spline_matrix import skew_matrix
from sphsolid.cloud.splines.spline_space import Splines
from sphsolid.geometry import Box

MESH = Box(upper=(1.0, 0.7, 0.9), jitter=0.4, seed=2).mesh(0.1)
Array = NDArray[np.float64]
#: In units of the spacing.
X = MESH.vertices / 0.1


@pytest.fixture(scope="module")
def splines() -> Splines:
    return Splines(X, 3.0)


@pytest.fixture(scope="module")
def problem() -> SkewProblem:
    pairs = Uniform(1.0, 1.0).pairs(X, X, sph.WendlandC2().support)
    random = np.random.default_rng(0).uniform(0.5, 1.0, len(X))
    weights = random[pairs.row_of_pair] * random[pairs.indices]
    return SkewProblem(pairs, X, weights, np.linspace(0.05, 0.2, len(X)))


def applied(problem: SkewProblem, multipliers: Array) -> Array:
    out = np.empty((len(multipliers), 10, 4))
    problem.apply(in_lanes(multipliers), out)
    return np.ascontiguousarray(out[:, :, :3])


def test_restriction_is_the_transpose_of_prolongation(splines: Splines) -> None:
    random = np.random.default_rng(1)
    coefficients, z = random.normal(size=(splines.size, 3)), random.normal(size=(len(X), 10, 3))
    fine, coarse = np.zeros_like(z), np.empty_like(coefficients)
    splines.prolong(coefficients, fine)
    splines.restrict(z, coarse)
    np.testing.assert_allclose(
        np.einsum("nic,nic->c", fine, z), np.einsum("nc,nc->c", coefficients, coarse), rtol=1e-11
    )


def test_a_cubic_is_evaluated_with_half_its_slope_and_a_sixth_of_its_curvature(
    splines: Splines,
) -> None:
    """Interpolate ``x^2 y`` at the particles by least squares: the splines hold it exactly."""
    columns = np.zeros((len(X), splines.size))
    for k in range(0, splines.size, 3):
        unit, out = np.zeros((splines.size, 3)), np.zeros((len(X), 10, 3))
        for c in range(min(3, splines.size - k)):
            unit[k + c, c] = 1.0
        splines.prolong(unit, out)
        for c in range(min(3, splines.size - k)):
            columns[:, k + c] = out[:, 0, c]
    x, y = X[:, 0], X[:, 1]
    solution = np.linalg.lstsq(columns, x**2 * y, rcond=None)[0]
    assert np.max(np.abs(columns @ solution - x**2 * y)) < 1e-11 * 10**3
    out = np.zeros((len(X), 10, 3))
    splines.prolong(np.repeat(solution[:, None], 3, axis=1), out)
    exact = [x**2 * y, x * y, x**2 / 2, 0 * x, y / 3, 0 * x, 0 * x, x / 3]
    for entry, values in enumerate(exact):
        np.testing.assert_allclose(out[:, entry, 1], values, atol=1e-8 * 10**3)


def test_the_quadratics_are_in_the_space(splines: Splines) -> None:
    basis = splines.quadratics()
    np.testing.assert_allclose(basis.T @ basis, np.eye(10), atol=1e-12)
    powers = [np.ones(len(X)), *X.T, *(X**2).T, X[:, 0] * X[:, 1], X[:, 0] * X[:, 2]]
    values = np.zeros((len(X), 10))
    for k in range(10):
        out = np.zeros((len(X), 10, 3))
        splines.prolong(np.repeat(basis[:, k : k + 1], 3, axis=1), out)
        values[:, k] = out[:, 0, 0]
    for power in [*powers, X[:, 1] * X[:, 2]]:
        fit = values @ np.linalg.lstsq(values, power, rcond=None)[0]
        np.testing.assert_allclose(fit, power, atol=1e-11 * 10**2)


def test_the_coarse_matrix_is_the_one_of_the_system(splines: Splines, problem: SkewProblem) -> None:
    """``P^T K P`` column by column."""
    matrix = skew_matrix(problem, splines, problem.blocks()).dense()
    random = np.random.default_rng(3)
    c = random.normal(size=(splines.size, 3))
    fine = np.zeros((len(X), 10, 3))
    splines.prolong(c, fine)
    back = np.empty_like(c)
    splines.restrict(applied(problem, fine), back)
    np.testing.assert_allclose(matrix @ c, back, atol=1e-11 * np.max(np.abs(back)))


def test_the_system_vanishes_on_quadratics_and_is_symmetric(problem: SkewProblem) -> None:
    """``s, grad s / 2`` of a quadratic is its null space."""
    z = np.zeros((len(X), 10, 3))
    z[:, 0] = (X[:, 0] * X[:, 1] + X[:, 2] ** 2)[:, None]
    gradient = np.stack([X[:, 1], X[:, 0], 2.0 * X[:, 2]], axis=1)
    z[:, 1:4] = 0.5 * gradient[:, :, None]
    assert np.max(np.abs(applied(problem, z))) < 1e-11
    random = np.random.default_rng(4)
    u, v = random.normal(size=(2, len(X), 10, 3))
    Ku, Kv = applied(problem, u), applied(problem, v)
    assert np.sum(v * Ku) == pytest.approx(np.sum(u * Kv), rel=1e-11)
    assert np.sum(u * Ku) > 0.0
