"""JST: harmonic and biharmonic dissipation of ``p`` and ``J``, and momenta by least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import build_cloud
from sphsolid.continuum.kept_momenta import momentum_correction
from sphsolid.errors import InputError
from sphsolid.record import EnergyBudget
from sphsolid.scenes import Box, Scene
from sphsolid.scheme.harmonic import harmonic_operator
from tests.oracles.blocks import MOONEY, loaded_block
from tests.oracles.checkers import disturbed_block, momentum_drift, rates_at, total_share

USUAL = {"smoothing": sph.CubicSpline(), "h_over_dx": 1.0}
FULL = sph.JST(eps_p2=0.05, eps_J2=0.02, eps_J4=1 / 32)
FORMULATIONS = [sph.Displacement(), sph.PF(), sph.PFJ(), sph.PFHJ()]


def cloud(jitter):
    return build_cloud(
        Box(jitter=jitter, seed=2).mesh(0.2), smoothing=sph.CubicSpline(), h_over_dx=1.0,
        operator=sph.Literal(),
    )  # fmt: skip


def block(term, formulation=sph.PFHJ(), *, jitter=0.3, **options):
    return disturbed_block(formulation, term, jitter=jitter, **USUAL | options)


def spun(term, **options):
    def velocity(X):
        rough = 2.0 * np.random.default_rng(1).normal(size=X.shape)
        return rough + np.cross([40.0, -30.0, 80.0], X - 0.5) + [5.0, 3.0, -2.0]

    scene = Scene("spun", Box(jitter=0.3, seed=5), MOONEY, 0.002, initial_velocity=velocity)
    options = {"formulation": sph.PFHJ(), **USUAL, **options}
    return sph.Simulation(scene, spacing=0.25, stabilisation=term, **options)


# ------------------------------------------------------------------ the harmonic operator
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_a_linear_field_has_no_laplacian_anywhere_and_a_square_has_that_of_it_inside(jitter):
    made = cloud(jitter)
    lap, X = harmonic_operator(made), made.X
    linear = lap @ np.column_stack([np.ones(len(X)), X])
    assert np.abs(linear).max() * made.spacing**2 < 1e-13
    inside = np.all(np.abs(X - 0.5) < 0.15, axis=1)
    square = (lap @ np.sum(X**2, axis=1))[inside]
    np.testing.assert_allclose(square, 6.0, rtol=0.1 if jitter else 1e-12)


def test_on_a_lattice_it_is_second_order_inside():
    errors = []
    for n in (8, 16):
        mesh = Box().mesh(1 / n)
        lap = harmonic_operator(
            build_cloud(mesh, smoothing=sph.CubicSpline(), h_over_dx=1.0, operator=sph.Literal())
        )
        X = mesh.vertices
        f = np.sin(2.0 * X[:, 0]) * np.cos(X[:, 1]) * np.exp(X[:, 2])
        inside = np.all(np.abs(X - 0.5) < 0.3, axis=1)
        # (-4 - 1 + 1) f
        errors.append(np.abs(lap @ f + 4.0 * f)[inside].max())
    assert np.log2(errors[0] / errors[1]) > 1.8


def test_without_its_correction_an_affine_motion_would_be_damped():
    made = cloud(0.0)
    wrong = harmonic_operator(made, corrected=False) @ made.X
    assert np.abs(wrong).max() * made.spacing > 0.5


# ------------------------------------------------------------------ what it adds
@pytest.mark.parametrize("weighting", [sph.AsPrinted(), sph.SelfAdjoint()])
def test_affine_velocities_and_a_uniform_J_are_not_damped(weighting):
    full = FULL if not weighting.is_self_adjoint else sph.JST(eps_J4=1 / 32, weighting=weighting)
    sim = block(full)
    term = sim._rhs.terms[0]
    rates_at(sim, step=1e-4)
    noisy = np.abs(term.D_p).max(), np.abs(term.D_J).max()
    A = np.array([[3.0, -1.0, 2.0], [0.5, 1.0, 4.0], [-2.0, 0.3, 1.0]])
    sim.state.p[:] = MOONEY.density * (sim.cloud.X @ A.T + [1.0, 2.0, 3.0])
    sim.state.J[:] = 1.3
    rates_at(sim, step=1e-4)
    assert np.abs(term.D_p).max() < 1e-11 * noisy[0]
    assert np.abs(term.D_J).max() < 1e-11 * noisy[1]


def test_it_is_that_of_the_formula():
    sim = block(FULL)
    term = sim._rhs.terms[0]
    rates_at(sim, step=1e-4)
    lap, c, h = harmonic_operator(sim.cloud).toarray(), term.wave_speed, sim.cloud.h
    assert c == pytest.approx(np.sqrt((MOONEY.kappa + 4 / 3 * MOONEY.mu) / MOONEY.density))
    p, J, V = sim.state.p, sim.state.J, sim.cloud.V
    D_p = c * h * (0.05 * lap @ p - h**2 / 8 * lap @ lap @ p)
    D_J = c * h * (0.02 * lap @ J - h**2 / 32 * lap @ lap @ J)
    np.testing.assert_allclose(term.D_p, D_p, rtol=0, atol=1e-12 * np.abs(D_p).max())
    D_J -= V @ D_J / V.sum()
    np.testing.assert_allclose(term.D_J, D_J, rtol=0, atol=1e-12 * np.abs(D_J).max())


@pytest.mark.parametrize("seed", range(5))
def test_it_takes_energy_at_random_states(seed):
    for full in (FULL, sph.JST(eps_J4=1 / 32, weighting=sph.SelfAdjoint())):
        sim = block(full)
        random = np.random.default_rng(seed)
        sim.state.p[:] = 1e4 * random.normal(size=sim.state.p.shape)
        sim.state.J[:] = 1.0 + 0.05 * random.normal(size=len(sim.state.J))
        rates_at(sim, step=1e-4)
        by_p, by_J, _ = sim._rhs.terms[0].powers(sim._rhs.stage)
        assert by_p < 0.0
        assert by_J < 0.0


def forms(weighting):
    """Least and largest power of ``D(p)`` over the states of one size."""
    sim = block(sph.JST(weighting=weighting))
    term, V = sim._rhs.terms[0], sim.cloud.V
    root = np.sqrt(V)
    D = term._damped(np.diag(1.0 / root), 0.0, 0.125)
    D = root[:, None] * D
    values = np.linalg.eigvalsh(0.5 * (D + D.T))
    return values[0], values[-1]


def test_the_self_adjoint_form_cannot_make_energy_and_the_printed_one_can():
    least, most = forms(sph.SelfAdjoint())
    assert most < 1e-12 * abs(least)
    least, most = forms(sph.AsPrinted())
    assert 1e-3 * abs(least) < most < 0.1 * abs(least)


# ------------------------------------------------------------------ momenta
def test_the_correction_takes_resultant_and_moment_and_is_the_least_that_does():
    random = np.random.default_rng(3)
    V, x, r = random.uniform(1, 2, 30), random.normal(size=(30, 3)), random.normal(size=(30, 3))
    c = momentum_correction(V, x, r)
    assert np.abs(V @ (r + c)).max() < 1e-13
    assert np.abs(V @ np.cross(x, r + c)).max() < 1e-13
    # It is a rigid motion, so orthogonal to every field that has neither.
    other = random.normal(size=(30, 3))
    other += momentum_correction(V, x, other)
    assert abs(np.sum(V[:, None] * c * other)) < 1e-12


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
@pytest.mark.parametrize("treatment", [sph.LocalProjection(), sph.NoProjection()])
def test_both_momenta_are_kept_with_and_without_the_local_projection(formulation, treatment):
    full = FULL if formulation.evolves_J else sph.JST(eps_p2=0.05)
    options = {"formulation": formulation, "angular_momentum": treatment}
    for integrator in (sph.PositionVerlet(), sph.TVDRK2()):
        assert max(momentum_drift(spun(full, integrator=integrator, **options), 20)) < 1e-13


def test_without_the_correction_neither_is_kept():
    linear, angular = momentum_drift(spun(replace(FULL, keeps_momenta=False)), 20)
    assert linear > 1e-6
    assert angular > 1e-6
    sim = block(replace(FULL, keeps_momenta=False))
    rates_at(sim, step=1e-4)
    assert total_share(sim.cloud.V, sim._rhs.terms[0].D_J) > 1e-4


def test_loads_keep_their_resultant_and_moment():
    scene = replace(loaded_block(), constraints=())
    sim = sph.Simulation(
        scene, spacing=0.25, stabilisation=FULL, formulation=sph.PFHJ(),
        angular_momentum=sph.NoProjection(), **USUAL,
    )  # fmt: skip
    rates = rates_at(sim, step=1e-4, t=1e-3)
    V, loads = sim.cloud.V, sim._rhs.loads.at(1e-3)[0]
    assert np.abs(V @ (rates.p - loads)).max() < 1e-11 * (V @ np.abs(rates.p)).max()
    moment = V @ np.cross(sim.state.x, rates.p - loads)
    assert np.abs(moment).max() < 1e-11 * (V @ np.abs(rates.p)).max()


def test_the_volume_is_kept_and_the_budget_closes():
    rests = []
    for cfl in (0.2, 0.1):
        sim = spun(FULL, cfl=cfl, integrator=sph.TVDRK2())
        history = sim.run(record=[EnergyBudget()])
        for name in ("dissipation_p", "dissipation_J"):
            assert history[f"{name} [J]"][-1] < 0.0
        assert history["work_momentum_correction [J]"][-1] != 0.0
        rests.append(abs(history["energy_rest [J]"][-1]))
    assert rests[1] < 0.35 * rests[0]
    assert abs(sim.cloud.V @ sim._rhs.terms[0].D_J) < 1e-12 * sim.cloud.V @ abs(
        sim._rhs.terms[0].D_J
    )


def test_a_stiff_biharmonic_operator_shortens_the_step():
    by_spacing = sph.JST(length="spacing")
    narrow = block(by_spacing, jitter=0.0, smoothing=sph.WendlandC2(), h_over_dx=0.77)
    wide = block(by_spacing, jitter=0.0)
    assert narrow._rhs.terms[0].rate > 2.0 * wide._rhs.terms[0].rate
    # The paper's step is left alone, that of position Verlet is not.
    paper = block(sph.JST(), jitter=0.0, integrator=sph.TVDRK2(), cfl=0.3)
    assert paper.stable_time_step() < paper._rhs.largest_step(paper.state)
    strong = block(sph.JST(eps_p4=8.0), jitter=0.0)
    term = strong._rhs.terms[0]
    dt = strong.stable_time_step()
    w = 2.0 * term.wave_speed / strong.cloud.h_min
    assert (w * dt) ** 2 + 2.0 * term.rate * dt == pytest.approx(3.6, rel=1e-12)
    D = term._damped(np.eye(strong.cloud.size), 0.0, 8.0)
    assert term.rate == pytest.approx(1.05 * np.abs(np.linalg.eigvals(D)).max(), rel=0.03)


# ------------------------------------------------------------------ what is refused
@pytest.mark.parametrize(
    "wrong",
    [
        {"eps_p2": -0.1}, {"eps_p4": 11.0}, {"eps_J2": np.nan}, {"eps_J4": "some"},
        {"eps_p4": 0.0}, {"eps_p4": True}, {"length": "h"}, {"keeps_momenta": 1},
        {"weighting": 3}, {"weighting": sph.SelfAdjoint(), "eps_p2": 0.1},
    ],
    ids=str,
)  # fmt: skip
def test_what_makes_no_sense_is_refused(wrong):
    with pytest.raises(InputError, match="JST"):
        sph.JST(**wrong)


def test_a_dissipation_of_a_J_that_is_not_solved_is_refused():
    with pytest.raises(InputError, match="does not solve; use PFJ"):
        spun(FULL, formulation=sph.PF())
