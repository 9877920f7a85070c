"""The bending column's initial state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import Box, bending_column


@pytest.mark.parametrize("cells", [2, 4])
def test_energy_and_momentum_of_the_start(cells):
    """``rho0/2 (5/3)^2 int Y^2`` = 110,000 J and ``rho0 5/3 int Y`` = 33,000 kg m/s."""
    scene = bending_column()
    mesh = scene.body.mesh(1.0 / cells)
    X, mass = mesh.vertices, 1100.0 * vertex_volumes(mesh)
    _, v = scene.initial_state(X)
    np.testing.assert_allclose(mass @ v, [33_000.0, 0.0, 0.0], rtol=1e-13, atol=1e-9)
    # Vertices integrate Y^2 over the length as 72 + 6 dx^2 / 6.
    excess = 1.0 + 1.0 / cells**2 / 72.0
    assert 0.5 * mass @ np.sum(v**2, axis=1) == pytest.approx(110_000.0 * excess, rel=1e-13)


def test_statement():
    scene = bending_column(velocity_gradient=2.0)
    assert scene.body == Box((-0.5, 0.0, -0.5), (0.5, 6.0, 0.5))
    _, v = scene.initial_state(np.array([[0.5, 6.0, 0.0], [0.0, 0.0, 0.5]]))
    np.testing.assert_array_equal(v, [[12.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    [clamp] = scene.constraints
    assert (clamp.face, clamp.direction) == ("Y-", "all")
    assert scene.probes["top_centre"] == (0.0, 6.0, 0.0)
    assert scene.end_time > 0.453


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_bad_input_is_refused(value):
    with pytest.raises(InputError, match="velocity_gradient"):
        bending_column(velocity_gradient=value)
