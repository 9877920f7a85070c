"""The Taylor-Hood element against exact solutions, invariants and its own theory."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh

import fem_reference as fem
from fem_reference.loads import loads_of, nodal_force
from fem_reference.mesh import scikit_fem_mesh
from sphsolid.continuum import NeoHookean
from sphsolid.record import AngularMomentum, Energy, Errors, LinearMomentum, period_errors
from sphsolid.scenes import (
    Box,
    Scene,
    Traction,
    amplitude_of_gradient,
    swinging_cube,
    twisting_column,
)
from tests.oracles.blocks import AFFINE, FACES, MOONEY, RUBBER, stress_of

Array = NDArray[np.float64]
CONSISTENT, ONE_SWEEP = fem.TaylorHoodHex(), fem.TaylorHoodHex(fem.LumpedMass(sweeps=1))


# ---------------------------------------------------------------- patch test
@pytest.mark.parametrize("element", [CONSISTENT, ONE_SWEEP])
def test_affine_motion_passes_the_patch_test_on_a_disordered_mesh(element: Any) -> None:
    body = Box(upper=(1.0, 0.8, 1.2), jitter=0.6, seed=1)
    P = stress_of(MOONEY, AFFINE)
    mesh = body.mesh(0.3)
    sk = scikit_fem_mesh(mesh)
    elements = element.discretise(mesh=mesh, sk=sk, material=MOONEY)
    X = elements.mesh.vertices
    x = X @ AFFINE.T + [1.0, 2.0, 3.0]
    internal = np.empty_like(X)
    elements.internal_force(x, internal)
    # scikit-fem's own quadratic shapes on the faces: equilibrium, node by node.
    tractions = tuple(Traction(face, lambda X, N, t: N @ P.T) for face in FACES)
    scene = Scene("patch", body, MOONEY, 1.0, tractions=tractions)
    expected = nodal_force(loads_of(scene, sk, elements.load_shapes), 0.0, len(X))
    scale = np.abs(expected).max()
    np.testing.assert_allclose(internal, expected, atol=1e-12 * scale, rtol=0)
    interior = np.setdiff1d(np.arange(len(X)), elements.mesh.boundary)
    assert len(interior) > 100
    assert np.abs(internal[interior]).max() < 1e-12 * scale
    # Planted bug: one Gauss point weighs one per cent too much.
    maps = elements._maps
    elements._maps = maps._replace(weights=maps.weights * np.where(np.arange(27) == 4, 1.01, 1.0))
    elements.internal_force(x, internal)
    assert np.abs(internal[interior]).max() > 1e-4 * scale


# ---------------------------------------------------------------- invariants
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_a_free_spinning_cube_conserves_momenta_and_energy(jitter: float) -> None:
    def spin(X: Array) -> Array:
        # Not about a principal axis, with a drift and a strain: nothing is zero by symmetry.
        return np.cross([40.0, -30.0, 105.0], X - 0.5) + [5.0, 3.0, -2.0] + 8.0 * (X - 0.5) ** 2

    scene = Scene("spin", Box(jitter=jitter), RUBBER, 0.03, initial_velocity=spin)
    sim = fem.Simulation(scene, spacing=0.125, element=CONSISTENT)
    history = sim.run(every=1e-3, record=[LinearMomentum(), AngularMomentum(), Energy()])
    assert sim.step > 80
    for name, unit in (("linear_momentum", "[kg m/s]"), ("angular_momentum", "[kg m^2/s]")):
        scale = history[f"{name}_scale {unit}"][0]
        for axis in "xyz":
            column = history[f"{name}_{axis} {unit}"]
            assert np.abs(column - column[0]).max() < 1e-12 * scale
    total, kinetic = history["total_energy [J]"], history["kinetic_energy [J]"]
    assert kinetic.min() < 0.97 * kinetic[0]
    assert np.abs(total / total[0] - 1.0).max() < 1e-3


def highest_frequency(elements: Any, x: Array, density: float) -> float:
    """By power iteration on the linearised force."""
    mass = (density * elements.nodal_volumes)[:, None]
    y = np.random.default_rng(1).normal(size=x.shape)
    ahead, behind = np.empty_like(x), np.empty_like(x)
    omega = 0.0
    for _ in range(150):
        y *= 1e-6 / np.sqrt(np.mean(y**2))
        elements.internal_force(x + y, ahead)
        elements.internal_force(x - y, behind)
        z = 0.5 * (ahead - behind) / mass
        omega = math.sqrt(np.sum(mass * y * z) / np.sum(mass * y * y))
        y = z
    return omega


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.499])
@pytest.mark.parametrize("stretch", [0.5, 1.0, 1.5])
def test_the_step_at_cfl_one_is_the_stability_limit_or_less(nu: float, stretch: float) -> None:
    material = NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=nu, density=1100.0)
    across = stretch**-0.5 if nu > 0.49 else 1.0
    for element, jitter in ((CONSISTENT, 0.0), (ONE_SWEEP, 0.0), (CONSISTENT, 0.6)):
        scene = Scene(
            "stretched",
            Box(jitter=jitter),
            material,
            1.0,
            initial_displacement=lambda X: X * [stretch - 1.0, across - 1.0, across - 1.0],
        )
        sim = fem.Simulation(scene, spacing=0.125, element=element, cfl=1.0)
        x = sim.snapshot().x
        omega = highest_frequency(sim._elements, x, material.density)
        at_limit = 0.5 * omega * sim.stable_time_step()
        assert 0.2 < at_limit < 1.01
        if jitter == 0.0 and stretch == 1.0:
            # Measured, not estimated: the rule leaves less than a tenth unused at rest.
            assert at_limit > 0.9


def test_the_step_is_shorter_than_that_of_b_bar_by_a_known_factor() -> None:
    for nu, factors in ((0.3, (0.63, 0.89)), (0.499, (0.52, 0.77))):
        scene = swinging_cube(amplitude=1e-9, poisson_ratio=nu)
        linear = fem.Simulation(scene, spacing=0.25).stable_time_step()
        for element, factor in zip((CONSISTENT, ONE_SWEEP), factors, strict=True):
            sim = fem.Simulation(scene, spacing=0.25, element=element)
            assert sim.stable_time_step() / linear == pytest.approx(factor, abs=0.006)


# ---------------------------------------------------------------- inf-sup
def linearised(elements: Any, moments: Any, inner: NDArray[np.int64]) -> tuple[Array, Array]:
    """Stiffness of the isochoric energy and derivative of the moments at the inner nodes."""
    X, h = elements.mesh.vertices, 1e-5
    K, B = [], []
    for a, i in ((a, i) for a in inner for i in range(3)):
        sides = []
        for sign in (1.0, -1.0):
            x, force = X.copy(), np.empty_like(X)
            x[a, i] += sign * h
            elements.internal_force(x, force)
            sides.append((force[inner].ravel(), moments(elements, x)))
        K.append((sides[0][0] - sides[1][0]) / (2.0 * h))
        B.append((sides[0][1] - sides[1][1]) / (2.0 * h))
    return np.array(K), np.array(B).T


def pressure_spectrum(element: Any, cells: int) -> Array:
    """Eigenvalues ``beta^2`` of ``B K^-1 B^T q = beta^2 M q`` on a cube held all around."""
    soft = NeoHookean(mu=1.0, kappa=1e-3, density=1.0)
    mesh = Box().mesh(1.0 / cells)
    elements = element.discretise(mesh=mesh, sk=scikit_fem_mesh(mesh), material=soft)
    if isinstance(element, fem.TaylorHoodHex):

        def moments(e: Any, x: Array) -> Array:
            e.dilatation(x)
            return np.array(e._moments)

        mass = elements._mass.toarray()
    else:

        def moments(e: Any, x: Array) -> Array:
            return np.array((e.stress(x).J - 1.0) * e.volumes)

        mass = np.diag(elements.volumes)
    X = elements.mesh.vertices
    inner = np.flatnonzero(((X > 1e-9) & (X < 1.0 - 1e-9)).all(axis=1))
    K, B = linearised(elements, moments, inner)
    return np.asarray(eigh(B @ np.linalg.solve(0.5 * (K + K.T), B.T), mass, eigvals_only=True))


def test_no_pressure_is_left_unseen_and_no_checkerboard() -> None:
    """One zero (the constant), then a bound that does not fall with the mesh: inf-sup stable."""
    smallest = []
    for cells in (2, 3):
        values = pressure_spectrum(CONSISTENT, cells)
        assert abs(values[0]) < 1e-9
        smallest.append(values[1])
    assert min(smallest) > 0.08
    assert smallest[1] > 0.95 * smallest[0]
    # The judge sees a checkerboard: Q1-P0 on the same nodes has many unseen pressures.
    assert np.sum(np.abs(pressure_spectrum(fem.BBarHex(), 4)) < 1e-9) > 6


# ---------------------------------------------------------------- swinging cube
@cache
def cube_errors(
    element: Any, family: Any, nodes: int, nu: float, manufactured: bool = False, cfl: float = 0.6
) -> dict[str, float]:
    scene = swinging_cube(
        family=family,
        amplitude=amplitude_of_gradient(family, 0.2) if manufactured else 1e-7,
        manufactured=manufactured,
        poisson_ratio=nu,
    )
    sim = fem.Simulation(scene, spacing=1.0 / nodes, element=element, cfl=cfl)
    T = scene.end_time
    rows = sim.run(until=T, every=T / 12.0, record=[Errors()]).table.iloc[1:]
    return period_errors(rows.drop(columns=["time [s]", "step"]).to_dict("records"))


def slope(coarse: dict[str, float], fine: dict[str, float], name: str) -> float:
    return math.log2(coarse[name] / fine[name])


@pytest.mark.parametrize("family", ["A+B+C=0", "A=B=C"])
def test_third_order_in_space_until_the_time_step_limits_it(family: str) -> None:
    """Central differences are second order: the third order shows at a short step."""
    coarse, fine = (cube_errors(CONSISTENT, family, n, 0.3, cfl=0.1) for n in (4, 8))
    assert 2.8 < slope(coarse, fine, "p_x") < 3.6
    assert 2.0 < slope(coarse, fine, "P_xx") < 3.2
    usual, finer = (cube_errors(CONSISTENT, family, n, 0.3) for n in (8, 16))
    for name in usual:
        assert slope(usual, finer, name) > 1.95, name


@pytest.mark.parametrize("family", ["A+B+C=0", "A=B=C"])
def test_far_more_accurate_than_b_bar_on_the_same_nodes(family: str) -> None:
    for manufactured in (False, True):
        linear = cube_errors(fem.BBarHex(), family, 16, 0.3, manufactured)
        quadratic = cube_errors(CONSISTENT, family, 16, 0.3, manufactured)
        for name in linear:
            assert quadratic[name] < 0.25 * linear[name], (name, manufactured)


def test_finite_strains_are_better_than_second_order() -> None:
    for family in ("A+B+C=0", "A=B=C"):
        coarse, fine = (cube_errors(CONSISTENT, family, n, 0.3, True) for n in (8, 16))
        for name in ("p_x", "p_y", "p_z"):
            assert slope(coarse, fine, name) > 2.0


def test_a_lumped_projection_costs_the_accuracy_where_volume_changes() -> None:
    exact = cube_errors(CONSISTENT, "A=B=C", 16, 0.3)
    lumped = cube_errors(ONE_SWEEP, "A=B=C", 16, 0.3)
    assert lumped["p_x"] > 4.0 * exact["p_x"]
    # No change of volume, no difference: at a short step, since theirs are not the same.
    exact, lumped = (cube_errors(e, "A+B+C=0", 8, 0.3, cfl=0.1) for e in (CONSISTENT, ONE_SWEEP))
    assert lumped["p_x"] == pytest.approx(exact["p_x"], rel=0.02)


# ---------------------------------------------------------------- locking
def test_the_twisting_column_does_not_lock() -> None:
    """Tip twist at 0.02 and 0.04 s near incompressibility, two elements across the column.

    1.963 and 3.71 rad are those of 12x72x12 B-bar elements of an independent code.
    """
    sim = fem.Simulation(
        twisting_column(poisson_ratio=0.495), spacing=1.0 / 4.0, element=CONSISTENT
    )
    start = sim.snapshot()
    energy = start.kinetic_energy + start.strain_energy
    top = np.isclose(start.X[:, 1], 6.0)
    assert sim.elements == 2 * 12 * 2
    for time, known in ((0.02, 1.963), (0.04, 3.71)):
        sim.run(until=time)
        now = sim.snapshot()
        X, x = now.X[top], now.x[top]
        X, x = X - X.mean(axis=0), x - x.mean(axis=0)
        sine = np.sum(x[:, 0] * X[:, 2] - x[:, 2] * X[:, 0])
        cosine = np.sum(x[:, 0] * X[:, 0] + x[:, 2] * X[:, 2])
        assert math.atan2(sine, cosine) % (2.0 * math.pi) == pytest.approx(known, rel=0.01)
    assert now.kinetic_energy + now.strain_energy == pytest.approx(energy, rel=1e-4)
