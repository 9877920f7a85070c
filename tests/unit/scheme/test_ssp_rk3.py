"""Three-stage Runge-Kutta: third order, exact angular momentum, no growth of undamped modes."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.record import Budget, EnergyBudget, MomentumDrift
from sphsolid.scenes import Box, Scene, Traction
from sphsolid.scheme import ssp_rk3
from tests.oracles import timing
from tests.oracles.blocks import FORMULATIONS, RUBBER, loaded_block, pulled, spinning_block

THIRD = sph.SSPRK3()
UNDAMPED = sph.NoStabilisation()
build = partial(timing.build, integrator=THIRD)
after = partial(timing.after, integrator=THIRD)
orders = partial(timing.orders, integrator=THIRD)


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_order_of_free_motion_in_time(formulation: Any) -> None:
    """Three; two where ``F`` comes from the positions (a symplectic method)."""
    low, high = (2.8, 3.3) if formulation.evolves_F else (1.9, 2.7)
    for name, order in orders(spinning_block(), "pxF", formulation=formulation).items():
        assert low < order < high, name


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ()], ids=lambda f: f.name)
def test_loads_and_a_driven_face_keep_at_least_second_order(formulation: Any) -> None:
    """The stages of a face driven with varying speed are only second order, as for any RK."""
    assert orders(loaded_block(), "p", formulation=formulation)["p"] > 1.9


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
@pytest.mark.parametrize("stabilisation", [UNDAMPED, sph.SUPG()], ids=lambda s: s.name)
def test_angular_momentum_is_exact_with_tractions(formulation: Any, stabilisation: Any) -> None:
    scene = spinning_block()
    scene = Scene(**(vars(scene) | {"tractions": (Traction("X+", pulled),)}))
    sim = after(scene, 20, formulation=formulation, stabilisation=stabilisation)
    row = MomentumDrift().record(sim.snapshot(), scene)
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]


def test_displacement_sph_needs_no_projection() -> None:
    """``F`` is that of the positions the stage is projected with: ``P F_x^T`` is symmetric."""
    sim = after(
        spinning_block(), 20, formulation=sph.Displacement(),
        angular_momentum=sph.NoProjection(),
    )  # fmt: skip
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]


def test_projecting_with_the_runge_kutta_positions_loses_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Planted: the stage positions of the plain method, second order but not the right ones."""

    def plain(x: Any, factor: float, weights: Any, p_0: Any, p_1: Any, out: Any) -> None:
        weights = {5 / 6: (1.0, 0.0)}.get(weights[0], weights)
        out[:] = x + factor * (weights[0] * p_0 + weights[1] * p_1)

    monkeypatch.setattr(ssp_rk3, "moved", plain)
    sim = after(spinning_block(), 20, stabilisation=sph.SUPG())
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["angular_drift [kg m^2/s]"] > 1e-9 * row["angular_scale [kg m^2/s]"]


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_the_ledger_closes_with_the_order_of_the_method(formulation: Any) -> None:
    left = []
    for steps in (40, 80):
        sim = after(spinning_block(), steps, formulation=formulation, stabilisation=sph.SUPG())
        left.append(abs(EnergyBudget().record(sim.snapshot(), sim.scene)["energy_rest [J]"]))
    assert np.log2(left[0] / left[1]) > (2.8 if formulation.evolves_F else 1.9)


def test_the_ledger_holds_with_every_load() -> None:
    sim = after(loaded_block(), 80, stabilisation=sph.SUPG())
    balance = sim.snapshot().budget
    assert isinstance(balance, Budget)
    rest = abs(EnergyBudget().record(sim.snapshot(), sim.scene)["energy_rest [J]"])
    assert rest < 1e-4 * sum(abs(work) for work in balance.works.values())


def test_free_fall_is_exact_with_a_quadratic_force() -> None:
    g = 1e6 * np.array([3.0, -2.0, 1.0])
    scene = Scene(
        "falling", Box(jitter=0.2), RUBBER, 1.0,
        body_force=lambda X, t: np.broadcast_to(RUBBER.density * g * t**2, X.shape),
    )  # fmt: skip
    sim = build(scene)
    for _ in range(8):
        sim.advance(5.0e-4)
    t = sim.time
    s = sim.snapshot()
    np.testing.assert_allclose(s.velocity, np.broadcast_to(g * t**3 / 3, s.X.shape), rtol=1e-10)


@pytest.mark.parametrize("integrator", [sph.TVDRK2(), THIRD], ids=lambda i: i.name)
def test_a_momentum_that_nothing_changes_keeps_its_bits(integrator: Any) -> None:
    drift = np.array([0.1, -0.7, 1.0 / 3.0])
    scene = Scene(
        "drifting", Box(), RUBBER, 1.0, initial_velocity=lambda X: np.broadcast_to(drift, X.shape)
    )
    sim = build(scene, integrator=integrator)
    sim.state.F[:] = np.eye(3)
    start = sim.state.p.copy()
    stages = sim._stepper.work
    for rate in stages.rates:
        rate[:] = 0.0
    for _ in range(100):
        stages.first(0.1)
        for share in (0.75, 1.0 / 3.0, 0.5):
            stages.convex(share, 0.1)
    np.testing.assert_array_equal(sim.state.p, start)


def test_undamped_noise_decays_where_two_stages_let_it_grow() -> None:
    """A free block at rest with noise in p, no stabilisation, w dt up to one."""

    def noise(X: Any) -> Any:
        return 1e-6 * np.random.default_rng(0).normal(size=X.shape)

    scene = Scene("noise", Box(), RUBBER, 1.0, initial_velocity=noise)
    kept = {}
    for integrator in (sph.TVDRK2(), THIRD):
        sim = sph.Simulation(
            scene, spacing=0.25, formulation=sph.PF(), integrator=integrator, cfl=0.4,
            stabilisation=UNDAMPED,
        )  # fmt: skip
        start = sim.snapshot().kinetic_energy
        for _ in range(400):
            sim.advance(sim.stable_time_step())
        end = sim.snapshot()
        kept[integrator.name] = (end.kinetic_energy + end.strain_energy) / start
    assert kept["TVD-RK2"] > 10.0
    assert kept["SSP-RK3"] < 1.0
