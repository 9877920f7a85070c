"""Two prongs, two parts: what no material joins does not feel each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.geometry import Blocks
from sphsolid.record import Probe
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene

SOLID = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)


def fork(slot: float) -> Scene:
    """Two prongs of 4 x 1 x 1 m on a clamped root, thrown apart."""
    prongs = (((1, 0, 0), (5, 1, 1)), ((1, 0, 1 + slot), (5, 1, 2 + slot)))

    def velocity(X: np.ndarray) -> np.ndarray:
        v = np.zeros_like(X)
        away = np.sign(X[:, 2] - 1 - slot / 2) * 5.0 * ((X[:, 0] - 1.0) / 4.0) ** 2
        v[:, 2] = np.where(X[:, 0] > 1.0 + 1e-9, away, 0.0)
        return v

    return Scene(
        name="fork", body=Blocks((((0, 0, 0), (1, 1, 2 + slot)), *prongs)), end_time=0.6,
        initial_velocity=velocity, constraints=(Constraint("X-", "all"),), material=SOLID,
        probes={"up": (5, 0.5, 2 + slot), "low": (5, 0.5, 0.0)},
    )  # fmt: skip


def opening(simulation, slot: float) -> float:
    sim = simulation(fork(slot), spacing=0.25)
    history = sim.run(every=0.02, record=[Probe("up"), Probe("low")])
    return float(np.max(history["up_u_z [m]"] - history["low_u_z [m]"]))


@pytest.mark.slow
@pytest.mark.parametrize("slot", [0.25, 0.5])
def test_a_slot_opens_as_with_finite_elements(slot: float) -> None:
    """As far as for B-bar elements, whether it is one spacing wide or two."""
    expected = opening(fem.Simulation, slot)
    assert opening(sph.Simulation, slot) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_a_part_at_rest_stays_at_rest_beside_one_that_moves(jitter: float) -> None:
    """A fifth of a spacing apart: nothing gets across, round-off of each part's own aside."""
    body = Blocks((((0, 0, 0), (1, 1, 1)), ((0, 0, 1.05), (1, 1, 2.05))), jitter=jitter)
    scene = replace(
        fork(0.25), body=body, constraints=(), probes={}, end_time=0.01,
        initial_velocity=lambda X: np.where(X[:, 2:] > 1.02, [[0.0, 0.0, 1.0]], 0.0),
    )  # fmt: skip
    sim = sph.Simulation(scene, spacing=0.25, operator=sph.Consistent())
    sim.run()
    end = sim.snapshot()
    above = end.X[:, 2] > 1.02
    expected = np.where(above[:, None], [[0.0, 0.0, 1.0]], 0.0)
    np.testing.assert_allclose(end.velocity, expected, atol=1e-11)
