"""The twisting column holds the momentum and the energy that its published data imply."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import Box, Scene, twisting_column

Array = NDArray[np.float64]
#: ``1/2 rho0 Omega^2 int sin^2 dY int (X^2 + Z^2)`` = 1/2 1100 105^2 3 (1/6).
KINETIC_ENERGY = 3.0319e6
#: ``rho0 Omega int sin dY int (X^2 + Z^2)`` = 1100 105 (12/pi) (1/6).
ANGULAR_MOMENTUM = 73_529.6


def totals(scene: Scene, spacing: float) -> tuple[float, Array]:
    """``sum V rho0 v^2 / 2`` [J] and ``sum V X cross rho0 v`` [kg m^2/s] on a lattice."""
    mesh = scene.body.mesh(spacing)
    X, V = mesh.vertices, vertex_volumes(mesh)
    _, v = scene.initial_state(X)
    rho = scene.material.density
    return 0.5 * rho * float(V @ np.sum(v**2, axis=1)), rho * V @ np.cross(X, v)


def test_energy_and_angular_momentum_are_the_published_ones() -> None:
    """Within the error of the vertex quadrature, which vanishes with second order."""
    scene = twisting_column()
    energy, momentum = totals(scene, 1.0 / 12.0)
    # Along X and Z the vertices integrate X^2 as 1/12 + dx^2/6; sin^2 along Y exactly.
    excess = 1.0 + 2.0 * (1.0 / 12.0) ** 2
    assert energy == pytest.approx(KINETIC_ENERGY * excess, rel=2e-5)
    assert momentum[1] == pytest.approx(ANGULAR_MOMENTUM * excess, rel=2e-4)
    np.testing.assert_allclose(momentum[[0, 2]], 0.0, atol=1e-9 * ANGULAR_MOMENTUM)
    # Extrapolated to dx = 0 they are the exact integrals.
    coarse = totals(scene, 1.0 / 6.0)
    assert (4.0 * energy - coarse[0]) / 3.0 == pytest.approx(3031875.0, rel=1e-12)
    exact = 1100.0 * 105.0 * 12.0 / math.pi / 6.0
    assert exact == pytest.approx(ANGULAR_MOMENTUM, abs=0.05)
    assert (4.0 * momentum[1] - coarse[1][1]) / 3.0 == pytest.approx(exact, rel=5e-6)


def test_the_check_notices_equal_volumes() -> None:
    """Planted bug: the same particles with one volume for all are far off the integrals."""
    scene = twisting_column()
    mesh = scene.body.mesh(1.0 / 6.0)
    _, v = scene.initial_state(mesh.vertices)
    V = scene.body.volume / len(v)
    lumped = 0.5 * scene.material.density * V * float(np.sum(v**2))
    assert abs(lumped / KINETIC_ENERGY - 1.0) > 0.2


def test_the_column_turns_about_its_axis_fastest_at_the_free_end() -> None:
    scene = twisting_column()
    X = np.array([[0.5, 6.0, 0.0], [0.5, 3.0, 0.0], [0.0, 6.0, 0.5], [0.3, 0.0, 0.2]])
    _, v = scene.initial_state(X)
    half = 105.0 * math.sin(math.pi / 4.0)
    expected = [[0.0, 0.0, -52.5], [0.0, 0.0, -0.5 * half], [52.5, 0.0, 0.0], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(v, expected, atol=1e-12)


def test_published_geometry_and_material() -> None:
    scene = twisting_column()
    assert scene.body == Box(lower=(-0.5, 0.0, -0.5), upper=(0.5, 6.0, 0.5))
    assert scene.material.density == 1100.0
    mu = 17.0e6 / (2.0 * 1.495)
    assert scene.material.mu == pytest.approx(mu, rel=1e-14)
    assert scene.material.kappa == pytest.approx(17.0e6 / (3.0 * 0.01), rel=1e-12)
    [clamp] = scene.constraints
    assert (clamp.face, clamp.direction) == ("Y-", "all")
    assert scene.end_time == 0.1
    # The lattices of the paper.
    for cells, lattice in ((3, (4, 19, 4)), (4, (5, 25, 5)), (5, (6, 31, 6))):
        X = scene.body.mesh(1.0 / cells).vertices
        assert tuple(len(np.unique(np.round(X[:, d], 9))) for d in range(3)) == lattice


def test_probes_are_points_of_the_body() -> None:
    scene = twisting_column()
    lower, upper = np.array(scene.body.lower), np.array(scene.body.upper)
    for point in scene.probes.values():
        assert np.all((lower <= point) & (point <= upper))
    assert scene.probes["top_centre"] == (0.0, 6.0, 0.0)


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_a_speed_that_is_not_finite_is_refused(speed: float) -> None:
    with pytest.raises(InputError, match="angular_velocity"):
        twisting_column(angular_velocity=speed)
