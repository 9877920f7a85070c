"""The volumetric energy of a snapshot is what the element stores, by its own quadrature."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.record.vtkhdf import _Body
from sphsolid.scenes import Box, Scene

LAW = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.495, density=1000.0)
ELEMENTS = (fem.BBarHex(), fem.FullHex(), fem.NodalPressureTet(), fem.TaylorHoodHex())


def wavy(element: object, body: Box = Box()) -> fem.Simulation:
    scene = Scene(
        "wavy", body, LAW, 1.0,
        initial_displacement=lambda X: 0.02 * np.sin(7.0 * X[:, [1, 2, 0]] + 3.0 * X),
    )  # fmt: skip
    return fem.Simulation(scene, spacing=0.5, element=element)


@pytest.mark.parametrize("element", ELEMENTS, ids=str)
def test_with_the_shear_alone_it_is_the_strain_energy(element: object) -> None:
    """What is left of the strain energy is of the law without volume, so it has no kappa in it."""
    sim = wavy(element)
    shot = sim.snapshot()
    rest = shot.strain_energy - shot.volumetric_energy
    softer = sph.NeoHookean(mu=LAW.mu, kappa=LAW.kappa / 10.0, density=LAW.density)
    other = fem.Simulation(
        Scene("wavy", Box(), softer, 1.0, initial_displacement=sim.scene.initial_displacement),
        spacing=0.5, element=element,
    ).snapshot()  # fmt: skip
    assert rest == pytest.approx(other.strain_energy - other.volumetric_energy, rel=1e-9)
    assert shot.volumetric_energy == pytest.approx(10.0 * other.volumetric_energy, rel=1e-9)


def test_full_integration_by_hand() -> None:
    """A cube with a homogeneous gradient and one element with a bulge along one axis."""
    body = Box()
    scene = Scene(
        "bulge", body, LAW, 1.0,
        initial_displacement=lambda X: 0.1 * X[:, :1] * X[:, 1:2] * np.array([1.0, 0.0, 0.0]),
    )  # fmt: skip
    shot = fem.Simulation(scene, spacing=1.0, element=fem.FullHex()).snapshot()
    # det F = 1 + 0.1 Y: U is quadratic in Y, which two Gauss points integrate exactly.
    Y = np.linspace(0.0, 1.0, 20001)
    exact = np.trapezoid(law.volumetric_energy(LAW, 1.0 + 0.1 * Y), Y)
    assert shot.volumetric_energy == pytest.approx(exact, rel=1e-8)


def test_cells_are_no_vertices_where_a_mesh_has_as_many() -> None:
    shot = wavy(fem.NodalPressureTet(), Box((0.0, 0.0, 0.0), (0.5, 0.5, 1.0))).snapshot()
    assert len(shot.stress_X) == len(shot.X)
    assert not shot.field("J").is_at(shot.X)
    assert shot.field("u").is_at(shot.X)
    assert "J" in _Body.of(shot).in_cells
    # Means of the cells around a vertex lie within the values of the cells.
    carried = shot.at_vertices("J")
    assert carried.min() >= shot.J.min()
    assert not np.array_equal(carried, shot.J)
