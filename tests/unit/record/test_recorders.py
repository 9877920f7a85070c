"""Recorders against numbers worked out by hand for two particles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.record import (
    AngularMomentum,
    Energy,
    Errors,
    LinearMomentum,
    Probe,
    angular_momentum,
    instant_errors,
    linear_momentum,
)
from sphsolid.scenes import swinging_cube

SCENE = swinging_cube()


@pytest.fixture
def two(make_snapshot):
    """Density 2; volumes 1 and 3; moved by (0, 0, 1) and (0, 1, 0)."""
    X = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    x = X + np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    velocity = np.array([[0.0, 3.0, 4.0], [1.0, 0.0, 0.0]])
    return make_snapshot(X, np.array([1.0, 3.0]), velocity, x=x, energy=7.5)


def test_energy(two):
    # Kinetic: 2/2 (1 * 25 + 3 * 1).
    row = Energy().record(two, SCENE)
    assert row == {
        "kinetic_energy [J]": 28.0,
        "strain_energy [J]": 7.5,
        "total_energy [J]": 35.5,
    }


def test_linear_momentum(two):
    # V p: 1 * 2 (0, 3, 4) + 3 * 2 (1, 0, 0).
    np.testing.assert_array_equal(linear_momentum(two), [6.0, 6.0, 8.0])
    row = LinearMomentum().record(two, SCENE)
    assert list(row.values()) == [6.0, 6.0, 8.0, 16.0]
    names = [f"linear_momentum_{what} [kg m/s]" for what in ("x", "y", "z", "scale")]
    assert list(row) == names


def test_angular_momentum(two):
    # Present positions (1, 0, 1) and (0, 3, 0):
    # (1, 0, 1) x (0, 6, 8) = (-6, -8, 6);  (0, 3, 0) x (6, 0, 0) = (0, 0, -18).
    np.testing.assert_array_equal(angular_momentum(two), [-6.0, -8.0, -12.0])
    row = AngularMomentum().record(two, SCENE)
    values = list(row.values())
    assert values[:3] == [-6.0, -8.0, -12.0]
    assert values[3] == pytest.approx(math.sqrt(2.0) * 10.0 + 3.0 * 6.0)
    assert all(name.endswith("[kg m^2/s]") for name in row)


def test_probe_takes_the_nearest_undeformed_particle(two):
    # "corner" is (1, 1, 1): the squared distances are 2 and 3.
    row = Probe("corner").record(two, SCENE)
    assert [row[f"corner_u_{axis} [m]"] for axis in "xyz"] == [0.0, 0.0, 1.0]
    assert [row[f"corner_v_{axis} [m/s]"] for axis in "xyz"] == [0.0, 3.0, 4.0]
    assert len(row) == 6


def test_errors_are_the_instant_errors(two):
    assert Errors().record(two, SCENE) == instant_errors(two, SCENE.exact)


def test_fields_of_a_snapshot(two):
    np.testing.assert_array_equal(two.field("p").values, 2.0 * two.velocity)
    np.testing.assert_array_equal(two.field("u").values, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    np.testing.assert_array_equal(two.field("v").V, [1.0, 3.0])
    assert two.field("J").values.shape == (2,)
    assert two.field("F").values.shape == (2, 3, 3)


@pytest.mark.parametrize("point", [["t"], {"t"}, ("t",), 3, None, Probe])
def test_a_probe_of_no_name_is_refused(point):
    with pytest.raises(InputError, match=r"^Probe: point = .* is not the name of a probe"):
        Probe(point)
