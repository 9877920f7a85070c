"""``SelfAdjoint``: a dissipation that cannot make energy, at any state and any ``tau_F``."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.scenes import Box, Scene
from sphsolid.scheme.energy_budget import StageBudget
from tests.oracles.blocks import RUBBER
from tests.oracles.checkers import rates_at

TAU, DT, ROUND_OFF = 0.7, 1.0e-4, 1e-12


def rough(*, jitter: float, weighting: Any, **options: Any) -> sph.Simulation:
    """A free block, turned, deformed, and with fields that fit neither it nor each other."""
    scene = Scene("rough", Box(jitter=jitter, seed=1), RUBBER, 1.0)
    sim = sph.Simulation(
        scene,
        spacing=0.2,
        formulation=sph.PFHJ(),
        stabilisation=sph.SUPG(tau_F=TAU, xi_F=0.0, weighting=weighting, **options),
    )
    random, s = np.random.default_rng(3), sim.state
    A = np.linalg.qr(random.normal(size=(3, 3)))[0]
    A = A * np.linalg.det(A) @ np.diag([1.3, 0.8, 1.1])
    s.x[:] = sim.cloud.X @ A.T + 0.01 * random.normal(size=s.x.shape)
    sim._rhs.kinematic_gradient(s.x, 1.0, s.F)
    s.F += 0.03 * random.normal(size=s.F.shape)
    s.J[:] = np.linalg.det(s.F) * (1.0 + 0.01 * random.normal(size=s.J.shape))
    s.H[:] = np.linalg.det(s.F)[:, None, None] * np.linalg.inv(s.F).transpose(0, 2, 1)
    s.p[:] = 1100.0 * random.normal(size=s.p.shape)
    return sim


def evaluated(sim: sph.Simulation) -> StageBudget:
    """The budget of one evaluation, for one second."""
    sim.track_budget()
    budget = sim._stepper.budget
    assert isinstance(budget, StageBudget)
    rates_at(sim, step=DT)
    budget.stage(sim.state, sim.state.x, 1.0, 0.0)
    return budget


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize("secondary", [sph.H1(), sph.H6()], ids=str)
def test_its_power_is_minus_a_square(jitter: float, secondary: Any) -> None:
    sim = rough(jitter=jitter, weighting=sph.SelfAdjoint(), secondary=secondary)
    budget, q = evaluated(sim), sim.secondary
    assert q is not None
    square = np.sum(q.V[:, None, None] * sim._rhs.terms[0].P_fine**2) / (TAU * DT * RUBBER.kappa)
    assert budget.works[5] == pytest.approx(-square, rel=ROUND_OFF)
    # Without the second half the power of the same state is something else.
    printed = evaluated(rough(jitter=jitter, weighting=sph.AsPrinted(), secondary=secondary))
    assert abs(printed.works[5] / budget.works[5] - 1.0) > 1e-2


def test_neither_momentum_sees_it() -> None:
    sim = rough(jitter=0.2, weighting=sph.SelfAdjoint())
    evaluated(sim)
    D = sim._rhs.terms[0].dissipation(sim._rhs.stage)
    force = sim.cloud.V[:, None] * D
    assert np.max(np.abs(force.sum(axis=0))) < ROUND_OFF * np.abs(force).sum()
    torque = np.cross(sim.state.x, force)
    assert np.max(np.abs(torque.sum(axis=0))) < ROUND_OFF * np.abs(torque).sum()


def test_a_rotation_is_not_damped_however_rough_the_state() -> None:
    sim = rough(jitter=0.2, weighting=sph.SelfAdjoint())
    s = sim.state
    sim._rhs.kinematic_gradient(s.x, 1.0, s.F)
    s.p[:] = 1100.0 * np.cross([1.0, 2.0, 3.0], s.x)
    rates_at(sim, step=DT)
    assert np.max(np.abs(sim._rhs.terms[0].P_fine)) < 1e-10 * TAU * DT * RUBBER.kappa


def test_the_other_fine_scale_forms_have_no_adjoint() -> None:
    with pytest.raises(sph.InputError, match="SimplifiedHessian"):
        sph.SUPG(weighting=sph.SelfAdjoint(), fine_scale=sph.FullHessian())
    with pytest.raises(sph.InputError, match=r"AsPrinted\(\) or SelfAdjoint\(\)"):
        sph.SUPG(weighting="self-adjoint")  # type: ignore[arg-type]
