"""d'Alembert's solution of the cable, checked against itself and against known numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.scenes import Pulse, Step, cable

C, PERIOD = 5000.0, 8.0e-3
#: Points along the bar, off the places where the step's wave is at the times below.
X = np.stack([np.linspace(0.05, 9.95, 34), np.full(34, 0.3), np.full(34, 0.7)], axis=1)


@pytest.mark.parametrize(
    ("time", "wall", "free_end"),
    [(1e-3, 0.0, 1.0), (3e-3, 2.0, 1.0), (5e-3, 2.0, 1.0), (7e-3, 0.0, 1.0), (9e-3, 0.0, 1.0)],
)
def test_stress_doubles_at_the_wall(time, wall, free_end):
    """From L/c to 3 L/c = 2 to 6 ms; the free end carries the traction at all times."""
    wave = cable().known_solution()
    ends = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    P = wave.first_piola(ends, time)
    np.testing.assert_allclose(P[:, 0, 0], [5e7 * wall, 5e7 * free_end], rtol=1e-12)
    assert np.count_nonzero(P) == np.count_nonzero(P[:, 0, 0])
    np.testing.assert_array_equal(wave.displacement(ends, time)[0], 0.0)
    np.testing.assert_array_equal(wave.velocity(ends, time)[0], 0.0)


def test_the_wave_in_numbers():
    """At 1 ms the front is in the middle, with 1.25 m/s behind it."""
    wave = cable().known_solution()
    assert (wave.speed, wave.period) == (C, PERIOD)
    P, v = wave.first_piola(X, 1e-3)[:, 0, 0], wave.velocity(X, 1e-3)
    behind = X[:, 0] > 5.0
    np.testing.assert_allclose(P, np.where(behind, 5e7, 0.0))
    np.testing.assert_allclose(v[:, 0], np.where(behind, 1.25, 0.0))
    np.testing.assert_array_equal(v[:, 1:], 0.0)
    # The free end goes out at 1.25 m/s for half a period, to 5 mm, and comes back.
    end = np.array([[10.0, 0.0, 0.0]])
    out = [wave.displacement(end, t)[0, 0] for t in (0.0, 2e-3, 4e-3, 6e-3, 8e-3)]
    np.testing.assert_allclose(out, [0.0, 2.5e-3, 5e-3, 2.5e-3, 0.0], atol=1e-15)


@pytest.mark.parametrize("load", [Step(), Pulse(), Pulse(duration=5e-3)])
@pytest.mark.parametrize("time", [0.33e-3, 2.77e-3, 5.83e-3, 11.29e-3])
def test_velocity_and_strain_are_derivatives_of_displacement(load, time):
    wave = cable(load=load).known_solution()
    d = 1e-7
    v = (wave.displacement(X, time + d) - wave.displacement(X, time - d)) / (2 * d)
    np.testing.assert_allclose(wave.velocity(X, time), v, atol=2e-6)
    step = np.array([1e-3, 0.0, 0.0])
    gradient = wave.displacement(X + step, time) - wave.displacement(X - step, time)
    strain = wave.deformation_gradient(X, time) - np.eye(3)
    np.testing.assert_allclose(strain[:, 0, 0], gradient[:, 0] / 2e-3, atol=2e-9)
    np.testing.assert_allclose(wave.first_piola(X, time), 2e11 * strain, rtol=1e-9, atol=1e-3)
    assert np.count_nonzero(strain[:, 1:]) == np.count_nonzero(strain[:, 0, 1:]) == 0


@pytest.mark.parametrize("time", [0.5e-3, 2.9e-3, 7.1e-3])
def test_the_wave_comes_back_after_a_period(time):
    for load in (Step(), Pulse()):
        wave = cable(load=load).known_solution()
        later = max(time, 2.1e-3)  # the pulse is over: s(t) repeats only as zero
        np.testing.assert_allclose(
            wave.velocity(X, later + PERIOD), wave.velocity(X, later), atol=1e-9
        )


def test_pulse_ends_smoothly_and_holds_three_eighths():
    pulse = Pulse(duration=2e-3)
    t = np.linspace(-1e-3, 4e-3, 5001)
    s = pulse.value(t)
    assert s.max() == pytest.approx(1.0)
    np.testing.assert_array_equal(s[(t < 0) | (t > 2e-3)], 0.0)
    np.testing.assert_allclose(pulse.integral(np.array([-1.0, 2e-3, 1.0])), [0, 7.5e-4, 7.5e-4])
    np.testing.assert_allclose(np.gradient(pulse.integral(t), t), s, atol=5e-6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"load": "step"},
        {"stress": 0.0},
        {"stress": math.nan},
        {"stress": 3e9},
        {"width": 0.0},
        {"length": math.inf},
    ],
)
def test_bad_input_is_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        cable(**wrong)


def test_a_pulse_needs_a_duration():
    with pytest.raises(InputError, match="duration"):
        Pulse(duration=0.0)
