"""Wave speeds against linear elasticity, a closed form under dilation, and numpy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sphsolid.continuum import NeoHookean, law, reference_p_wave_speed, wave_speeds
from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.continuum.wave_speed import acoustic_tensor, smallest_stretch

NORMALS = np.random.default_rng(11).normal(size=(6, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("young_modulus", "poisson_ratio", "density", "speed"),
    [
        (17e6, 0.3, 1100.0, 144.24),
        (50046.0, 0.3, 1000.0, 8.208),
        (1e6, 0.499, 1000.0, 408.8),
        (17e6, 0.495, 1100.0, 722.5),
    ],
    ids=["swinging cube", "L-shaped block", "punch", "twisting column"],
)
def test_p_wave_speed_of_the_benchmarks(young_modulus, poisson_ratio, density, speed):
    material = NeoHookean.from_young(
        young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
    )
    assert reference_p_wave_speed(material) == pytest.approx(speed, rel=2e-4)


def test_undeformed_solid_has_the_linear_speeds(material):
    lam = first_lame(material.mu, material.kappa)
    s = math.sqrt(material.mu / material.density)
    p = math.sqrt((lam + 2.0 * material.mu) / material.density)
    for N in NORMALS:
        np.testing.assert_allclose(wave_speeds(material, np.eye(3), N), [s, s, p], rtol=1e-11)
    assert p == pytest.approx(reference_p_wave_speed(material), rel=1e-15)


def test_acoustic_tensor_is_the_second_derivative_of_the_energy(material, deformations):
    """``Q_ij = d2W / dF_iI dF_jJ N_I N_J``: complex step of the stress, no tangent involved."""
    step = 1e-30
    for N in NORMALS[:2]:
        exact = np.empty(deformations.shape)
        for j in range(3):
            dyad = np.zeros((3, 3))
            dyad[j] = N
            moved = split(deformations + 1j * step * dyad)
            P = join(law.first_piola(material, moved, cofactor(moved), determinant(moved)))
            exact[:, :, j] = np.imag(P) @ N / step
        mine = acoustic_tensor(material, deformations, N)
        np.testing.assert_allclose(mine, exact, atol=1e-12 * np.max(np.abs(exact)))
        np.testing.assert_allclose(mine, np.swapaxes(mine, 1, 2), atol=1e-12 * np.max(np.abs(mine)))


@pytest.mark.parametrize("a", [0.8, 1.0, 1.3])
def test_dilated_neo_hookean_solid(a):
    """At ``F = a I``: ``rho0 c_p^2 = 4/3 mu a^-2 + kappa a^4``, ``rho0 c_s^2 = mu a^-2``
    (differentiate ``W(diag(a + e, a, a))`` and ``W(a I + e e1 (x) e2)`` twice by hand).
    """
    m = NeoHookean.from_young(young_modulus=17e6, poisson_ratio=0.3, density=1100.0)
    p = math.sqrt((4.0 / 3.0 * m.mu / a**2 + m.kappa * a**4) / m.density)
    s = math.sqrt(m.mu / a**2 / m.density)
    for N in NORMALS:
        np.testing.assert_allclose(wave_speeds(m, a * np.eye(3), N), sorted([s, s, p]), rtol=1e-12)


def test_polyconvex_solids_stay_elliptic(polyconvex, deformations):
    """Waves keep real speeds under any deformation: what polyconvexity is for."""
    for N in NORMALS:
        speeds = wave_speeds(polyconvex, deformations, N)
        assert np.all(speeds > 0.1 * math.sqrt(polyconvex.mu / polyconvex.density))


def test_lost_ellipticity_is_nan():
    unstable = NeoHookean(mu=-1e6, kappa=1e7, density=1000.0)
    shear, other, longitudinal = wave_speeds(unstable, np.eye(3), [1.0, 0.0, 0.0])
    assert math.isnan(shear)
    assert math.isnan(other)
    assert longitudinal > 0.0


def stretch(F) -> float:
    return smallest_stretch(tuple(float(entry) for entry in np.ravel(F)))


def test_smallest_stretch_is_the_smallest_singular_value(deformations):
    for F in deformations:
        assert stretch(F) == pytest.approx(np.linalg.svd(F)[1][-1], rel=1e-12)


@pytest.mark.parametrize("size", [0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3])
def test_smallest_stretch_near_the_identity(size, rotations):
    for Q, E in zip(rotations[:10], np.random.default_rng(12).normal(size=(10, 3, 3)), strict=True):
        F = Q @ (np.eye(3) + size * E)
        assert stretch(F) == pytest.approx(np.linalg.svd(F)[1][-1], rel=1e-14 + 1e-8 * size)


@pytest.mark.parametrize(
    "stretches", [(1.0, 1.0, 0.5), (0.5, 0.5, 1.0), (2.0, 2.0, 2.0), (3.0, 1.0, 1e-3)]
)
def test_smallest_stretch_with_equal_stretches(stretches, rotations):
    for Q, R in zip(rotations[:5], rotations[5:10], strict=True):
        F = Q @ np.diag(stretches) @ R.T
        # Round-off times the largest eigenvalue of F^T F is left in the smallest; where the two
        # smallest are equal, the angle of the closed form loses half the digits.
        least, largest = min(stretches), max(stretches)
        twin = sorted(stretches)[0] == sorted(stretches)[1] != largest
        tolerance = 1e-14 * (largest / least) ** 2 + (3e-8 if twin else 0.0)
        assert stretch(F) == pytest.approx(least, rel=tolerance)


def test_smallest_stretch_of_what_is_no_deformation():
    assert stretch(np.diag([1.0, 1.0, 0.0])) == pytest.approx(0.0, abs=1e-7)
    for entry in range(9):
        F = np.eye(3).ravel()
        F[entry] = math.nan
        assert math.isnan(stretch(F))
