"""Hexahedra split into tetrahedra, and the tetrahedron with nodal pressures."""

from typing import Any

import numpy as np
import pytest

import fem_reference as fem
from fem_reference.mesh import scikit_fem_tetrahedra
from fem_reference.tetrahedra import tetrahedra
from sphsolid.continuum import NeoHookean, reference_p_wave_speed
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import HexMesh, TetMesh
from sphsolid.geometry.tet_box import TetBox
from sphsolid.record import AngularMomentum, Energy, LinearMomentum
from sphsolid.scenes import Box, Scene, Traction
from tests.oracles.blocks import AFFINE, FACES, MOONEY, RUBBER, spinning_block, stress_of


def shuffled(mesh: HexMesh) -> HexMesh:
    """The same body with its vertices numbered at random."""
    to = np.random.default_rng(4).permutation(len(mesh.vertices))
    vertices = np.empty_like(mesh.vertices)
    vertices[to] = mesh.vertices
    faces = {name: to[quads] for name, quads in mesh.faces.items()}
    return HexMesh(vertices, to[mesh.cells], faces, mesh.spacing, False)


@pytest.mark.parametrize("renumber", [False, True])
def test_the_split_fills_the_body_and_fits(renumber: bool) -> None:
    hexes = Box(upper=(1.0, 0.8, 1.2), jitter=0.3).mesh(1.0 / 3.0)
    mesh = tetrahedra(shuffled(hexes) if renumber else hexes)
    assert len(mesh.cells) == 6 * len(hexes.cells)
    X = mesh.vertices[mesh.cells]
    volume = np.linalg.det(X[:, 1:] - X[:, :1]) / 6.0
    assert volume.min() > 0.0
    assert volume.sum() == pytest.approx(0.96, rel=1e-13)
    # Every triangle inside belongs to two cells, every other one to a tag.
    corners = mesh.cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3)
    _, times = np.unique(np.sort(corners, axis=1), axis=0, return_counts=True)
    assert times.max() == 2
    assert np.sum(times == 1) == sum(len(loops) for loops in mesh.faces.values())
    for name, loops in mesh.faces.items():
        expected = area_vectors(hexes, hexes.faces[name]).sum(axis=0)
        np.testing.assert_allclose(area_vectors(mesh, loops).sum(axis=0), expected, atol=1e-13)


def test_tetrahedra_stay_and_a_flat_one_is_refused() -> None:
    mesh = TetBox().mesh(0.5)
    assert tetrahedra(mesh) is mesh
    flat = TetMesh(np.zeros((4, 3)), np.array([[0, 1, 2, 3]]), {}, 1.0, False)
    with pytest.raises(InputError, match=r"tetrahedron 0 .* flat or inside out"):
        tetrahedra(flat)


def elements_of(material: Any, spacing: float = 0.5) -> Any:
    mesh = tetrahedra(Box(upper=(1.0, 0.8, 1.2), jitter=0.3).mesh(spacing))
    sk = scikit_fem_tetrahedra(mesh)
    return fem.NodalPressureTet().discretise(mesh=mesh, sk=sk, material=material)


def force(elements: Any, x: Any) -> Any:
    f = np.empty_like(x)
    elements.internal_force(x, f)
    return f


def deformed(elements: Any) -> Any:
    X = elements.mesh.vertices
    return X @ AFFINE.T + 0.05 * np.random.default_rng(7).uniform(-1.0, 1.0, X.shape)


@pytest.mark.parametrize("material", [RUBBER, MOONEY])
def test_force_is_the_gradient_of_the_energy(material: Any) -> None:
    elements = elements_of(material)
    x = deformed(elements)
    f, h = force(elements, x), 1e-4
    for a, i in ((0, 0), (4, 1), (13, 2), (17, 0)):
        values = []
        for k in (-2, -1, 1, 2):
            moved = x.copy()
            moved[a, i] += k * h
            values.append(elements.strain_energy(moved))
        slope = (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * h)
        assert slope == pytest.approx(f[a, i], abs=1e-8 * np.abs(f).max())
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * np.abs(f).sum()
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-14 * np.abs(f).sum()


def test_affine_motion_passes_the_patch_test() -> None:
    P = stress_of(MOONEY, AFFINE)
    body = Box(upper=(1.0, 0.8, 1.2), jitter=0.3, seed=1)
    tractions = tuple(Traction(face, lambda X, N, t: N @ P.T) for face in FACES)
    scene = Scene(
        "patch", body, MOONEY, 1.0, tractions=tractions,
        initial_displacement=lambda X: X @ (AFFINE - np.eye(3)).T,
    )
    sim = fem.Simulation(scene, spacing=1.0 / 3.0, element=fem.NodalPressureTet())
    stress = sim.snapshot()
    np.testing.assert_allclose(stress.P, np.broadcast_to(P, stress.P.shape), rtol=1e-11)
    scale = np.abs(P).max() / (MOONEY.density * 0.3)
    assert np.abs(sim._motion_now.a).max() < 1e-11 * scale


def test_the_pressure_sees_the_volumes_of_the_nodes() -> None:
    """Cells that trade volume around one node cost no volumetric energy there."""
    elements = elements_of(NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.4999,
                                                 density=1000.0))
    x = deformed(elements)
    J = elements.nodal_jacobians(x)
    cells, X = elements.mesh.cells, elements.mesh.vertices
    ratio = [np.linalg.det((x[c[1:]] - x[c[0]]).T @ np.linalg.inv((X[c[1:]] - X[c[0]]).T))
             for c in cells]
    for a in (0, 5, 11):
        around = (cells == a).any(axis=1)
        V = elements.volumes[around]
        assert J[a] == pytest.approx(np.sum(V * np.array(ratio)[around]) / np.sum(V), rel=1e-12)


def test_a_free_body_keeps_momenta_and_energy() -> None:
    sim = fem.Simulation(
        spinning_block(end_time=4e-3), spacing=0.25, element=fem.NodalPressureTet(), cfl=0.3
    )
    history = sim.run(every=1e-3, record=[LinearMomentum(), AngularMomentum(), Energy()])
    for name, unit in (("linear_momentum", "[kg m/s]"), ("angular_momentum", "[kg m^2/s]")):
        scale = history[f"{name}_scale {unit}"][0]
        for axis in "xyz":
            column = history[f"{name}_{axis} {unit}"]
            assert np.abs(column - column[0]).max() < 1e-12 * scale
    total = history["total_energy [J]"]
    assert np.abs(total / total[0] - 1.0).max() < 2e-3


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.499])
def test_the_default_time_step_is_below_the_stability_limit(nu: float) -> None:
    """``dt omega_max / 2 < 1`` at the default cfl of 0.6, by power iteration."""
    material = NeoHookean.from_young(young_modulus=17e6, poisson_ratio=nu, density=1100.0)
    elements = elements_of(material, 0.25)
    mass, x = (1100.0 * elements.nodal_volumes)[:, None], elements.mesh.vertices
    y = np.random.default_rng(1).normal(size=x.shape)
    for _ in range(60):
        y *= 1e-6 / np.sqrt(np.mean(y**2))
        z = 0.5 * (force(elements, x + y) - force(elements, x - y)) / mass
        omega = np.sqrt(np.sum(mass * y * z) / np.sum(mass * y * y))
        y = z
    force(elements, x)
    dt = 0.6 * elements.smallest_length() / reference_p_wave_speed(material)
    assert 0.2 < 0.5 * dt * omega < 0.75
