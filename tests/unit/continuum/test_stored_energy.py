"""The energy counted from the undeformed state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import serial_kernel
from sphsolid.continuum import MooneyRivlin, NeoHookean, law
from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.tensor import IDENTITY, cofactor, determinant, join, load, split

Array = NDArray[np.float64]


def stored(material: Any, F: Any) -> Any:
    entries = split(F)
    return law.stored_energy(material, entries, cofactor(entries), determinant(entries))


def test_it_is_zero_in_the_undeformed_state(material: Any) -> None:
    assert law.stored_energy(material, IDENTITY, IDENTITY, 1.0) == 0.0
    if isinstance(material, NeoHookean):
        # The energy itself is not.
        assert law.energy(material, IDENTITY, IDENTITY, 1.0) == 1.5 * material.mu


def test_it_is_zero_in_any_rotated_state_and_positive_elsewhere(
    material: Any, rotations: Array, deformations: Array
) -> None:
    scale = material.mu + material.kappa
    np.testing.assert_allclose(stored(material, rotations), 0.0, atol=1e-13 * scale)
    assert np.all(stored(material, deformations) > 1e-6 * material.mu)


def test_it_differs_from_the_energy_by_a_constant(material: Any, deformations: Array) -> None:
    entries = split(deformations)
    energy = law.energy(material, entries, cofactor(entries), determinant(entries))
    gap = energy - stored(material, deformations)
    rest = law.energy(material, IDENTITY, IDENTITY, 1.0)
    np.testing.assert_allclose(gap, rest, atol=1e-14 * np.max(np.abs(energy)))


def test_its_derivative_is_the_stress(material: Any, deformations: Array) -> None:
    entries = split(deformations)
    P = join(law.first_piola(material, entries, cofactor(entries), determinant(entries)))
    for i in range(3):
        for k in range(3):
            moved = deformations.astype(complex)
            moved[:, i, k] += 1e-30j
            derivative = np.imag(stored(material, moved)) / 1e-30
            np.testing.assert_allclose(
                derivative, P[:, i, k], atol=1e-13 * (material.mu + material.kappa)
            )


def test_small_strains_store_the_energy_of_linear_elasticity(material: Any) -> None:
    """``lambda/2 tr(e)^2 + mu e:e`` and no linear term."""
    direction = np.random.default_rng(3).normal(size=(20, 3, 3))
    size = 1e-4
    gradient = size * direction
    strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
    lam = first_lame(material.mu, material.kappa)
    trace = np.trace(strain, axis1=1, axis2=2)
    exact = 0.5 * lam * trace**2 + material.mu * np.sum(strain**2, axis=(1, 2))
    found = stored(material, np.eye(3) + gradient)
    cubic = (material.mu + material.kappa) * np.linalg.norm(gradient, axis=(1, 2)) ** 3
    assert np.all(np.abs(found - exact) < cubic)
    assert np.all(np.abs(found - exact) < 0.02 * exact)


@serial_kernel
def _compiled(material, F, W):  # type: ignore[no-untyped-def]
    for a in range(len(F)):
        F_a = load(F, a)
        W[a] = law.stored_energy(material, F_a, cofactor(F_a), determinant(F_a))


def test_a_kernel_gives_the_same(deformations: Array) -> None:
    material = MooneyRivlin.from_young(
        young_modulus=17e6, poisson_ratio=0.3, density=1100.0, cofactor_share=0.5
    )
    W = np.empty(len(deformations))
    _compiled(material, deformations, W)
    np.testing.assert_allclose(W, stored(material, deformations), rtol=1e-12)
