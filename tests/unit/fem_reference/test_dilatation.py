"""Projections onto continuous Q1 against dense algebra."""

import numpy as np
import pytest

from fem_reference.dilatation import ConsistentMass, LumpedMass
from fem_reference.grid_mass import Grid, NoGrid, grid_of
from fem_reference.quadratic_tables import corner_mass
from sphsolid.errors import InputError
from sphsolid.scenes import Box, l_shaped_block


def matrix_of(option, mass, grid=NoGrid()):
    solve = option.solver(mass, grid)
    return np.stack([solve(column) for column in np.eye(mass.shape[0])], axis=1)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_the_consistent_mass_is_inverted(jitter):
    mass = corner_mass(Box(upper=(1.0, 0.8, 1.2), jitter=jitter).mesh(0.3))
    A = matrix_of(ConsistentMass(), mass)
    np.testing.assert_allclose(A @ mass.toarray(), np.eye(len(A)), atol=1e-11)


def test_lines_of_a_grid_give_the_same_as_the_factorisation():
    mesh = Box(upper=(1.0, 0.5, 1.5)).mesh(0.25)
    grid, mass = grid_of(mesh), corner_mass(mesh)
    assert isinstance(grid, Grid)
    moments = np.random.default_rng(0).normal(size=mass.shape[0])
    found = ConsistentMass().solver(mass, grid)(moments)
    expected = ConsistentMass().solver(mass, NoGrid())(moments)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(mass @ found, moments, atol=1e-13)


def test_what_is_no_box_of_bricks_is_no_grid():
    assert isinstance(grid_of(Box(jitter=0.3).mesh(0.25)), NoGrid)
    assert isinstance(grid_of(l_shaped_block().body.mesh(1.0)), NoGrid)


def test_sweeps_go_from_the_row_sums_to_the_projection_from_below():
    mass = corner_mass(Box(jitter=0.3).mesh(0.5))
    exact = np.linalg.inv(mass.toarray())
    before = matrix_of(LumpedMass(sweeps=0), mass)
    np.testing.assert_allclose(before, np.diag(1.0 / mass.toarray().sum(axis=1)), rtol=1e-14)
    for sweeps in (1, 2, 5):
        A = matrix_of(LumpedMass(sweeps=sweeps), mass)
        size = np.abs(A).max()
        np.testing.assert_allclose(A, A.T, atol=1e-13 * size)
        # Between the last one and the projection, as quadratic forms.
        assert np.linalg.eigvalsh(A - before).min() > -1e-12 * size
        assert np.linalg.eigvalsh(exact - A).min() > -1e-12 * size
        before = A
    far = matrix_of(LumpedMass(sweeps=400), mass)
    np.testing.assert_allclose(far, exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize("option", [ConsistentMass(), LumpedMass(sweeps=0), LumpedMass(sweeps=3)])
def test_a_uniform_dilatation_is_reproduced(option):
    mass = corner_mass(Box(jitter=0.4).mesh(0.25))
    moments = 0.3 * np.asarray(mass.sum(axis=1)).ravel()
    np.testing.assert_allclose(option.solver(mass, NoGrid())(moments), 0.3, rtol=1e-12)


@pytest.mark.parametrize("sweeps", [-1, 0.5])
def test_wrong_sweeps_are_refused(sweeps):
    with pytest.raises(InputError, match="whole number"):
        LumpedMass(sweeps=sweeps)
