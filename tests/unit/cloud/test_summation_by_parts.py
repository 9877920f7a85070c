"""The pair that sums by parts: its identities, what they buy, and when there is none."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import Cloud, build_cloud, consistency_report
from sphsolid.cloud import operator as operators
from sphsolid.cloud.boundary_weights import quadratic_moments, quadratically_exact_areas
from sphsolid.cloud.lengths import Uniform
from sphsolid.cloud.skew_change import solve
from sphsolid.cloud.skew_problem import SkewProblem, in_lanes
from sphsolid.compiled import set_threads, threads
from sphsolid.errors import InputError
from sphsolid.geometry import Box, MeshFile, TetBox
from sphsolid.geometry.body import AS_MESHED
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes import l_shaped_block
from tests.oracles.dense import dense

Array = NDArray[np.float64]
BODIES = {
    "jitter": Box(upper=(1.0, 0.8, 1.2), jitter=0.4, seed=3),
    "lattice": Box(upper=(1.0, 0.8, 1.2)),
    "tetrahedra": TetBox(upper=(1.0, 0.8, 1.2)),
}
MESHES = Path(__file__).parents[3] / "studies" / "meshes"
SIZE = np.array([1.0, 0.8, 1.2])


def cloud_of(body: Any, spacing: float = 0.2, **options: Any) -> Cloud:
    return build_cloud(
        body.mesh(spacing),
        smoothing=sph.WendlandC2(),
        h_over_dx=1.0,
        operator=sph.SummationByParts(**({"tolerance": 1.0e-6} | options)),
    )


@pytest.fixture(scope="module", params=BODIES)
def cloud(request: pytest.FixtureRequest) -> Cloud:
    return cloud_of(BODIES[request.param])


def matrix(cloud: Cloud) -> Array:
    """``C_ab = V_a G_b(X_a)  (N, N, 3)`` [m^2], dense: the checker."""
    G = dense(cloud.pairs, cloud.gradients.kinematic, cloud.size)
    return np.asarray(cloud.V[:, None, None] * G)


def test_rows_are_exact_for_constants_and_linears(cloud: Cloud) -> None:
    C = matrix(cloud)
    np.testing.assert_allclose(np.sum(C, axis=1), 0.0, atol=1e-15)
    linear = np.einsum("abd,be->aed", C, cloud.X)
    np.testing.assert_allclose(linear, cloud.V[:, None, None] * np.eye(3), atol=1e-15)


def test_it_sums_by_parts_with_the_area_vectors(cloud: Cloud) -> None:
    C = matrix(cloud)
    left = C + np.swapaxes(C, 0, 1)
    left[np.arange(cloud.size), np.arange(cloud.size)] -= cloud.areas
    largest = np.max(np.linalg.norm(cloud.areas, axis=1))
    assert np.max(np.abs(left)) < 1e-5 * largest
    report = consistency_report(cloud, float(np.prod(SIZE)))
    assert pytest.approx(np.max(np.abs(left)) / largest) == report.SBP
    assert max(report.C0, report.C1, report.D0) < 1e-12


def test_the_tolerance_is_what_it_says() -> None:
    tight = cloud_of(BODIES["jitter"], tolerance=1e-10)
    loose = cloud_of(BODIES["jitter"], tolerance=1e-4)
    assert consistency_report(tight, 0.96).SBP < 1e-9 < consistency_report(loose, 0.96).SBP
    for cloud in (tight, loose):
        report = consistency_report(cloud, 0.96)
        assert max(report.C0, report.C1, report.D0) < 1e-12
    assert loose.iterations < tight.iterations


def test_the_force_of_a_linear_stress_is_exact(cloud: Cloud) -> None:
    """``sum_b C_ba P_b = A_a P_a N_a - V_a DIV P``: what second order in disorder rests on."""
    random = np.random.default_rng(5)
    slope = random.uniform(-1.0, 1.0, (3, 3, 3))
    P = np.einsum("iIk,ak->aiI", slope, cloud.X) + random.uniform(-1.0, 1.0, (3, 3))
    force = np.einsum("baI,biI->ai", matrix(cloud), P)
    exact = np.einsum("aI,aiI->ai", cloud.areas, P)
    exact -= cloud.V[:, None] * np.einsum("iII->i", slope)
    assert np.max(np.abs(force - exact)) < 1e-5 * np.max(np.abs(exact))


def test_the_consistent_operator_does_not_do_that() -> None:
    mesh = BODIES["jitter"].mesh(0.2)
    cloud = build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Consistent())
    C = matrix(cloud)
    left = C + np.swapaxes(C, 0, 1)
    left[np.arange(cloud.size), np.arange(cloud.size)] -= cloud.areas
    assert np.max(np.abs(left)) > 0.03 * np.max(np.linalg.norm(cloud.areas, axis=1))


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_areas_integrate_quadratics_over_the_boundary(body: Any) -> None:
    """By the divergence theorem ``int q n dA = int grad q dV``, known on a box."""
    mesh = body.mesh(0.2)
    tags = quadratically_exact_areas(mesh)
    areas, X = np.sum(list(tags.values()), axis=0), mesh.vertices
    volume, centre = np.prod(SIZE), 0.5 * SIZE
    for i in range(3):
        for j in range(3):
            exact = np.zeros(3)
            exact[i] += volume * centre[j]
            exact[j] += volume * centre[i]
            np.testing.assert_allclose((X[:, i] * X[:, j]) @ areas, exact, atol=1e-13)
        np.testing.assert_allclose(X[:, i] @ areas, volume * np.eye(3)[i], atol=1e-13)
    lumped = area_vectors(mesh, mesh.boundary)
    change = np.linalg.norm(areas - lumped, axis=1) / np.max(np.linalg.norm(lumped, axis=1))
    assert np.max(change) < (1e-13 if mesh.is_lattice else 0.02)
    for name, area in tags.items():
        facets = area_vectors(mesh, mesh.faces[name])
        np.testing.assert_allclose(np.sum(area, axis=0), np.sum(facets, axis=0), atol=1e-14)
        np.testing.assert_allclose(X.T @ area, X.T @ facets, atol=1e-14)


def test_lumped_areas_alone_do_not_integrate_quadratics_in_disorder() -> None:
    mesh = BODIES["jitter"].mesh(0.2)
    X, areas = mesh.vertices, area_vectors(mesh, mesh.boundary)
    assert np.max(np.abs((X[:, 1] ** 2) @ areas - [0.0, 2 * 0.96 * 0.4, 0.0])) > 1e-5


def test_areas_of_tags_add_up_to_all_areas() -> None:
    cloud = cloud_of(BODIES["jitter"])
    total = np.sum([cloud.areas_of(face) for face in cloud.mesh.faces], axis=0)
    np.testing.assert_allclose(total, cloud.areas, atol=1e-16)
    top = cloud.areas_of("Y+")
    assert np.all(top[cloud.X[:, 1] < 0.8] == 0.0)


def test_less_epsilon_reproduces_quadratics_better() -> None:
    def error(epsilon: float) -> float:
        cloud = cloud_of(BODIES["jitter"], epsilon=epsilon)
        C = matrix(cloud) / cloud.V[:, None, None]
        found = np.einsum("abd,b->ad", C, cloud.X[:, 0] * cloud.X[:, 1])
        exact = np.stack([cloud.X[:, 1], cloud.X[:, 0], 0.0 * cloud.X[:, 0]], axis=1)
        inside = np.all((cloud.X > 0.0) & (cloud.X < SIZE), axis=1)
        return float(np.sqrt(np.mean((found - exact)[inside] ** 2)))

    coarse, default, fine = error(1e3), error(0.1), error(0.01)
    assert fine < 0.95 * default < 0.75 * coarse


def test_equal_volumes_leave_no_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planted bug: volumes whose first moments are not the body's are refused."""
    mesh = BODIES["jitter"].mesh(0.2)
    ingredients: list[Any] = []
    build = sph.SummationByParts.build
    monkeypatch.setattr(
        sph.SummationByParts, "build", lambda self, i: ingredients.append(i) or build(self, i)
    )
    build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.SummationByParts())
    equal = np.full(len(mesh.vertices), np.mean(ingredients[0].volumes))
    wrong = dataclasses.replace(ingredients[0], volumes=equal)
    with pytest.raises(InputError, match=r"sums by parts.*first moments.*Consistent\(\)"):
        build(sph.SummationByParts(), wrong)


def test_a_support_that_is_too_small_is_refused_clearly() -> None:
    """Enough neighbours for a gradient, too few for one that sums by parts."""
    mesh = Box(jitter=0.2).mesh(0.2)
    build_cloud(mesh, smoothing=sph.WendlandC2(), h_over_dx=0.7, operator=sph.Literal())
    with pytest.raises(InputError, match=r"sums by parts.*too small: raise h_over_dx"):
        build_cloud(
            mesh, smoothing=sph.WendlandC2(), h_over_dx=0.7, operator=sph.SummationByParts()
        )


def test_a_body_of_one_layer_of_cells_has_one() -> None:
    cloud = cloud_of(Box(upper=(1.0, 1.0, 0.1), jitter=0.3), spacing=0.1)
    report = consistency_report(cloud, 0.1)
    assert max(report.C0, report.C1, report.D0) < 1e-11
    assert report.SBP < 1e-5


def _shipped(name: str) -> Mesh:
    return MeshFile(MESHES / name).mesh(AS_MESHED)


@pytest.mark.parametrize("name", ["plate_with_hole_tet.msh", "cylinder_tet.msh"])
def test_it_exists_on_thin_and_curved_bodies(name: str) -> None:
    """Conditions on a plate's areas nearly depend on each other; a cylinder's cannot all be met."""
    mesh = _shipped(name)
    cloud = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.SummationByParts()
    )
    report = consistency_report(cloud, float(np.sum(cloud.V)))
    assert max(report.C0, report.C1, report.D0) < 1e-11
    assert report.SBP < 2e-3


@pytest.mark.parametrize(
    ("name", "missing"), [("plate_with_hole_tet.msh", 1e-14), ("cylinder_tet.msh", 1e-5)]
)
def test_areas_of_files_integrate_quadratics(name: str, missing: float) -> None:
    """Force and moment of every tag come first, what a cylinder's areas cannot do after them."""
    mesh = _shipped(name)
    tags = quadratically_exact_areas(mesh)
    values, exact = quadratic_moments(mesh)
    whole = np.sum(list(tags.values()), axis=0)
    total = float(np.sum(np.linalg.norm(whole, axis=1)))
    assert np.max(np.abs(values.T @ whole - exact)) < missing * total
    for tag, area in tags.items():
        change = area - area_vectors(mesh, mesh.faces[tag])
        assert np.max(np.abs(np.sum(change, axis=0))) < 1e-15 * total
        assert np.max(np.abs(mesh.vertices.T @ change)) < 1e-15 * total


@pytest.mark.parametrize("spacing", [0.85, 0.5])
def test_a_body_with_a_notch_is_no_harder_than_a_box(spacing: float) -> None:
    """Coarse functions in the notch reach no particle; 0.85 m makes cells of 0.75 and 0.875 m."""
    block = cloud_of(l_shaped_block().body, spacing, tolerance=1e-3)
    box = cloud_of(Box(upper=(6.0, 10.0, 3.0), jitter=0.2), 0.5, tolerance=1e-3)
    assert block.iterations < 1.5 * box.iterations


def test_what_has_no_solution_is_taken_out_and_counted() -> None:
    """The right-hand side in the null space would make conjugate gradients diverge."""
    mesh = Box(jitter=0.3, seed=2).mesh(0.25)
    pairs = build_cloud(
        mesh, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=sph.Literal()
    ).pairs
    X, ones = mesh.vertices / 0.25, np.ones(len(mesh.vertices))
    problem = SkewProblem(pairs, X, np.ones(pairs.pairs), 0.02 * ones)

    def applied(multipliers: Array) -> Array:
        out = np.empty((len(X), 10, 4))
        problem.apply(in_lanes(multipliers), out)
        return np.ascontiguousarray(out[:, :, :3])

    null = problem.null_space()
    for k in range(0, 9, 3):
        assert np.max(np.abs(applied(null[:, k : k + 3].reshape(len(X), 10, 3)))) < 1e-12
    right = applied(np.random.default_rng(1).normal(size=(len(X), 10, 3)))
    outside = 1e-4 * np.max(np.abs(right)) * null[:, :3].reshape(right.shape)
    found = solve(problem, right + outside, tolerance=1e-9, most_iterations=2000)
    size = np.max(np.abs(right))
    np.testing.assert_allclose(applied(found.values), right, atol=2e-9 * size)
    assert found.unsolvable == pytest.approx(np.max(np.abs(outside)) / size, rel=1e-3)
    assert found.unsolvable <= found.remainder < found.unsolvable + 1e-9


@pytest.mark.parametrize(
    "options", [{"epsilon": 0.0}, {"tolerance": 1.0}, {"weight_exponent": -1.0}]
)
def test_bad_options_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(InputError, match=r"SummationByParts: .*defaults"):
        sph.SummationByParts(**options)


def test_the_same_bits_at_any_number_of_threads() -> None:
    before = threads()
    try:
        set_threads(1)
        one = cloud_of(BODIES["jitter"]).gradients.force
        set_threads(max(2, before))
        np.testing.assert_array_equal(cloud_of(BODIES["jitter"]).gradients.force, one)
    finally:
        set_threads(before)


def test_it_is_the_default_except_on_a_lattice() -> None:
    scene = l_shaped_block()
    lattice = sph.Simulation(scene, spacing=1.0, formulation=sph.PF())
    assert lattice.operator == (
        sph.Consistent() if lattice.cloud.mesh.is_lattice else sph.SummationByParts()
    )
    disordered = dataclasses.replace(scene, body=Box(jitter=0.3), tractions=(), probes={})
    chosen = sph.Simulation(disordered, spacing=0.25, formulation=sph.PF())
    assert chosen.operator == sph.SummationByParts()
    assert "SummationByParts" in str(chosen.plan())
    assert isinstance(chosen.operator, operators.SummationByParts)


def test_what_is_hopeless_is_recognised_early() -> None:
    """Two bodies in one system, pushed apart: no solution, and not a quadratic of the whole."""
    X = Box(jitter=0.3, seed=2).mesh(0.25).vertices / 0.25
    n = len(X)
    X = np.concatenate([X, X + np.array([40.0, 0.0, 0.0])])
    pairs = Uniform(1.0, 1.0).pairs(X, X, sph.WendlandC2().support)
    problem = SkewProblem(pairs, X, np.ones(pairs.pairs), np.full(2 * n, 0.02))
    right = np.zeros((2 * n, 10, 3))
    right[:, 0] = np.sin(np.arange(2 * n))[:, None]
    found = solve(problem, right, tolerance=1e-10, most_iterations=5000)
    assert found.remainder > 1e-6
    assert found.iterations < 600
