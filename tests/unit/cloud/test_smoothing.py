"""Smoothing functions: integral one, the stated support, slopes that are derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from sphsolid.cloud import CubicSpline, QuinticSpline, SmoothingFunction, WendlandC2

FUNCTIONS = [CubicSpline(), QuinticSpline(), WendlandC2()]
#: Smallness of a jump in the first derivative that is discontinuous, and its order (C2, C4, C2).
SMOOTH = {"CubicSpline": 2, "QuinticSpline": 4, "WendlandC2": 2}


@pytest.fixture(params=FUNCTIONS, ids=lambda w: type(w).__name__)
def smoothing(request: pytest.FixtureRequest) -> SmoothingFunction:
    return request.param


def radial_integral(smoothing: SmoothingFunction, h: float) -> float:
    """``int W dV`` by Gauss points on each polynomial piece: exact."""
    point, weight = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for piece in range(int(smoothing.support)):
        r = h * (piece + 0.5 * (1.0 + point))
        total += np.sum(0.5 * h * weight * 4.0 * np.pi * r**2 * smoothing.value(r, h))
    return float(total)


@pytest.mark.parametrize("h", [1.0, 0.037, 12.0])
def test_the_integral_is_one(smoothing: SmoothingFunction, h: float) -> None:
    assert radial_integral(smoothing, h) == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("h", [1.0, 0.25])
def test_the_support_is_the_one_stated(smoothing: SmoothingFunction, h: float) -> None:
    edge = smoothing.support * h
    beyond = edge * np.array([1.0, 1.0 + 1e-12, 1.5, 100.0])
    np.testing.assert_array_equal(smoothing.value(beyond, h), 0.0)
    np.testing.assert_array_equal(smoothing.slope(beyond, h), 0.0)
    inside = np.linspace(0.0, 0.999, 500) * edge
    assert np.all(smoothing.value(inside, h) > 0.0)
    assert np.all(smoothing.slope(inside[1:], h) < 0.0)


def test_supports_in_smoothing_lengths() -> None:
    assert [w.support for w in FUNCTIONS] == [2.0, 3.0, 2.0]


@pytest.mark.parametrize("h", [1.0, 0.25])
def test_the_slope_is_the_derivative(smoothing: SmoothingFunction, h: float) -> None:
    r = np.linspace(0.013, smoothing.support * 1.1, 400) * h
    step = 1e-6 * h
    difference = (smoothing.value(r + step, h) - smoothing.value(r - step, h)) / (2.0 * step)
    size = np.max(np.abs(smoothing.slope(r, h)))
    np.testing.assert_allclose(smoothing.slope(r, h), difference, atol=1e-8 * size)
    assert smoothing.slope(np.zeros(1), h)[0] == 0.0


def test_the_pieces_join_smoothly(smoothing: SmoothingFunction) -> None:
    """Values and slopes agree across every joint up to the order that the docstring states."""
    gap = 1e-3
    for joint in range(1, int(smoothing.support) + 1):
        r = joint + gap * np.arange(-4.0, 5.0)
        derivative = smoothing.value(r, 1.0)
        for _ in range(SMOOTH[type(smoothing).__name__]):
            derivative = np.diff(derivative) / gap
        # A jump would show as a difference that does not shrink with the gap.
        assert np.max(np.abs(np.diff(derivative))) < 20.0 * gap


def test_it_scales_with_the_smoothing_length(smoothing: SmoothingFunction) -> None:
    r = np.linspace(0.0, 3.0, 50)
    np.testing.assert_allclose(smoothing.value(0.2 * r, 0.2), smoothing.value(r, 1.0) / 0.2**3)
    np.testing.assert_allclose(smoothing.slope(0.2 * r, 0.2), smoothing.slope(r, 1.0) / 0.2**4)
