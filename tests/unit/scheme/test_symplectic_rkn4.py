"""The symplectic RKN4 step: its equations, order four, exact momenta, energy bounded, damping."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.record import EnergyBudget, MomentumDrift, write_checkpoint
from sphsolid.scenes import Box, Constraint, Scene, Traction
from sphsolid.scheme import SetUp, Stage, Term, TermOption
from sphsolid.scheme.symplectic_rkn4 import AT, DRIFTS, KICKS, LEADS_TO
from tests.oracles import timing
from tests.oracles.blocks import FORMULATIONS, RUBBER, loaded_block, spinning_block

Array = NDArray[np.float64]
RKN4 = sph.SymplecticRKN4()
DAMPED = sph.SUPG(tau_F=0.5, xi_F=0.1)
build = partial(timing.build, integrator=RKN4)
after = partial(timing.after, integrator=RKN4)
EPS = np.finfo(float).eps


# ------------------------------------------------------- the equations of the coefficients
def oscillator(w: Array, d: float = 0.0) -> Array:
    """Matrices ``(..., 2, 2)`` of one unit step of ``(w x, v)``, ``x'' = -w^2 x - d x'``."""
    M = np.zeros((*w.shape, 2, 2))
    M[..., 0, 0] = M[..., 1, 1] = 1.0
    for a, b in zip(DRIFTS, (*KICKS, 0.0), strict=True):
        M[..., 0, :] += a * w[..., None] * M[..., 1, :]
        M[..., 1, :] -= b * (w[..., None] * M[..., 0, :] + d * M[..., 1, :])
    return M


def test_the_step_is_symmetric_and_its_times_are_those_of_its_parts() -> None:
    assert DRIFTS[::-1] == DRIFTS
    assert KICKS[::-1] == KICKS
    np.testing.assert_allclose(AT, np.cumsum(DRIFTS)[:-1], atol=2 * EPS)
    np.testing.assert_allclose(LEADS_TO, np.cumsum(KICKS), atol=2 * EPS)
    assert LEADS_TO[-1] == 1.0


def test_the_conditions_of_order_four() -> None:
    b, c = np.array(KICKS), np.array(AT)
    later = np.tril(np.ones((5, 5)), -1)
    assert np.sum(b) == pytest.approx(1.0, abs=2 * EPS)
    assert b @ c**2 == pytest.approx(1 / 3, abs=2 * EPS)
    assert b @ (later * (c[:, None] - c)) @ b == pytest.approx(1 / 6, abs=2 * EPS)
    # The same of the momenta: a driven face costs no order.
    assert np.array(DRIFTS)[1:] @ np.array(LEADS_TO) ** 2 == pytest.approx(1 / 3, abs=2 * EPS)


def test_the_trace_touches_minus_one_and_turns() -> None:
    np.testing.assert_allclose(oscillator(np.array(3.15282641240044590)), -np.eye(2), atol=1e-14)
    w = np.linspace(0.01, 7.46, 20000)
    half_trace = 0.5 * np.trace(oscillator(w), axis1=-2, axis2=-1)
    assert np.max(np.abs(half_trace)) < 1.0 + 1e-13
    assert abs(0.5 * np.trace(oscillator(np.array(7.47)))) > 1.0


def test_the_phase_error() -> None:
    w = np.array([0.4, 0.2])
    phase = np.arccos(0.5 * np.trace(oscillator(w), axis1=-2, axis2=-1))
    np.testing.assert_allclose((phase - w) / w**5, -2.9e-5, rtol=0.01)


def test_small_damping_damps_every_mode_no_less_than_it_should() -> None:
    w, d = np.linspace(0.02, 7.3, 400), 1e-6
    rate = -np.log(np.max(np.abs(np.linalg.eigvals(oscillator(w, d))), axis=-1))
    assert np.min(rate) > 0.5 * d * (1.0 - 1e-3)


def test_the_limit_with_damping() -> None:
    w = np.linspace(0.02, 5.3, 400)
    for d in (0.01, 0.1, 0.2, 0.5, 1.0, 1.5, 2.0):
        assert np.max(np.abs(np.linalg.eigvals(oscillator(w, d)))) < 1.0, d
    decay = np.array([np.prod([1.0 - b * d for b in KICKS]) for d in np.linspace(0.01, 5.0, 600)])
    assert np.max(np.abs(decay)) < 1.0


# ------------------------------------------------------------------------------------ accuracy
def orders(scene: Scene, names: str, **options: Any) -> dict[str, float]:
    states = [after(scene, n, **options).state for n in (8, 16, 32)]
    found = {}
    for name in names:
        coarse, middle, fine = (getattr(state, name) for state in states)
        ratio = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
        found[name] = float(np.log2(ratio))
    return found


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PFHJ()], ids=lambda f: f.name)
def test_order_four_in_free_motion(formulation: Any) -> None:
    names = "pxF" if formulation.evolves_F else "px"
    for name, order in orders(spinning_block(), names, formulation=formulation).items():
        assert 3.9 < order < 4.2, name


def varied_block() -> Scene:
    """A body force, a traction and a driven face that are no polynomials in time."""

    def weight(X: Array, t: float) -> Array:
        return 1.0e7 * np.sin(2500.0 * t + X)

    def pulled(X: Array, N: Array, t: float) -> Array:
        return 3.0e5 * np.cos(2000.0 * t) * np.stack([X[:, 1], 1.0 - X[:, 2], X[:, 0]], axis=1)

    def driven(X: Array, t: float) -> Array:
        return 20.0 * np.sin(3000.0 * t + X[:, [1, 2, 0]])

    return Scene(
        "varied", Box(upper=(1.0, 0.8, 1.2), jitter=0.2, seed=5), RUBBER, 1.0,
        constraints=(Constraint("X-", "all", driven), Constraint("Y-", "normal")),
        tractions=(Traction("X+", pulled),), body_force=weight,
    )  # fmt: skip


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PFHJ()], ids=lambda f: f.name)
def test_order_four_survives_loads_and_a_driven_face(formulation: Any) -> None:
    names = "pxF" if formulation.evolves_F else "px"
    for name, order in orders(varied_block(), names, formulation=formulation).items():
        assert 3.8 < order < 4.3, name


def test_a_given_motion_is_followed_with_order_four() -> None:
    """Positions of driven particles are the integral of what drives them."""
    errors = []
    for steps in (4, 8):
        sim = after(varied_block(), steps, formulation=sph.Displacement())
        held = np.isclose(sim.cloud.X[:, 0], 0.0) & (sim.cloud.X[:, 1] > 0.1)
        phase = sim.cloud.X[held][:, [1, 2, 0]]
        moved = 20.0 / 3000.0 * (np.cos(phase) - np.cos(3000.0 * sim.time + phase))
        errors.append(np.max(np.abs(sim.state.x[held] - sim.cloud.X[held] - moved)))
    assert np.log2(errors[0] / errors[1]) > 3.8


# --------------------------------------------------------------------------- what it conserves
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
@pytest.mark.parametrize("stabilisation", [sph.NoStabilisation(), DAMPED], ids=lambda s: s.name)
def test_both_momenta_are_exact_with_tractions(formulation: Any, stabilisation: Any) -> None:
    if formulation == sph.Displacement() and stabilisation is DAMPED:
        stabilisation = sph.NoStabilisation()
    scene = spinning_block()
    pull = Traction("X+", lambda X, N, t: 3.0e5 * N * (1.0 + 300.0 * t))
    scene = Scene(**(vars(scene) | {"tractions": (pull,)}))
    sim = after(scene, 10, formulation=formulation, stabilisation=stabilisation)
    row = MomentumDrift().record(sim.snapshot(), scene)
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]


def test_the_momenta_of_a_driven_body_are_accounted_for() -> None:
    row = MomentumDrift().record(after(loaded_block(), 10).snapshot(), loaded_block())
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]


@pytest.mark.parametrize("scene", [spinning_block(), loaded_block()], ids=lambda s: s.name)
def test_the_energy_budget_closes_with_order_four(scene: Scene) -> None:
    left = []
    for n in (8, 16):
        sim = after(scene, n, formulation=sph.Displacement())
        left.append(abs(EnergyBudget().record(sim.snapshot(), scene)["energy_rest [J]"]))
    assert np.log2(left[0] / left[1]) > 3.8


def energies(sim: sph.Simulation, dt: float, steps: int) -> Array:
    found = []
    for _ in range(steps):
        sim.advance(dt)
        shot = sim.snapshot()
        found.append(shot.kinetic_energy + shot.strain_energy)
    return np.array(found)


def test_energy_swings_but_does_not_drift() -> None:
    # Near the limit of stability single modes of this lattice, which nothing damps, resonate with
    # the step, and the energy swings slowly by a per cent: whatever the step is, half of it does.
    sim = build(spinning_block(jitter=0.0), formulation=sph.Displacement(), cfl=0.6)
    E = energies(sim, sim.stable_time_step(), 600)
    assert np.ptp(E) < 2e-4 * E.mean()
    assert abs(E[-200:].mean() - E[:200].mean()) < 1e-5 * E.mean()


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PFHJ()], ids=lambda f: f.name)
def test_it_runs_back_to_where_it_came_from(formulation: Any) -> None:
    sim = build(spinning_block(), formulation=formulation)
    start = {name: sim.state[name].copy() for name in formulation_fields(formulation)}
    for _ in range(2):
        for _ in range(10):
            sim.advance(timing.SPAN / 10)
        sim.state.p *= -1.0
    for name, array in start.items():
        scale = max(float(np.max(np.abs(array), initial=0.0)), 1.0)
        np.testing.assert_allclose(sim.state[name], array, atol=1e-11 * scale)


def formulation_fields(formulation: Any) -> list[str]:
    return ["p", "x", *(name for name in "FHJ" if getattr(formulation, f"evolves_{name}"))]


# ---------------------------------------------------------------------- stability and damping
def noisy_block() -> Scene:
    def noise(X: Array) -> Array:
        return 1e-4 * np.random.default_rng(0).normal(size=X.shape)

    return Scene("noise", Box(), RUBBER, 1.0, initial_velocity=noise)


def test_noise_is_kept_up_to_three_times_the_step_of_verlet() -> None:
    """Position Verlet diverges at CFL 1.0 on this block."""
    kept = build(noisy_block(), formulation=sph.Displacement(), cfl=3.0)
    E = energies(kept, kept.stable_time_step(), 400)
    means = E[100:].reshape(3, 100).mean(axis=1)
    assert np.ptp(means) < 0.05 * means[0]
    gone = build(noisy_block(), formulation=sph.Displacement(), cfl=3.8)
    E = energies(gone, gone.stable_time_step(), 60)
    assert not E[-1] < 1e4 * E[0]


class Drag(Term):
    """``-d p`` in the rate of ``p``."""

    def __init__(self, rate: float) -> None:
        self._rate = rate

    def add_rates(self, stage: Stage) -> None:
        stage.rates.p[:] -= self._rate * stage.state.p


@dataclass(frozen=True)
class WithDrag(TermOption):
    """Drag of a rate in 1/s."""

    rate: float
    name: str = "drag"

    def terms(self, set_up: SetUp) -> tuple[Term, ...]:
        return (Drag(self.rate),)


def test_negative_kicks_do_not_undo_the_damping() -> None:
    """The share of the energy that is left after ``T`` is ``exp(-d T)``, of waves at any length."""
    first = build(noisy_block(), formulation=sph.Displacement(), cfl=2.0)
    dt, steps = first.stable_time_step(), 200
    d = 4.0 / (steps * dt)
    undamped = energies(first, dt, steps)[-1]
    sim = build(noisy_block(), formulation=sph.Displacement(), terms=[WithDrag(d)])
    assert energies(sim, dt, steps)[-1] / undamped == pytest.approx(np.exp(-4.0), rel=0.2)


# ------------------------------------------------------------------------------ no memory
CASES: dict[str, dict[str, Any]] = {
    "{p,F,H,J}": {"formulation": sph.PFHJ(), "stabilisation": sph.SUPG(tau_p=0.1)},
    "displacement": {"formulation": sph.Displacement()},
}


def bits(sim: sph.Simulation) -> dict[str, bytes]:
    return {name: np.ascontiguousarray(a).tobytes() for name, a in sim.state_arrays().items()}


@pytest.mark.parametrize("case", CASES)
def test_a_checkpoint_and_a_copy_are_all_there_is_to_know(case: str, tmp_path: Path) -> None:
    whole, fresh = (build(loaded_block(), **CASES[case]) for _ in range(2))
    for _ in range(3):
        whole.advance(4.0e-5)
    write_checkpoint(whole, tmp_path / "state.npz")
    fresh.restore(tmp_path / "state.npz")
    copied = copy.deepcopy(whole)
    for sim in (whole, fresh, copied):
        for _ in range(3):
            sim.advance(4.0e-5)
    assert bits(fresh) == bits(whole)
    assert bits(copied) == bits(whole)


def test_the_energy_budget_does_not_change_the_run() -> None:
    tracked = after(loaded_block(), 6, stabilisation=DAMPED)
    plain = build(loaded_block(), stabilisation=DAMPED)
    for _ in range(6):
        plain.advance(timing.SPAN / 6)
    np.testing.assert_array_equal(tracked.state.p, plain.state.p)
    np.testing.assert_array_equal(tracked.state.F, plain.state.F)
