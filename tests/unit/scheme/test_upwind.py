"""Upwind SPH: the acoustic Riemann flux of pairs, its reconstruction and its limiter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import EnergyBudget
from tests.oracles.blocks import MOONEY
from tests.oracles.checkers import disturbed_block, momentum_drift, rates_at
from tests.unit.scheme.test_jst import spun

KINDS = [
    sph.Upwind(), sph.Upwind("limited"), sph.Upwind("none"), sph.Upwind(normal="pair"),
]  # fmt: skip
CASES = {
    "lattice": {"jitter": 0.0, "operator": sph.Consistent()},
    "jitter": {"jitter": 0.3, "operator": sph.SummationByParts()},
    "not adjoint": {"jitter": 0.0, "operator": sph.Consistent(use="force")},
}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param]


def block(term, formulation=sph.PF(), **options):
    return disturbed_block(formulation, term, **options)


def limited(p, v_gradient, pairs, X):
    """[Barth1989], particle by particle and component by component."""
    phi = np.ones_like(p)
    for a in range(len(X)):
        near = [b for (c, b) in pairs if c == a]
        for i in range(3):
            high = max(p[a, i], *(p[b, i] for b in near))
            low = min(p[a, i], *(p[b, i] for b in near))
            for b in near:
                rise = 0.5 * MOONEY.density * v_gradient[a, i] @ (X[b] - X[a])
                if rise > 0.0:
                    phi[a, i] = min(phi[a, i], (high - p[a, i]) / rise)
                elif rise < 0.0:
                    phi[a, i] = min(phi[a, i], (low - p[a, i]) / rise)
    return phi


def by_definition(sim, term):
    """``D(p)`` by the formulas, pair by pair."""
    cloud, x, p = sim.cloud, sim.state.x, sim.state.p
    size, X, V = cloud.size, cloud.X, cloud.V
    G_f, G_k = np.zeros((2, size, size, 3))
    row, column = cloud.pairs.row_of_pair, cloud.pairs.indices
    G_f[row, column], G_k[row, column] = cloud.gradients.force, cloud.gradients.kinematic
    L = np.einsum("bi,abj->aij", p / MOONEY.density, G_k)
    F = np.einsum("bi,abj->aij", x, G_k)
    A = 0.5 * (V[:, None, None] * G_f - (V[:, None, None] * G_f).transpose(1, 0, 2))
    lengths = np.linalg.norm(A, axis=2)
    pairs = [(a, b) for a, b in zip(row, column, strict=True)
             if a != b and lengths[a, b] > 1e-12 * lengths.max()]  # fmt: skip
    phi = np.ones_like(p)
    if term.reconstruction == "limited":
        phi = limited(p, L, pairs, X)
    lam = MOONEY.kappa - 2 / 3 * MOONEY.mu
    c_p, c_s = np.sqrt(np.array([lam + 2 * MOONEY.mu, MOONEY.mu]) / MOONEY.density)
    D = np.zeros_like(p)
    for a, b in pairs:
        d = X[b] - X[a]
        jump = p[b] - p[a]
        if term.reconstruction != "none":
            jump -= 0.5 * MOONEY.density * (phi[a] * (L[a] @ d) + phi[b] * (L[b] @ d))
        n = x[b] - x[a]
        if term.normal == "area":
            n = np.linalg.inv(0.5 * (F[a] + F[b])).T @ A[a, b]
        n /= np.linalg.norm(n)
        S = c_p * np.outer(n, n) + c_s * (np.eye(3) - np.outer(n, n))
        D[a] += term.impedance * lengths[a, b] * (S @ jump) / V[a]
    return D


@pytest.mark.parametrize("term", KINDS, ids=lambda t: f"{t.reconstruction}, {t.normal}")
def test_it_is_that_of_the_formulas(case, term):
    sim = block(replace(term, impedance=0.7), **case)
    rates_at(sim, step=1e-4)
    D, right = sim._rhs.terms[0].D_p, by_definition(sim, replace(term, impedance=0.7))
    np.testing.assert_allclose(D, right, rtol=0, atol=1e-11 * np.abs(right).max())


@pytest.mark.parametrize("term", KINDS, ids=lambda t: f"{t.reconstruction}, {t.normal}")
def test_no_resultant_and_energy_is_taken_at_random_states(case, term):
    for seed in range(4):
        sim = block(term, **case)
        sim.state.p[:] = 1e4 * np.random.default_rng(seed).normal(size=sim.state.p.shape)
        rates_at(sim, step=1e-4)
        D, V = sim._rhs.terms[0].D_p, sim.cloud.V
        assert np.abs(V @ D).max() < 1e-13 * (V @ np.abs(D)).max()
        power = np.sum(V[:, None] * D * sim.state.p) / MOONEY.density
        assert power < 0.0
        assert sim._rhs.terms[0].powers(sim._rhs.stage)[0] == pytest.approx(power, rel=1e-12)


def test_an_affine_motion_is_not_damped_but_at_first_order(case):
    A = np.array([[3.0, -1.0, 2.0], [0.5, 1.0, 4.0], [-2.0, 0.3, 1.0]])
    largest = {}
    for term in KINDS[:3]:
        sim = block(term, **case)
        sim.state.p[:] = MOONEY.density * sim.cloud.X @ A.T
        rates_at(sim, step=1e-4)
        largest[term.reconstruction] = np.abs(sim._rhs.terms[0].D_p).max()
    # Half-way to a neighbour a linear field has not reached its value: nothing is limited.
    assert max(largest["linear"], largest["limited"]) < 1e-10 * largest["none"]


def test_the_limiter_clips_what_overshoots_and_damps_more():
    power = {}
    for kind in ("linear", "limited", "none"):
        sim = block(sph.Upwind(kind), jitter=0.0)
        sign = (-1.0) ** np.rint(sim.cloud.X[:, 0] / 0.2)
        sim.state.p[:] = MOONEY.density * sign[:, None] * np.exp(3.0 * sim.cloud.X[:, [1]])
        rates_at(sim, step=1e-4)
        power[kind] = sim._rhs.terms[0].powers(sim._rhs.stage)[0]
        if kind == "limited":
            phi = sim._rhs.terms[0].phi
            assert phi.min() >= 0.0
            assert phi.max() == 1.0
            assert np.mean(phi < 1.0) > 0.05
    assert power["none"] < power["limited"] < 0.0
    assert power["linear"] < 0.0


@pytest.mark.parametrize("treatment", [sph.LocalProjection(), sph.NoProjection()])
@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PFHJ()], ids=lambda f: f.name)
def test_a_run_keeps_both_momenta(formulation, treatment):
    options = {"formulation": formulation, "angular_momentum": treatment, "h_over_dx": 1.0}
    for integrator in (sph.PositionVerlet(), sph.TVDRK2()):
        sim = spun(sph.Upwind("limited"), integrator=integrator, **options)
        assert max(momentum_drift(sim, 20)) < 1e-13
    free = spun(sph.Upwind("limited", keeps_momenta=False), **options)
    linear, angular = momentum_drift(free, 20)
    assert linear < 1e-13
    assert angular > 1e-6


def test_its_budget_closes():
    rests = []
    for cfl in (0.2, 0.1):
        sim = spun(sph.Upwind(), cfl=cfl, integrator=sph.TVDRK2())
        history = sim.run(record=[EnergyBudget()])
        assert history["dissipation_p [J]"][-1] < 0.0
        rests.append(abs(history["energy_rest [J]"][-1]))
    assert rests[1] < 0.35 * rests[0]


def test_a_larger_impedance_shortens_the_step():
    rates = [block(sph.Upwind(impedance=c), jitter=0.0)._rhs.terms[0].rate for c in (1.0, 2.0)]
    assert rates[1] == pytest.approx(2.0 * rates[0], rel=1e-12)
    strong = block(sph.Upwind(impedance=5.0), jitter=0.0)
    assert strong.stable_time_step() == strong._rhs.terms[0].largest_step(strong.state)


@pytest.mark.parametrize(
    "wrong",
    [
        {"reconstruction": "cubic"}, {"impedance": 0.0}, {"impedance": -1.0},
        {"impedance": np.nan}, {"impedance": True}, {"normal": "x"}, {"keeps_momenta": 0},
    ],
    ids=str,
)  # fmt: skip
def test_what_makes_no_sense_is_refused(wrong):
    with pytest.raises(InputError, match="Upwind"):
        sph.Upwind(**wrong)
