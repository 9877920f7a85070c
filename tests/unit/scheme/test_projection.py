"""The local angular-momentum projection is the least change that removes the torque."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from sphsolid.continuum.tensor import (
    Tensor,
    add,
    axial,
    join,
    multiply,
    scale,
    solve_symmetric,
    split,
    transpose,
    vector_cross,
)
from sphsolid.scheme.projection import project
from tests.oracles import numpy_sph

Array = NDArray[np.float64]
RANDOM = np.random.default_rng(31)
P = RANDOM.normal(size=(200, 3, 3))
F_X = np.eye(3) + 0.4 * RANDOM.uniform(-1.0, 1.0, (200, 3, 3))


def torque(P: Array, F_x: Array) -> float:
    """Largest skew part of ``P F_x^T`` relative to its size."""
    kirchhoff = P @ np.swapaxes(F_x, 1, 2)
    skew = kirchhoff - np.swapaxes(kirchhoff, 1, 2)
    return float(np.max(np.abs(skew)) / np.max(np.abs(kirchhoff)))


def projected(P: Array, F_x: Array, by: Callable[[Tensor, Tensor], Tensor] = project) -> Array:
    return np.asarray(join(by(split(P), split(F_x))))


def test_the_projected_stress_makes_no_torque() -> None:
    assert torque(P, F_X) > 0.5
    assert torque(projected(P, F_X), F_X) < 1e-14


def test_the_minus_sign_fails() -> None:
    """``P - lambda x F``, a slip that is easily made, doubles the torque."""

    def wrong(P: Tensor, F_x: Tensor) -> Tensor:
        b = multiply(F_x, transpose(F_x))
        L = add(scale(b[0] + b[4] + b[8], (1, 0, 0, 0, 1, 0, 0, 0, 1)), scale(-1.0, b))
        multiplier = solve_symmetric(L, axial(multiply(P, transpose(F_x))))
        return add(P, scale(-1.0, vector_cross(multiplier, F_x)))

    assert torque(projected(P, F_X, wrong), F_X) > 0.5


def test_the_change_is_the_least_of_all() -> None:
    """Orthogonal to every stress that makes no torque, hence shorter than any other change."""
    change = projected(P, F_X) - P
    # All Q with Q F_x^T symmetric: Q = S F_x^-T.
    S = RANDOM.normal(size=P.shape)
    Q = (S + np.swapaxes(S, 1, 2)) @ np.swapaxes(np.linalg.inv(F_X), 1, 2)
    work = np.einsum("nij,nij->n", change, Q)
    size = np.linalg.norm(change, axis=(1, 2)) * np.linalg.norm(Q, axis=(1, 2))
    assert np.max(np.abs(work) / size) < 1e-13
    for step in (-0.1, 0.1):
        other = np.linalg.norm(change + step * Q, axis=(1, 2))
        assert np.all(other > np.linalg.norm(change, axis=(1, 2)))


def test_it_agrees_with_a_projection_by_linear_algebra() -> None:
    np.testing.assert_allclose(projected(P, F_X), numpy_sph.project(P, F_X), atol=1e-13)


def test_a_stress_without_torque_is_left_alone() -> None:
    S = RANDOM.normal(size=P.shape)
    symmetric = (S + np.swapaxes(S, 1, 2)) @ np.swapaxes(np.linalg.inv(F_X), 1, 2)
    size = np.max(np.abs(symmetric))
    np.testing.assert_allclose(projected(symmetric, F_X), symmetric, atol=1e-14 * size)
    once = projected(P, F_X)
    np.testing.assert_allclose(projected(once, F_X), once, atol=1e-14)


@pytest.mark.parametrize("factor", [1e-6, 1e9])
def test_it_is_linear_in_the_stress(factor: float) -> None:
    np.testing.assert_allclose(
        projected(factor * P, F_X), factor * projected(P, F_X), rtol=1e-12, atol=1e-14 * factor
    )
