"""The highest frequency against a dense eigenvalue, and the step that follows from it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import sphsolid as sph
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.geometry import Box, TetBox
from sphsolid.scenes import Constraint, Scene
from sphsolid.scheme.elastic_response import highest_frequency
from tests.oracles.dense import dense

SOLID = sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.3, density=1100.0)


def started(body: Any, constraints: tuple[Constraint, ...] = ()) -> sph.Simulation:
    scene = Scene(
        name="block", body=body, material=SOLID, end_time=1.0, constraints=constraints
    )
    return sph.Simulation(scene, spacing=1 / 3, formulation=sph.PF())


def dense_frequency(sim: sph.Simulation) -> float:
    """From the stiffness matrix, assembled; free bodies only."""
    G = dense(sim.cloud.pairs, sim.cloud.gradients.kinematic, sim.cloud.size)
    mu = SOLID.mu
    lam = SOLID.kappa - 2.0 * mu / 3.0
    V = sim.cloud.V
    product = np.einsum("c,cad,cbe->adbe", V, G, G)
    same = np.einsum("adbd->ab", product)
    stiffness = lam * product + mu * np.einsum("adbe->aebd", product)
    for d in range(3):
        stiffness[:, d, :, d] += mu * same
    n = 3 * sim.cloud.size
    mass = np.repeat(SOLID.density * V, 3)
    return float(np.sqrt(eigh(stiffness.reshape(n, n), np.diag(mass), eigvals_only=True)[-1]))


@pytest.mark.parametrize("body", [Box(), Box(jitter=0.4), TetBox()], ids=["box", "jitter", "tet"])
def test_the_highest_frequency_is_that_of_the_dense_matrix(body: Any) -> None:
    sim = started(body)
    exact = dense_frequency(sim)
    found = highest_frequency(sim._rhs)
    assert 0.93 * exact < found < 1.0000001 * exact


def test_constraints_do_not_raise_it() -> None:
    free, clamped = started(TetBox()), started(TetBox(), (Constraint("Y-", "all"),))
    assert highest_frequency(clamped._rhs) <= 1.02 * highest_frequency(free._rhs)


def test_a_cfl_number_counts_the_length_that_the_cloud_resolves() -> None:
    speed = reference_p_wave_speed(SOLID)
    lattice = started(Box())
    assert lattice.stable_time_step() == pytest.approx(0.7 * lattice.cloud.h_min / speed)
    tet = started(TetBox())
    step = 1.4 / highest_frequency(tet._rhs)
    assert step < 0.7 * tet.cloud.h_min / speed
    assert tet.stable_time_step() == pytest.approx(step)


def test_a_body_with_nothing_free_limits_nothing() -> None:
    rhs = started(TetBox())._rhs
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(rhs.essential), "release", lambda _, v: v.fill(0.0))
        assert highest_frequency(rhs) == 0.0
        assert started(TetBox()).stable_time_step() > 0.0
