"""The finite element reference against exact solutions, invariants and published figures.

A reference that is wrong is worse than none: everything the particle method is compared with is
pinned here first.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import fem_reference as fem
from fem_reference.loads import loads_of, nodal_force
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.continuum import MooneyRivlin, NeoHookean, law
from sphsolid.continuum.tensor import cofactor, determinant, split
from sphsolid.geometry.mesh import HexMesh
from sphsolid.record import (
    AngularMomentum,
    Energy,
    Errors,
    LinearMomentum,
    Snapshot,
    period_errors,
)
from sphsolid.scenes import (
    Box,
    Constraint,
    Scene,
    Traction,
    amplitude_of_gradient,
    swinging_cube,
)

Array = NDArray[np.float64]
FACES = ("X-", "X+", "Y-", "Y+", "Z-", "Z+")
STRESSES = ("P_xx", "P_yy", "P_zz", "P_xy", "P_xz", "P_yz")
MOMENTA = ("p_x", "p_y", "p_z")


# ---------------------------------------------------------------- patch test
def integrated_traction(mesh: HexMesh, P: Array) -> Array:
    """``sum over boundary faces of P integral N_a n dA`` by hand: no scikit-fem, no loads."""
    f = np.zeros_like(mesh.vertices)
    point = 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0)
    for quads in mesh.faces.values():
        X = mesh.vertices[quads]
        for s in point:
            for t in point:
                N = np.array([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
                N_s = np.array([t - 1, 1 - t, t, -t])
                N_t = np.array([s - 1, -s, s, 1 - s])
                area = np.cross(np.einsum("fai,a->fi", X, N_s), np.einsum("fai,a->fi", X, N_t))
                for a in range(4):
                    np.add.at(f, quads[:, a], 0.25 * N[a] * area @ P.T)
    return f


@pytest.mark.parametrize("material", ["neo_hookean", "mooney_rivlin"])
def test_affine_motion_passes_the_patch_test_on_a_disordered_mesh(material: str) -> None:
    elastic = {"young_modulus": 17.0e6, "poisson_ratio": 0.45, "density": 1100.0}
    solid: Any = (
        NeoHookean.from_young(**elastic)
        if material == "neo_hookean"
        else MooneyRivlin.from_young(cofactor_share=0.4, **elastic)
    )
    body = Box(upper=(1.0, 0.8, 1.2), jitter=0.6, seed=1)
    F = np.array([[1.3, 0.4, 0.0], [-0.1, 0.7, 0.2], [0.1, 0.0, 1.1]])
    entries = split(F)
    P = np.reshape(law.first_piola(solid, entries, cofactor(entries), determinant(entries)), (3, 3))
    mesh = body.mesh(0.2)
    sk = scikit_fem_mesh(mesh)
    elements = fem.BBarHex().discretise(mesh=mesh, sk=sk, material=solid)
    internal = np.empty_like(mesh.vertices)
    x = mesh.vertices @ F.T + [1.0, 2.0, 3.0]
    elements.internal_force(x, internal)
    expected = integrated_traction(mesh, P)
    scale = np.abs(expected).max()
    interior = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.boundary)
    assert len(interior) > 50
    assert np.abs(internal[interior]).max() < 1e-12 * scale
    np.testing.assert_allclose(internal, expected, atol=1e-12 * scale, rtol=0)

    # The load vectors of the same traction hold the same forces: equilibrium, node by node.
    tractions = tuple(Traction(face, lambda X, N, t: N @ P.T) for face in FACES)
    held = Scene("patch", body, solid, 1.0, tractions=tractions)
    loads = loads_of(held, sk, elements.load_shapes)
    external = nodal_force(loads, 0.0, len(x))
    np.testing.assert_allclose(external, expected, atol=1e-12 * scale, rtol=0)

    # Planted bug: one Gauss point weighs one per cent too much.  (Turning the gradients would be
    # no bug here: an isotropic solid gives the same force in every material frame.)
    maps = elements._maps
    elements._maps = maps._replace(weights=maps.weights * np.where(np.arange(8) == 3, 1.01, 1.0))
    elements.internal_force(x, internal)
    assert np.abs(internal[interior]).max() > 1e-4 * scale


# ---------------------------------------------------------------- invariants
def test_a_free_spinning_cube_conserves_momenta_and_energy() -> None:
    material = NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.45, density=1100.0)

    def spin(X: Array) -> Array:
        # Not about a principal axis, with a drift and a strain: nothing is zero by symmetry.
        return np.cross([40.0, -30.0, 105.0], X - 0.5) + [5.0, 3.0, -2.0] + 8.0 * (X - 0.5) ** 2

    scene = Scene("spin", Box(jitter=0.3), material, 0.03, initial_velocity=spin)
    sim = fem.Simulation(scene, spacing=0.25)
    history = sim.run(every=1e-3, record=[LinearMomentum(), AngularMomentum(), Energy()])
    assert sim.step > 80
    for name, unit in (("linear_momentum", "[kg m/s]"), ("angular_momentum", "[kg m^2/s]")):
        scale = history[f"{name}_scale {unit}"][0]
        for axis in "xyz":
            column = history[f"{name}_{axis} {unit}"]
            assert np.abs(column - column[0]).max() < 1e-12 * scale
    total = history["total_energy [J]"]
    kinetic = history["kinetic_energy [J]"]
    assert kinetic.min() < 0.97 * kinetic[0]
    assert np.abs(total / total[0] - 1.0).max() < 1e-3


def test_the_energy_error_is_second_order_in_the_time_step_and_does_not_grow() -> None:
    def error(cfl: float) -> Array:
        scene = swinging_cube(amplitude=0.05)
        sim = fem.Simulation(scene, spacing=0.25, cfl=cfl)
        history = sim.run(until=2.0 * scene.end_time, every=5e-4, record=[Energy()])
        total = history["total_energy [J]"]
        return np.abs(total / total[0] - 1.0)

    coarse, fine = error(0.6), error(0.3)
    assert coarse.max() < 5e-3
    assert 1.7 < np.log2(coarse.max() / fine.max()) < 2.3
    half = len(coarse) // 2
    assert coarse[half:].max() < 1.5 * coarse[:half].max()


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.499])
@pytest.mark.parametrize("stretch", [0.5, 1.0, 1.5])
def test_the_default_time_step_is_below_the_stability_limit(nu: float, stretch: float) -> None:
    """``dt omega_max / 2 < 1``, the exact limit of central differences, by power iteration."""
    material = NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=nu, density=1100.0)
    across = stretch**-0.5 if nu > 0.49 else 1.0
    for jitter in (0.0, 0.6):
        scene = Scene(
            "stretched",
            Box(jitter=jitter),
            material,
            1.0,
            initial_displacement=lambda X: X * [stretch - 1.0, across - 1.0, across - 1.0],
        )
        mesh = scene.body.mesh(0.25)
        elements = fem.BBarHex().discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=material)
        mass = (material.density * elements.nodal_volumes)[:, None]
        x = mesh.vertices + scene.initial_displacement(mesh.vertices)
        y = np.random.default_rng(1).normal(size=x.shape)
        ahead, behind = np.empty_like(x), np.empty_like(x)
        for _ in range(150):
            y *= 1e-6 / np.sqrt(np.mean(y**2))
            elements.internal_force(x + y, ahead)
            elements.internal_force(x - y, behind)
            z = 0.5 * (ahead - behind) / mass
            omega = math.sqrt(np.sum(mass * y * z) / np.sum(mass * y * y))
            y = z
        at_limit = 0.5 * omega * fem.Simulation(scene, spacing=0.25, cfl=1.0).stable_time_step()
        assert 0.3 < at_limit < 1.2


# ---------------------------------------------------------------- swinging cube
@cache
def cube_errors(
    family: Any, cells: int, poisson_ratio: float, manufactured: bool
) -> dict[str, float]:
    scene = swinging_cube(
        family=family,
        amplitude=amplitude_of_gradient(family, 0.2) if manufactured else 1e-7,
        manufactured=manufactured,
        poisson_ratio=poisson_ratio,
    )
    sim = fem.Simulation(scene, spacing=1.0 / cells)
    T = scene.end_time
    rows = sim.run(until=T, every=T / 12.0, record=[Errors()]).table.iloc[1:]
    return period_errors(rows.drop(columns=["time [s]", "step"]).to_dict("records"))


def slopes(family: str, poisson_ratio: float, manufactured: bool) -> dict[str, float]:
    coarse = cube_errors(family, 8, poisson_ratio, manufactured)
    fine = cube_errors(family, 16, poisson_ratio, manufactured)
    return {name: math.log2(coarse[name] / fine[name]) for name in MOMENTA + STRESSES}


#: Errors of an independent Q1-P0 code on the 17^3 lattice, CFL 0.6, in the same norm.
INDEPENDENT = {
    ("A+B+C=0", 0.3): {"p_x": 2.7e-3, "P_xx": 5.3e-3},
    ("A=B=C", 0.3): {"p_x": 6.6e-3, "P_xx": 2.0e-2},
    ("A+B+C=0", 0.499): {"p_x": 2.9e-3},
}


@pytest.mark.parametrize(("family", "poisson_ratio"), list(INDEPENDENT))
def test_linear_limit_is_second_order_at_the_known_level(family: str, poisson_ratio: float) -> None:
    for name, slope in slopes(family, poisson_ratio, manufactured=False).items():
        assert slope >= 1.95, f"{name}: slope {slope:.3f} is below second order"
        assert slope < 2.15, f"{name}: slope {slope:.3f} left its band"
    errors = cube_errors(family, 16, poisson_ratio, False)
    for name, known in INDEPENDENT[family, poisson_ratio].items():
        assert errors[name] == pytest.approx(known, rel=0.03)


@pytest.mark.parametrize("family", ["A+B+C=0", "A=B=C"])
def test_finite_strains_are_second_order_with_manufactured_loads(family: str) -> None:
    for name, slope in slopes(family, 0.3, manufactured=True).items():
        assert 1.9 <= slope < 2.2, f"{name}: slope {slope:.3f}"
    errors = cube_errors(family, 16, 0.3, True)
    linear = cube_errors(family, 16, 0.3, False)
    for name in MOMENTA + STRESSES:
        assert errors[name] < 1.4 * linear[name]


def test_near_incompressibility_does_not_lock() -> None:
    compressible = cube_errors("A+B+C=0", 8, 0.3, False)
    rubber = cube_errors("A+B+C=0", 8, 0.499, False)
    for name in MOMENTA + STRESSES:
        assert rubber[name] < 1.1 * compressible[name]


# ---------------------------------------------------------------- twisting column
def twist_of_top(snapshot: Snapshot) -> float:
    """Mean rotation of the top face about its axis [rad], in (-pi, pi]."""
    top = np.flatnonzero(np.isclose(snapshot.X[:, 1], 6.0))
    X, x = snapshot.X[top], snapshot.x[top]
    X, x = X - X.mean(axis=0), x - x.mean(axis=0)
    return math.atan2(
        float(np.sum(x[:, 0] * X[:, 2] - x[:, 2] * X[:, 0])),
        float(np.sum(x[:, 0] * X[:, 0] + x[:, 2] * X[:, 2])),
    )


def test_twisting_column_follows_an_independent_finite_element_code() -> None:
    """Tip twist of 6x36x6 elements against 12x72x12 of an independent Q1-P0 code."""
    material = NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.495, density=1100.0)

    def swirl(X: Array) -> Array:
        rate = 105.0 * np.sin(np.pi * X[:, 1] / 12.0)
        return np.stack([rate * X[:, 2], 0.0 * rate, -rate * X[:, 0]], axis=1)

    scene = Scene(
        "column",
        Box((-0.5, 0.0, -0.5), (0.5, 6.0, 0.5)),
        material,
        0.1,
        initial_velocity=swirl,
        constraints=(Constraint("Y-", "all"),),
    )
    sim = fem.Simulation(scene, spacing=1.0 / 6.0)
    twist = [0.0]
    for k in range(1, 6):
        sim.run(until=0.02 * k)
        angle = twist_of_top(sim.snapshot())
        twist.append(angle + 2.0 * math.pi * round((twist[-1] + 0.8 - angle) / (2.0 * math.pi)))
    assert twist[1:] == pytest.approx([1.963, 3.71, 5.06, 5.87, 5.93], abs=0.09)
    end = sim.snapshot()
    energy = end.kinetic_energy + end.strain_energy
    assert energy == pytest.approx(3.2003e6, rel=1e-4)
