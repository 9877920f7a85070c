"""The reaction of a side that is shaken: it carries the inertia of its particles, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.scenes import Box, Constraint, Scene

LAW = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)
OMEGA = 400.0


@pytest.mark.parametrize(
    ("formulation", "integrator", "within"),
    [
        (sph.Displacement(), sph.PositionVerlet(), 1e-12),
        (sph.PF(), sph.SSPRK3(), 0.01),
        (sph.Displacement(), sph.SSPRK3(), 0.01),
        (sph.PF(), sph.TVDRK2(), 0.06),
    ],
    ids=str,
)
def test_the_reaction_is_the_rate_of_the_momentum(
    formulation: Any, integrator: Any, within: float
) -> None:
    """Nothing else acts on the body.  Runge-Kutta has the force of a stage, not of the step."""
    way = np.array([[1.0, 0.5, 0.0]])
    shaken = Constraint("X-", "all", velocity=lambda X, t: 0.1 * np.sin(OMEGA * t) * way + 0.0 * X)
    scene = Scene("shaken", Box(), LAW, 1.0, constraints=(shaken,))
    sim = sph.Simulation(scene, spacing=0.25, formulation=formulation, integrator=integrator)
    sim.track_budget()
    reactions, rates = [], []
    before = np.zeros(3)
    dt = 0.3 * sim.stable_time_step()
    for _ in range(60):
        sim.advance(dt)
        momentum = sim.cloud.V @ sim.snapshot().momentum
        rates.append((momentum - before) / dt)
        reactions.append(sim.snapshot().budget.reaction_force["X-"])
        before = momentum
    off = np.abs(np.array(reactions) - np.array(rates))[10:]
    assert off.max() < within * np.abs(rates).max()


@pytest.mark.parametrize("integrator", [sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2()], ids=str)
def test_the_work_of_a_motion_closes_the_budget_to_second_order(integrator: Any) -> None:
    """Of a side that speeds up: its work is that of the mean velocity of a step."""

    def pull(X: Any, t: float) -> Any:
        return np.array([0.0, 0.0, 2.0 * np.sin(150.0 * t) ** 2]) + 0.0 * X

    constraints = (Constraint("Z-", "all"), Constraint("Z+", "all", velocity=pull))
    scene = Scene("pulled", Box(), LAW, 0.01, constraints=constraints)
    left = []
    for steps in (24, 48):
        sim = sph.Simulation(scene, spacing=0.25, formulation=sph.PF(), integrator=integrator)
        sim.track_budget()
        for _ in range(steps):
            sim.advance(0.01 / steps)
        shot = sim.snapshot()
        energy = shot.kinetic_energy + shot.strain_energy
        left.append(abs(energy - sum(shot.budget.works.values())) / energy)
    assert left[0] < 0.02
    assert np.log2(left[0] / left[1]) > 1.8
