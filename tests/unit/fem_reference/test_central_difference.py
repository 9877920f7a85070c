"""The time integrator alone: order, bounded energy, essential conditions."""

import numpy as np
import pytest
from numpy.typing import NDArray

from fem_reference.central_difference import Motion, central_difference_step
from fem_reference.energy_budget import NoBudget
from fem_reference.essential import EssentialConditions
from sphsolid.scenes import Box, Constraint

Array = NDArray[np.float64]
FREE = EssentialConditions.of((), Box().mesh(1.0))


def oscillate(steps: int, end: float = 5.0) -> tuple[float, float]:
    """Unit oscillator from ``x = 1``: position error at the end, largest energy error."""

    def accelerate(x: Array, t: float, a: Array) -> None:
        np.negative(x, out=a)

    x, v, a = np.ones((1, 3)), np.zeros((1, 3)), -np.ones((1, 3))
    dt = end / steps
    drift = 0.0
    for n in range(steps):
        central_difference_step(
            Motion(x, v, a), t=n * dt, dt=dt, accelerate=accelerate, essential=FREE,
            budget=NoBudget(),
        )  # fmt: skip
        drift = max(drift, abs(float(x[0, 0] ** 2 + v[0, 0] ** 2) - 1.0))
    return abs(float(x[0, 0]) - np.cos(end)), drift


def test_second_order_and_bounded_energy() -> None:
    coarse, fine = oscillate(100), oscillate(200)
    assert np.log2(coarse[0] / fine[0]) == pytest.approx(2.0, abs=0.01)
    assert np.log2(coarse[1] / fine[1]) == pytest.approx(2.0, abs=0.01)
    # Ten times longer: the energy error does not grow.
    assert oscillate(1000, end=50.0)[1] < 1.01 * coarse[1]


def test_conditions_hold_exactly_and_leave_other_components_alone() -> None:
    mesh = Box().mesh(0.25)
    conditions = EssentialConditions.of(
        (
            Constraint("X-", "normal"),
            Constraint("Z+", "tangential"),
            Constraint("X+", "all", lambda X, t: np.stack([t + X[:, 1], -X[:, 2], 0 * X[:, 0]], 1)),
        ),
        mesh,
    )
    before = np.random.default_rng(0).normal(size=mesh.vertices.shape)
    v = before.copy()
    conditions.apply(v, 2.0)
    X = mesh.vertices
    left, right, top = X[:, 0] == 0.0, X[:, 0] == 1.0, X[:, 2] == 1.0
    assert np.all(v[left, 0] == 0.0)
    assert np.all(v[top & ~right, :2] == 0.0)
    np.testing.assert_array_equal(v[left & ~top, 1:], before[left & ~top, 1:])
    np.testing.assert_array_equal(v[top & ~right, 2], before[top & ~right, 2])
    free = ~(left | right | top)
    np.testing.assert_array_equal(v[free], before[free])
    driven = right & ~top
    np.testing.assert_array_equal(v[driven, 0], 2.0 + X[driven, 1])
    np.testing.assert_array_equal(v[driven, 1], -X[driven, 2])
    # On the shared edge the tangential roller came first; only the normal direction is left.
    np.testing.assert_array_equal(v[right & top], [[0.0, 0.0, 0.0]] * 5)
