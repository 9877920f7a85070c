"""Position Verlet: the energy budget closes, and nothing drifts, grows or is lost to the step."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.record import Budget, EnergyBudget
from sphsolid.scenes import Box, Scene
from tests.oracles import timing
from tests.oracles.blocks import FORMULATIONS, RUBBER, loaded_block, spinning_block

VERLET = sph.PositionVerlet()
UNDAMPED = sph.NoStabilisation()
DAMPED = sph.SUPG(tau_F=0.5, xi_F=0.1)
build = partial(timing.build, integrator=VERLET)
after = partial(timing.after, integrator=VERLET)


def rest(sim: sph.Simulation) -> float:
    return abs(EnergyBudget().record(sim.snapshot(), sim.scene)["energy_rest [J]"])


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_the_ledger_closes_with_the_order_of_the_method(formulation: Any) -> None:
    left = [rest(after(spinning_block(), n, formulation=formulation)) for n in (40, 80, 160)]
    assert np.log2(left[1] / left[2]) > 1.8, left


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ()], ids=lambda f: f.name)
def test_the_ledger_holds_with_every_load(formulation: Any) -> None:
    """A face driven with varying speed, tractions, weight, damping: nothing is forgotten."""
    left = []
    for steps in (40, 80):
        sim = after(loaded_block(), steps, formulation=formulation, stabilisation=DAMPED)
        balance = sim.snapshot().budget
        assert isinstance(balance, Budget)
        left.append(rest(sim) / sum(abs(work) for work in balance.works.values()))
    assert left[1] < 1e-3
    assert left[0] / left[1] > 1.9


def energies(sim: sph.Simulation, dt: float, steps: int) -> np.ndarray:
    found = []
    for _ in range(steps):
        sim.advance(dt)
        shot = sim.snapshot()
        found.append(shot.kinetic_energy + shot.strain_energy)
    return np.array(found)


def test_energy_swings_but_does_not_drift() -> None:
    """The means of the first and the last third of a long undamped run agree far better than
    the energy swings about them."""
    sim = build(spinning_block(jitter=0.0))
    E = energies(sim, 0.4 * sim.stable_time_step(), 1500)
    swing, first, last = np.ptp(E), E[:500].mean(), E[-500:].mean()
    assert swing < 0.03 * E.mean()
    assert abs(last - first) < 0.2 * swing


def noisy_block() -> Scene:
    def noise(X: Any) -> Any:
        # Large enough that the energy stands clear of the round-off in W(F) - W(I).
        return 1e-4 * np.random.default_rng(0).normal(size=X.shape)

    return Scene("noise", Box(), RUBBER, 1.0, initial_velocity=noise)


def test_noise_neither_grows_nor_decays_where_two_stages_let_it_grow() -> None:
    """A free block at rest with noise in p, no stabilisation, ``w dt`` up to 1.4."""
    lost = build(noisy_block(), integrator=sph.TVDRK2(), cfl=0.5)
    E = energies(lost, lost.stable_time_step(), 40)
    assert E[-1] > 1e4 * E[0]
    kept = build(noisy_block(), cfl=0.6)
    E = energies(kept, kept.stable_time_step(), 600)
    # Potential and kinetic energy part in the first hundred steps; then nothing happens.
    means = E[100:].reshape(5, 100).mean(axis=1)
    assert np.ptp(means) < 0.06 * means[0]


def test_it_is_lost_at_once_beyond_its_limit() -> None:
    sim = build(noisy_block(), cfl=1.1)
    E = energies(sim, sim.stable_time_step(), 12)
    assert not E[-1] < 1e6 * E[0]
