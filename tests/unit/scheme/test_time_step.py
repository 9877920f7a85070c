"""The stable step by hand, and the check that there still is a solution."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.continuum.wave_speed import GROWN
from sphsolid.errors import Diverged, InputError
from sphsolid.scenes import swinging_cube
from sphsolid.scheme.right_hand_side import State
from sphsolid.scheme.time_step import TimeStep, check_cfl
from tests.oracles.blocks import spinning_block
from tests.oracles.laws import LAWS

Array = NDArray[np.float64]
N = 6
X = np.random.default_rng(1).uniform(size=(N, 3))


def rotation() -> Array:
    Q, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return Q * np.linalg.det(Q)


def stable(F: Array, *, J: Array | None = None, p: Array | None = None, cfl: float = 0.3) -> float:
    """The step of ``N`` particles, ``h_min = 0.1`` m, ``c_p = 50`` m/s, at 0.25 s, step 17."""
    rule = TimeStep(cfl=cfl, h_min=0.1, wave_speed=50.0, size=N)
    formulation = sph.PF() if J is None else sph.PFJ()
    state = State.zeros(formulation.fields, N, particle_major=False)
    state.F[:] = F
    state.p[:] = 0.0 if p is None else p
    state.J[:] = 0.0 if J is None else J
    return rule.stable(state, X, 0.25, 17)


def undeformed() -> Array:
    return np.broadcast_to(np.eye(3), (N, 3, 3)).copy()


def test_the_undeformed_step_is_cfl_times_spacing_over_wave_speed() -> None:
    assert stable(undeformed()) == pytest.approx(0.3 * 0.1 / 50.0, rel=1e-15)
    assert stable(undeformed(), cfl=0.6) == pytest.approx(0.6 * 0.1 / 50.0, rel=1e-15)


def share(stretches: Array) -> Array:
    """The smallest stretch, over what the volume grew by where that is more than ``GROWN``."""
    J = np.prod(stretches, axis=-1)
    return np.asarray(np.min(stretches, axis=-1) / np.maximum(1.0, J / GROWN))


@pytest.mark.parametrize("stretches", [(0.5, 1.0, 1.2), (1.5, 2.0, 3.0), (0.01, 5.0, 5.0)])
def test_the_smallest_stretch_of_any_particle_limits_the_step(
    stretches: tuple[float, float, float],
) -> None:
    """Rotations before and after do not count; the worst particle does."""
    F = 1.02 * undeformed()
    F[4] = rotation() @ np.diag(stretches) @ rotation().T @ rotation()
    expected = 0.3 * 0.1 / 50.0 * min(float(share(np.array(stretches))), 1.02)
    assert stable(F) == pytest.approx(expected, rel=1e-9)


def test_random_stretches_agree_with_singular_values() -> None:
    F = undeformed() + 0.4 * np.random.default_rng(5).uniform(-1.0, 1.0, (N, 3, 3))
    assert np.all(np.linalg.det(F) > 0.0)
    least = np.min(share(np.linalg.svd(F, compute_uv=False)))
    assert stable(F) == pytest.approx(0.3 * 0.1 / 50.0 * least, rel=1e-10)


def lost(caught: pytest.ExceptionInfo[Diverged], particle: int, reason: str) -> None:
    failure = caught.value
    assert failure.reason == reason
    assert (failure.time, failure.step, failure.particle) == (0.25, 17, particle)
    assert failure.position == tuple(X[particle])
    for part in (reason, "t = 0.25 s", "step 17", f"point {particle}", "cfl", "tau_F"):
        assert part in str(failure)


def test_a_negative_jacobian_names_the_particle() -> None:
    F = undeformed()
    F[3] = np.diag([1.0, -0.1, 1.0])
    with pytest.raises(Diverged) as caught:
        stable(F)
    lost(caught, 3, "negative Jacobian")


def test_an_evolved_volume_map_is_judged_beside_the_fibre_map() -> None:
    J = np.ones(N)
    assert stable(undeformed(), J=J) > 0.0
    J[2] = -1e-9
    with pytest.raises(Diverged) as caught:
        stable(undeformed(), J=J)
    lost(caught, 2, "negative Jacobian")
    F = undeformed()
    F[5] *= -1.0
    with pytest.raises(Diverged) as caught:
        stable(F, J=np.ones(N))
    lost(caught, 5, "negative Jacobian")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["F", "p", "J"])
def test_a_value_that_is_not_finite_names_the_particle(field: str, value: float) -> None:
    fields = {"F": undeformed(), "p": np.zeros((N, 3)), "J": np.ones(N)}
    fields[field].reshape(N, -1)[1, -1] = value
    with pytest.raises(Diverged) as caught:
        stable(fields["F"], p=fields["p"], J=fields["J"])
    lost(caught, 1, "non-finite state")


def test_the_first_of_several_lost_particles_is_named() -> None:
    F = undeformed()
    F[2] = -F[2]
    F[4] = np.nan
    with pytest.raises(Diverged) as caught:
        stable(F)
    lost(caught, 2, "negative Jacobian")


@pytest.mark.parametrize("cfl", [0.0, -0.3, math.nan, math.inf, 1.0e6])
def test_a_wrong_cfl_is_refused(cfl: float) -> None:
    with pytest.raises(InputError, match=r"cfl = .* 0\.3"):
        check_cfl(cfl)


def test_a_simulation_asks_with_its_own_state() -> None:
    """The cube's published wave speed, 144.24 m/s, and the smallest distance on the cloud."""
    sim = sph.Simulation(swinging_cube(amplitude=1e-9), spacing=0.25, cfl=0.2, formulation=sph.PF())
    assert sim.stable_time_step() == pytest.approx(0.2 * 0.25 / 144.24, rel=1e-4)
    disordered = sph.Simulation(
        swinging_cube(amplitude=1e-9, jitter=0.3), spacing=0.25, cfl=0.3, formulation=sph.PF()
    )
    d = disordered.cloud.X[:, None] - disordered.cloud.X[None]
    distance = np.linalg.norm(d, axis=2) + np.eye(len(d))
    expected = 0.3 * np.min(distance) / 144.24
    assert disordered.stable_time_step() == pytest.approx(expected, rel=1e-4)
    sim.state.F[7, 0, 0] = -1.0
    with pytest.raises(Diverged) as caught:
        sim.stable_time_step()
    assert caught.value.particle == 7
    assert caught.value.position == tuple(sim.cloud.X[7])


def test_a_law_that_stiffens_with_compression_has_a_shorter_step() -> None:
    """``U'' = kappa (1 - ln J) / J^2`` at ``J = 0.85^3``; the quadratic ``U''`` stays ``kappa``."""
    law = LAWS[0]
    soft = sph.NeoHookean(mu=law.mu, kappa=law.kappa, density=law.density)
    steps = []
    for material in (law, soft):
        scene = replace(
            spinning_block(), material=material, initial_displacement=lambda X: -0.15 * X
        )
        steps.append(sph.Simulation(scene, spacing=0.25, formulation=sph.PF()).stable_time_step())
    J = 0.85**3
    assert steps[1] / steps[0] == pytest.approx(math.sqrt((1.0 - math.log(J)) / J**2), rel=1e-6)
