"""The fully integrated hexahedron: its own energy's gradient, its patch test, and that it locks."""

import math
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.record import Errors, period_errors
from sphsolid.scenes import Box, swinging_cube
from tests.oracles.blocks import AFFINE, MOONEY, RUBBER, stress_of
from tests.unit.fem_reference.test_b_bar_hex import deformed, energy, energy_gradient, force


def elements_of(mesh: Any, material: Any) -> Any:
    return fem.FullHex().discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=material)


@pytest.mark.parametrize("jitter", [0.0, 0.5])
@pytest.mark.parametrize("material", [RUBBER, MOONEY])
def test_force_is_the_gradient_of_the_fully_integrated_energy(material: Any, jitter: float) -> None:
    mesh = Box(upper=(1.0, 0.8, 1.2), jitter=jitter).mesh(0.5)
    elements, x = elements_of(mesh, material), deformed(mesh)
    expected = energy_gradient(material, mesh, x, mean_dilatation=False)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(force(elements, x), expected, atol=1e-13 * scale, rtol=0)
    at_rest = energy(material, mesh, mesh.vertices, mean_dilatation=False)
    stored = energy(material, mesh, x, mean_dilatation=False) - at_rest
    assert elements.strain_energy(x) == pytest.approx(stored, rel=1e-12)
    # With the mean Jacobian it is another element: the check above would notice.
    mean = energy_gradient(material, mesh, x)
    assert np.abs(mean - expected).max() > 1e-3 * scale


def test_affine_motion_is_exact_and_forces_have_no_resultant() -> None:
    mesh = Box(jitter=0.5).mesh(0.25)
    elements = elements_of(mesh, MOONEY)
    x = mesh.vertices @ AFFINE.T
    stress, f = elements.stress(x), force(elements, x)
    P = stress_of(MOONEY, AFFINE)
    np.testing.assert_allclose(stress.P, np.broadcast_to(P, stress.P.shape), rtol=1e-11)
    interior = np.setdiff1d(np.arange(len(x)), mesh.boundary)
    assert np.abs(f[interior]).max() < 1e-12 * np.abs(f).max()
    f = force(elements, deformed(mesh))
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * np.abs(f).sum()
    moment = np.cross(deformed(mesh), f).sum(axis=0)
    assert np.abs(moment).max() < 1e-14 * np.abs(f).sum()


def errors(element: Any, cells: int, poisson_ratio: float) -> dict[str, float]:
    scene = swinging_cube(family="A+B+C=0", amplitude=1e-7, poisson_ratio=poisson_ratio)
    sim = fem.Simulation(scene, spacing=1.0 / cells, element=element)
    T = scene.end_time
    rows = sim.run(until=T, every=T / 12.0, record=[Errors()]).table.iloc[1:]
    return period_errors(rows.drop(columns=["time [s]", "step"]).to_dict("records"))


def test_it_is_of_second_order_where_the_body_is_compressible() -> None:
    coarse, fine = (errors(fem.FullHex(), cells, 0.3) for cells in (4, 8))
    for name in ("p_x", "p_y", "p_z", "P_xx", "P_yy", "P_zz"):
        assert 1.8 < math.log2(coarse[name] / fine[name]) < 2.3, name


def test_it_locks_where_b_bar_does_not() -> None:
    locked, free = (errors(element, 4, 0.499) for element in (fem.FullHex(), fem.BBarHex()))
    assert locked["p_x"] > 5.0 * free["p_x"]
