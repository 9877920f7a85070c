"""Position Verlet: one evaluation a step, reversible, exact angular momentum, nothing hidden."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.record import MomentumDrift, write_checkpoint
from sphsolid.scenes import Box, Scene, Traction
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.time_step import STRETCH
from tests.oracles import timing
from tests.oracles.blocks import FORMULATIONS, RUBBER, loaded_block, pulled, spinning_block

VERLET = sph.PositionVerlet()
UNDAMPED = sph.NoStabilisation()
DAMPED = sph.SUPG(tau_F=0.5, xi_F=0.1)
build = partial(timing.build, integrator=VERLET)
after = partial(timing.after, integrator=VERLET)
orders = partial(timing.orders, integrator=VERLET)


# ----------------------------------------------------------------- accuracy
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_order_of_free_motion_in_time(formulation: Any) -> None:
    for name, order in orders(spinning_block(), "pxF", formulation=formulation).items():
        assert 1.9 < order < 2.2, name


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ()], ids=lambda f: f.name)
def test_order_with_every_load_and_a_driven_face(formulation: Any) -> None:
    for name, order in orders(loaded_block(), "pxF", formulation=formulation).items():
        assert 1.9 < order < 2.2, name


@pytest.mark.parametrize(("tau_p", "least"), [(0.0, 1.8), (0.004, 1.6)])
def test_damping_that_lags_costs_little_of_the_order(tau_p: float, least: float) -> None:
    """The same damping at every step: first order in ``dt D``, and small."""
    # In seconds half of the longest step, and a tenth of it.
    supg = sph.SUPG(tau_F=sph.OfMesh(0.02), xi_F=0.1, tau_p=sph.OfMesh(tau_p))
    runs = []
    for n in (32, 64, 128):
        runs.append(after(spinning_block(), n, formulation=sph.PFHJ(), stabilisation=supg))
    for name in ("p", "x", "F", "J"):
        coarse, middle, fine = (getattr(sim.state, name) for sim in runs)
        ratio = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
        assert np.log2(ratio) > least, name
    undamped = after(spinning_block(), 128, formulation=sph.PFHJ()).state
    effect = np.linalg.norm(runs[-1].state.p - undamped.p)
    assert np.linalg.norm(runs[1].state.p - runs[2].state.p) < 0.01 * effect


def test_free_fall_is_exact_with_a_force_linear_in_time() -> None:
    g = 1e6 * np.array([3.0, -2.0, 1.0])
    scene = Scene(
        "falling", Box(jitter=0.2), RUBBER, 1.0,
        body_force=lambda X, t: np.broadcast_to(RUBBER.density * g * t, X.shape),
    )  # fmt: skip
    sim = build(scene)
    for _ in range(8):
        sim.advance(5.0e-4)
    v = sim.snapshot().velocity
    np.testing.assert_allclose(v, np.broadcast_to(g * sim.time**2 / 2, v.shape), rtol=1e-10)


# ---------------------------------------------------------------- structure
def test_all_formulations_are_one_method_without_stabilisation() -> None:
    """``H = cof F``, ``J = det F``, ``F = F_x``: the drift is exact, whatever is evolved."""
    runs = [after(spinning_block(), 40, formulation=f) for f in FORMULATIONS]
    for sim in runs:
        np.testing.assert_allclose(sim.state.x, runs[0].state.x, atol=1e-12)
        np.testing.assert_allclose(sim.state.F, runs[0].state.F, atol=1e-11)
        entries = split(sim.state.F)
        if sim.formulation.evolves_H:
            np.testing.assert_allclose(sim.state.H, join(cofactor(entries)), atol=1e-12)
        if sim.formulation.evolves_J:
            np.testing.assert_allclose(sim.state.J, determinant(entries), atol=1e-12)
    # And F has changed by much more than that.
    assert np.max(np.abs(runs[0].state.F - build(spinning_block()).state.F)) > 0.1


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_it_runs_back_to_where_it_came_from(formulation: Any) -> None:
    """Time-reversible: with ``-p`` the same steps lead back, at any size of step."""
    sim = build(spinning_block(), formulation=formulation)
    start = {name: array.copy() for name, array in sim.state.items()}
    for _ in range(2):
        for _ in range(30):
            sim.advance(timing.SPAN / 30)
        sim.state.p *= -1.0
    # What the step is taken from is of the last evaluation, not of the end.
    start.pop(STRETCH, None)
    for name, array in start.items():
        scale = max(float(np.max(np.abs(array), initial=0.0)), 1.0)
        np.testing.assert_allclose(getattr(sim.state, name), array, atol=1e-11 * scale)


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
@pytest.mark.parametrize("stabilisation", [UNDAMPED, sph.SUPG()], ids=lambda s: s.name)
def test_angular_momentum_is_exact_with_tractions(formulation: Any, stabilisation: Any) -> None:
    scene = spinning_block()
    scene = Scene(**(vars(scene) | {"tractions": (Traction("X+", pulled),)}))
    sim = after(scene, 20, formulation=formulation, stabilisation=stabilisation)
    row = MomentumDrift().record(sim.snapshot(), scene)
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]


def test_the_account_of_both_momenta_holds_with_a_driven_face() -> None:
    row = MomentumDrift().record(after(loaded_block(), 20).snapshot(), loaded_block())
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]


def test_projecting_with_the_positions_of_the_start_loses_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Planted: ``F_x`` half a step late."""
    right = RightHandSide.evaluate

    def late(
        self: RightHandSide, state: Any, geometry: Any, t: float, **known: bool
    ) -> Any:
        start = geometry - 0.5 * timing.SPAN / 20 / self.material.density * state.p
        return right(self, state, start, t, **known)

    monkeypatch.setattr(RightHandSide, "evaluate", late)
    sim = after(spinning_block(), 20, stabilisation=sph.SUPG())
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["angular_drift [kg m^2/s]"] > 1e-9 * row["angular_scale [kg m^2/s]"]


def test_one_evaluation_and_one_gradient_of_the_velocities_a_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sim = build(spinning_block(), stabilisation=DAMPED)
    called = {"evaluate": 0, "kinematic_gradient": 0}
    for name in called:

        def counted(
            *arguments: Any, name: str = name, right: Any = getattr(sim._rhs, name), **known: bool
        ) -> Any:
            called[name] += 1
            return right(*arguments, **known)

        monkeypatch.setattr(sim._rhs, name, counted)
    for _ in range(5):
        sim.advance(1.0e-5)
    assert called == {"evaluate": 5, "kinematic_gradient": 6}


# --------------------------------------------------------------- no memory
CASES: dict[str, dict[str, Any]] = {
    "{p,F}": {"formulation": sph.PF(), "stabilisation": DAMPED},
    "{p,F,H,J}": {"formulation": sph.PFHJ(), "stabilisation": sph.SUPG(tau_p=0.1)},
    "displacement": {"formulation": sph.Displacement()},
}


def bits(sim: sph.Simulation) -> dict[str, bytes]:
    return {name: np.ascontiguousarray(a).tobytes() for name, a in sim.state_arrays().items()}


@pytest.mark.parametrize("case", CASES)
def test_a_checkpoint_is_all_there_is_to_know(case: str, tmp_path: Path) -> None:
    """The gradient kept from the last step is that of the restored momentum, bit for bit."""
    whole, fresh, other = (build(loaded_block(), **CASES[case]) for _ in range(3))
    for sim in (whole, other):
        for _ in range(5 if sim is whole else 2):
            sim.advance(1.0e-5)
    write_checkpoint(whole, tmp_path / "state.npz")
    # Into an object that has not run, and into one that holds another gradient.
    for sim in (fresh, other):
        sim.restore(tmp_path / "state.npz")
    for sim in (whole, fresh, other):
        for _ in range(5):
            sim.advance(1.0e-5)
    assert bits(fresh) == bits(whole)
    assert bits(other) == bits(whole)


def test_a_state_changed_from_outside_is_seen() -> None:
    one, other = build(spinning_block()), build(spinning_block())
    one.advance(1.0e-5)
    for name, array in one.state.items():
        getattr(other.state, name)[:] = array
    for sim in (one, other):
        sim.state.p[3] += 500.0
        sim.advance(1.0e-5)
    assert bits(one) == bits(other)


def test_the_account_does_not_change_the_run() -> None:
    with_account = after(loaded_block(), 10, stabilisation=DAMPED)
    without = build(loaded_block(), stabilisation=DAMPED)
    for _ in range(10):
        without.advance(timing.SPAN / 10)
    np.testing.assert_array_equal(with_account.state.p, without.state.p)
    np.testing.assert_array_equal(with_account.state.F, without.state.F)
