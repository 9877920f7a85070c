"""The coarse solution: a pseudo-inverse on the splines, whatever the shape of the grid."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.lengths import Uniform
from sphsolid.cloud.skew_problem import SkewProblem, in_lanes
from sphsolid.cloud.splines.coarse_solution import CoarseSolution
from sphsolid.cloud.splines.spline_matrix import particle_matrix, skew_matrix
from sphsolid.cloud.splines.spline_space import MOST_COARSE, Splines, coarse_splines
from sphsolid.geometry import Box

#: The longest side along each axis in turn, and a plate of one cell.
SHAPES = [(1.2, 0.7, 0.5), (0.5, 1.2, 0.7), (0.5, 0.7, 1.2), (0.9, 0.9, 0.1), (0.9, 0.9, 0.9)]


def skew_problem(upper: tuple[float, float, float]) -> SkewProblem:
    X = Box(upper=upper, jitter=0.4, seed=2).mesh(0.1).vertices / 0.1
    pairs = Uniform(1.0, 1.0).pairs(X, X, sph.WendlandC2().support)
    random = np.random.default_rng(0).uniform(0.5, 1.0, len(X))
    weights = random[pairs.row_of_pair] * random[pairs.indices]
    return SkewProblem(pairs, X, weights, np.full(len(X), 0.05))


@pytest.mark.parametrize("upper", SHAPES)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_it_inverts_the_matrix_beside_its_null_space(
    upper: tuple[float, float, float], dtype: type
) -> None:
    problem = skew_problem(upper)
    splines = Splines(problem.X, 2.5)
    blocks = problem.blocks()
    matrix = skew_matrix(problem, splines, blocks)
    dense = matrix.dense()
    null = splines.linears()  # quadratics have curvatures, on which epsilon acts
    size = np.max(np.abs(dense))
    assert np.max(np.abs(dense @ null)) < 1e-12 * size
    root = np.sqrt(np.diagonal(dense))
    coarse = CoarseSolution(splines, matrix, null, shift=1e-9, dtype=dtype)
    exact = np.random.default_rng(1).normal(size=(splines.size, 3))
    right = dense @ exact
    back = dense @ coarse.solve(right)
    error = np.max(np.abs((back - right) / root[:, None]))
    # What is added to the diagonal shows in the functions that hardly reach a particle.
    allowed = 1e-6 if dtype is np.float64 else 2e-3
    assert error < allowed * np.max(np.abs(right / root[:, None]))


def test_it_is_symmetric_and_never_negative() -> None:
    problem = skew_problem((0.9, 0.6, 0.7))
    splines = Splines(problem.X, 3.0)
    coarse = CoarseSolution(
        splines, skew_matrix(problem, splines, problem.blocks()), splines.linears(), shift=1e-9
    )
    M = np.empty((splines.size, splines.size))
    for k in range(0, splines.size, 3):
        unit = np.zeros((splines.size, 3))
        columns = np.arange(k, min(k + 3, splines.size))
        unit[columns, columns - k] = 1.0
        M[:, columns] = coarse.solve(unit)[:, : len(columns)]
    size = np.max(np.abs(M))
    np.testing.assert_allclose(M, M.T, atol=1e-9 * size)
    values = np.linalg.eigvalsh(0.5 * (M + M.T))
    assert values[0] > -1e-9 * values[-1]


def test_blocks_on_the_diagonal_are_gathered() -> None:
    """``P^T S P`` of any blocks, by evaluating the splines one by one."""
    X = Box(upper=(0.5, 0.6, 0.4), jitter=0.3, seed=4).mesh(0.1).vertices / 0.1
    splines = Splines(X, 3.0)
    random = np.random.default_rng(5)
    half = random.normal(size=(len(X), 10, 10))
    blocks = half @ half.transpose(0, 2, 1)
    values = np.zeros((splines.size, len(X), 10))
    for k in range(splines.size):
        unit, out = np.zeros((splines.size, 3)), np.zeros((len(X), 10, 3))
        unit[k, 0] = 1.0
        splines.prolong(unit, out)
        values[k] = out[:, :, 0]
    exact = np.einsum("kam,amn,lan->kl", values, blocks, values, optimize=True)
    found = particle_matrix(splines, blocks).dense()
    np.testing.assert_allclose(found, exact, atol=1e-12 * np.max(exact))


def test_pairs_of_cells_far_apart_are_gathered() -> None:
    """A grid finer than the support: pairs reach over more than one cell."""
    problem = skew_problem((0.6, 0.5, 0.4))
    splines = Splines(problem.X, 0.7)
    found = skew_matrix(problem, splines, problem.blocks())
    c = np.random.default_rng(6).normal(size=(splines.size, 3))
    fine, back = np.zeros((len(problem.X), 10, 3)), np.empty_like(c)
    splines.prolong(c, fine)
    lanes = np.empty((len(problem.X), 10, 4))
    problem.apply(in_lanes(fine), lanes)
    applied = np.ascontiguousarray(lanes[:, :, :3])
    splines.restrict(applied, back)
    np.testing.assert_allclose(found.dense() @ c, back, atol=1e-11 * np.max(np.abs(back)))


def test_a_large_body_gets_a_coarser_grid() -> None:
    """No more functions than fit, however many spacings there are."""
    X = np.random.default_rng(7).uniform(size=(100, 3)) * [1.0, 1.0, 8.0]
    few = coarse_splines(X / 0.2, 2.5)
    assert 0.2 * few.edge == pytest.approx(np.ptp(X, axis=0) / np.ceil(np.ptp(X, axis=0) / 0.5))
    many = coarse_splines(X / 0.01, 2.5)
    assert 0.5 * MOST_COARSE < many.size <= MOST_COARSE
