"""Hourglass control by springs of pairs, and the gradient of the codes that ship it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud, consistency_report
from sphsolid.errors import InputError
from sphsolid.record import EnergyBudget
from sphsolid.scenes import Box, Scene
from tests.oracles.blocks import AFFINE, MOONEY
from tests.oracles.checkers import momentum_drift, rates_at

SHIPPED = {"operator": sph.Literal("kernel"), "smoothing": sph.CubicSpline(), "h_over_dx": 2**0.5}
CASES = {
    "consistent": (0.0, {"operator": sph.Consistent()}),
    "as shipped": (0.0, SHIPPED),
    "as shipped, jitter": (0.3, SHIPPED),
    "by parts, jitter": (0.3, {"operator": sph.SummationByParts()}),
    "force alone": (0.0, {"operator": sph.Consistent(use="force")}),
}


def block(jitter, *, alpha=0.3, formulation=None, end=0.004, **options):
    def velocity(X):
        return np.random.default_rng(1).normal(size=X.shape)

    def displacement(X):
        return 0.03 * np.random.default_rng(0).normal(size=X.shape)

    body = Box(upper=(1.0, 0.8, 1.2), jitter=jitter, seed=5)
    return sph.Simulation(
        Scene("noisy", body, MOONEY, end, initial_velocity=velocity,
              initial_displacement=displacement),
        spacing=0.25, formulation=formulation or sph.Displacement(),
        stabilisation=sph.HourglassControl(alpha), **options,
    )  # fmt: skip


@pytest.fixture(scope="module", params=CASES)
def case(request):
    jitter, options = CASES[request.param]
    return block(jitter, **options)


def force_of(sim, x=None):
    if x is not None:
        sim.state.x[:] = x
    rates_at(sim, step=1e-4)
    return sim._rhs.terms[0].force.copy()


def by_definition(sim):
    """[Ganzenmueller2015], pair by pair, with both of its ``delta``."""
    cloud, x = sim.cloud, sim.state.x
    # The gradient of the method, asked of the pairs themselves.
    pairs, G = cloud.pairs, cloud.gradients.kinematic
    F = np.zeros((cloud.size, 3, 3))
    np.add.at(F, pairs.row_of_pair, x[pairs.indices][:, :, None] * G[:, None, :])
    mu, kappa = MOONEY.mu, MOONEY.kappa
    young = 9.0 * kappa * mu / (3.0 * kappa + mu)
    f = np.zeros_like(x)
    for a, b in itertools.permutations(range(cloud.size), 2):
        X, y = cloud.X[b] - cloud.X[a], x[b] - x[a]
        W = float(cloud.smoothing.value(np.array([np.linalg.norm(X)]), cloud.h)[0])
        n = y / np.linalg.norm(y)
        of_a, of_b = (F[a] @ X - y) @ n, (F[b] @ X - y) @ n
        both = cloud.V[a] * cloud.V[b]
        f[a] -= 0.5 * 0.3 * both * W / (X @ X) * young * (of_a + of_b) * n
    return f / cloud.V[:, None]


def test_the_force_is_that_of_the_definition(case):
    f = force_of(case)
    np.testing.assert_allclose(f, by_definition(case), rtol=0, atol=1e-12 * np.abs(f).max())


def test_neither_resultant_nor_moment(case):
    f = case.cloud.V[:, None] * force_of(case)
    scale = np.sum(np.linalg.norm(f, axis=1))
    assert np.abs(np.sum(f, axis=0)).max() < 1e-13 * scale
    assert np.abs(np.sum(np.cross(case.state.x, f), axis=0)).max() < 1e-13 * scale


def test_an_affine_motion_is_not_held(case):
    before = case.state.x.copy()
    noisy = np.abs(force_of(case)).max()
    assert np.abs(force_of(case, case.cloud.X @ AFFINE.T)).max() < 1e-11 * noisy
    case.state.x[:] = before


def test_what_alternates_is_pulled_back_and_power_is_force_times_velocity(case):
    before = case.state.x.copy()
    sign = (-1.0) ** np.rint(case.cloud.X / 0.25).sum(axis=1)
    u = 0.01 * sign[:, None] * np.array([1.0, 0.3, 0.2])
    f = force_of(case, case.cloud.X + u)
    V = case.cloud.V[:, None]
    assert np.sum(V * f * u) < 0.0
    (power,) = case._rhs.terms[0].powers(case._rhs.stage)
    assert power == pytest.approx(np.sum(V * f * case.state.p) / MOONEY.density, rel=1e-12)
    case.state.x[:] = before


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PF()], ids=lambda f: f.name)
@pytest.mark.parametrize("integrator", [sph.PositionVerlet(), sph.TVDRK2()], ids=lambda i: i.name)
def test_a_run_keeps_both_momenta_and_its_budget_closes(formulation, integrator):
    options = {"formulation": formulation, "integrator": integrator}
    drift = momentum_drift(block(0.3, **options, **SHIPPED), steps=30)
    assert max(drift) < 1e-13
    rests = []
    for cfl in (0.2, 0.1):
        sim = block(0.3, **options, **SHIPPED, cfl=cfl, end=0.002)
        history = sim.run(record=[EnergyBudget()])
        assert history["work_hourglass_control [J]"][-1] != 0.0
        rests.append(abs(history["energy_rest [J]"][-1]))
    assert rests[1] < 0.35 * rests[0]


def test_strong_springs_shorten_the_step():
    steps = [block(0.0, alpha=alpha, **SHIPPED).stable_time_step() for alpha in (0.1, 50.0, 200.0)]
    assert steps[0] > steps[1]
    assert steps[2] == pytest.approx(0.5 * steps[1], rel=1e-12)
    strong = block(0.0, alpha=200.0, **SHIPPED)
    strong.run(until=0.002)
    assert np.abs(strong.state.x - strong.cloud.X).max() < 0.5


@pytest.mark.parametrize("alpha", [0.0, -0.1, 2e3, np.nan, "much", True])
def test_a_strength_that_makes_no_sense_is_refused(alpha):
    with pytest.raises(InputError, match="HourglassControl: alpha"):
        sph.HourglassControl(alpha)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_the_gradient_of_the_kernel_takes_linear_fields_exactly(jitter):
    mesh = Box(jitter=jitter, seed=2).mesh(0.125)
    made = {
        kind: build_cloud(
            mesh, smoothing=sph.CubicSpline(), h_over_dx=1.2, operator=sph.Literal(kind)
        )
        for kind in ("kernel", "corrected_kernel")
    }
    report = consistency_report(made["kernel"], 1.0)
    assert max(report.C0, report.C1) < 1e-12
    assert made["kernel"].kind.name == "Literal(kernel)"
    difference = np.abs(
        made["kernel"].gradients.kinematic - made["corrected_kernel"].gradients.kinematic
    )
    inside = np.all(np.abs(mesh.vertices - 0.5) < 0.1, axis=1)
    inner = inside[made["kernel"].pairs.row_of_pair]
    # The kernel's own correction is one inside a lattice, and not at its boundary.
    assert np.max(difference[~inner]) > 0.1
    assert jitter or np.max(difference[inner]) < 1e-12
