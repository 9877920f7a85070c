"""The spinning cube starts with the angular momentum and energy that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import spinning_cube

#: ``rho0 Omega / 6`` [kg m^2/s] and ``rho0 Omega^2 / 12`` [J].
ANGULAR_MOMENTUM, KINETIC_ENERGY = 19_250.0, 1_010_625.0


def totals(scene, spacing):
    """Kinetic energy [J], angular and linear momentum of the particles."""
    mesh = scene.body.mesh(spacing)
    X, mass = mesh.vertices, scene.material.density * vertex_volumes(mesh)
    _, v = scene.initial_state(X)
    return 0.5 * mass @ np.sum(v**2, axis=1), mass @ np.cross(X, v), mass @ v


@pytest.mark.parametrize("cells", [2, 4, 8])
def test_energy_and_momenta(cells):
    """Vertices integrate X^2 as 1/12 + dx^2/6, so a lattice has 1 + 2 dx^2 of both."""
    energy, L, p = totals(spinning_cube(), 1.0 / cells)
    excess = 1.0 + 2.0 / cells**2
    assert L[2] == pytest.approx(ANGULAR_MOMENTUM * excess, rel=1e-13)
    assert energy == pytest.approx(KINETIC_ENERGY * excess, rel=1e-13)
    np.testing.assert_allclose(L[:2], 0.0, atol=1e-9)
    np.testing.assert_allclose(p, 0.0, atol=1e-9)


def test_disorder_keeps_them_nearly():
    energy, L, _ = totals(spinning_cube(jitter=0.2, seed=1), 1.0 / 8)
    assert L[2] == pytest.approx(ANGULAR_MOMENTUM * (1.0 + 2.0 / 64), rel=5e-3)
    assert energy == pytest.approx(0.5 * 105.0 * L[2], rel=1e-12)


def test_turns_and_sense():
    assert spinning_cube().end_time == pytest.approx(10.0 * 2.0 * math.pi / 105.0)
    backwards = spinning_cube(angular_velocity=-50.0, turns=1.0)
    assert backwards.end_time == pytest.approx(2.0 * math.pi / 50.0)
    _, v = backwards.initial_state(np.array([[0.5, 0.0, 0.1]]))
    np.testing.assert_allclose(v, [[0.0, -25.0, 0.0]])
    assert backwards.constraints == ()


@pytest.mark.parametrize(
    "wrong",
    [
        {"angular_velocity": 0.0},
        {"angular_velocity": math.inf},
        {"turns": 0.0},
        {"turns": -1.0},
        {"turns": math.nan},
    ],
)
def test_bad_input_is_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        spinning_cube(**wrong)
