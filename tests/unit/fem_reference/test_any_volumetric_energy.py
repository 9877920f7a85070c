"""Both elements with a law whose ``U`` is not ``kappa/2 (J - 1)^2``."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import fem_reference as fem
import sphsolid as sph
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.continuum import law
from sphsolid.scenes import Box
from tests.oracles.laws import LAWS, Logarithmic, Unstated

Array = NDArray[Any]
B_BAR, TAYLOR_HOOD = fem.BBarHex(), fem.TaylorHoodHex()
LUMPED = fem.TaylorHoodHex(fem.LumpedMass(sweeps=1))
LOGARITHMIC, UNSTATED, MIXED = LAWS
#: Kernels of a law take their time to compile: each law meets one element at least.
PAIRS = [(B_BAR, LOGARITHMIC), (B_BAR, UNSTATED), (TAYLOR_HOOD, MIXED)]
NAMES = ["b_bar-logarithmic", "b_bar-unstated", "taylor_hood-mixed"]


def elements_of(element: Any, material: Any, jitter: float = 0.3) -> Any:
    box = Box(upper=(1.0, 1.0, 0.5), jitter=jitter)
    mesh = box.mesh(0.5)
    return element.discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=material)


def deformed(X: Array) -> Array:
    """``J`` far from one, and different from place to place."""
    F = np.array([[1.2, 0.2, 0.0], [-0.1, 1.1, 0.1], [0.05, 0.0, 1.15]])
    return X @ F.T + 0.04 * np.random.default_rng(7).uniform(-1, 1, X.shape)


def force(elements: Any, x: Array) -> Array:
    result = np.empty_like(x)
    elements.internal_force(x, result)
    return result


@pytest.mark.parametrize(
    ("element", "material"), [*PAIRS, (LUMPED, MIXED)], ids=[*NAMES, "lumped-mixed"]
)
def test_the_force_is_the_gradient_of_the_energy(element: Any, material: Any) -> None:
    elements = elements_of(element, material)
    x = deformed(elements.mesh.vertices)
    found = force(elements, x)
    direction = np.random.default_rng(1).normal(size=x.shape)
    h = 1.0e-3
    energies = [elements.strain_energy(x + s * h * direction) for s in (-2, -1, 1, 2)]
    slope = np.dot(energies, [1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    # The fourth-order difference is good to about h^4 of the force's own size.
    size = np.linalg.norm(found) * np.linalg.norm(direction)
    assert abs(np.sum(found * direction) - slope) < 2e-8 * size
    # The judge sees the quadratic U in its place: it stores and pushes otherwise.
    quadratic = sph.NeoHookean(mu=material.mu, kappa=material.kappa, density=material.density)
    other = force(elements_of(element, quadratic), x)
    assert abs(np.sum(other * direction) - slope) > 1e-3 * size


def test_a_stated_energy_and_one_that_is_asked_agree() -> None:
    stated, asked = (
        elements_of(B_BAR, kind(1.0e6, 5.0e7, 1000.0)) for kind in (Logarithmic, Unstated)
    )
    x = deformed(stated.mesh.vertices)
    one, two = force(stated, x), force(asked, x)
    np.testing.assert_allclose(one, two, atol=1e-12 * np.abs(one).max(), rtol=0)
    assert stated.strain_energy(x) == pytest.approx(asked.strain_energy(x), rel=1e-12)


@pytest.mark.parametrize(("element", "material"), PAIRS, ids=NAMES)
def test_a_pure_change_of_volume_stores_U_and_is_stressed_by_its_derivative(
    element: Any, material: Any
) -> None:
    elements = elements_of(element, material)
    stretch = 1.82 ** (1.0 / 3.0)
    x = stretch * elements.mesh.vertices
    volume = 0.5
    expected = volume * law.volumetric_energy(material, 1.82)
    assert elements.strain_energy(x) == pytest.approx(expected, rel=1e-12)
    stress = elements.stress(x)
    pressure = law.volumetric_pressure(material, 1.82)
    np.testing.assert_allclose(stress.J, 1.82, rtol=1e-12)
    sigma = stress.P @ np.swapaxes(stress.F, 1, 2) / 1.82
    np.testing.assert_allclose(sigma, pressure * np.eye(3)[None].repeat(len(sigma), 0),
                               atol=1e-11 * pressure)  # fmt: skip


@pytest.mark.parametrize(("element", "material"), PAIRS, ids=NAMES)
def test_the_step_follows_a_volume_that_stiffens(element: Any, material: Any) -> None:
    """``U''`` of these laws grows with compression; that of the quadratic one does not."""
    soft = sph.NeoHookean(mu=material.mu, kappa=material.kappa, density=material.density)
    J = 0.6
    lengths = []
    for law_ in (material, soft):
        elements = elements_of(element, law_)
        force(elements, J ** (1.0 / 3.0) * elements.mesh.vertices)
        lengths.append(elements.smallest_length())
    stiffness = law.volumetric_stiffness(material, J) / material.kappa
    assert stiffness > 1.8
    faster = J * np.sqrt(stiffness)
    assert lengths[0] / lengths[1] == pytest.approx(1.0 / max(1.0, faster), rel=1e-6)
