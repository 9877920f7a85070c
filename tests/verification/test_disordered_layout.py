"""On a disordered cloud every operator is stored pair by pair, and the sums are complete.

On 17^3 particles with a little disorder many secondary particles see the same pattern of
neighbours, so that their rows could be stored as runs; tensors there lie particle by particle, and
a sum over pairs would leave such rows out.  That happened, unseen by tests on smaller clouds.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry import Box
from sphsolid.scenes import swinging_cube


@pytest.fixture(scope="module")
def simulation() -> sph.Simulation:
    scene = swinging_cube(family="A+B+C=0", amplitude=1e-7)
    disordered = dataclasses.replace(scene, body=Box(jitter=0.2, seed=1))
    return sph.Simulation(
        disordered, spacing=1 / 16, formulation=sph.PF(), operator=sph.Consistent()
    )


def test_no_operator_has_runs_where_tensors_lie_particle_by_particle(simulation):
    assert simulation.cloud.particle_major
    for operator in (
        simulation.cloud.kinematic,
        simulation.cloud.adjoint,
        simulation.secondary.sampling,
        simulation.secondary.spreading,
    ):
        assert len(operator.stencil) == 0


def test_the_first_steps_follow_the_exact_motion(simulation):
    exact = simulation.scene.known_solution()
    for _ in range(4):
        simulation.advance(simulation.stable_time_step())
    now = simulation.snapshot()
    momentum = now.density * exact.velocity(now.X, now.time)
    error = np.max(np.abs(now.momentum - momentum))
    assert error < 0.05 * np.max(np.abs(exact.velocity(now.X, 0.25 * exact.period))) * now.density
