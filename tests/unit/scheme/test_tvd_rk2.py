"""The integrator: second order in time for every field, exact where Runge-Kutta must be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.scenes import Box, Scene
from tests.oracles.blocks import FORMULATIONS, RUBBER, loaded_block

Array = NDArray[np.float64]
SPAN = 2.0e-3


def block(formulation: Any) -> sph.Simulation:
    """The loaded block with every default but the integrator."""
    return sph.Simulation(
        loaded_block(), spacing=0.4, formulation=formulation, integrator=sph.TVDRK2()
    )


def after(formulation: Any, steps: int, **options: Any) -> dict[str, Array]:
    """Fields of the loaded block at ``SPAN`` after equal steps."""
    sim = sph.Simulation(
        loaded_block(),
        spacing=0.4,
        formulation=formulation,
        integrator=sph.TVDRK2(),
        **{"stabilisation": sph.NoStabilisation(), **options},
    )
    for _ in range(steps):
        sim.advance(SPAN / steps)
    fields = {name: getattr(sim.state, name) for name in ("p", "x", "F", "H", "J")}
    return {name: field for name, field in fields.items() if field.size}


def orders(formulation: Any, **options: Any) -> dict[str, float]:
    """Slope of the difference between successive halvings: no reference solution needed."""
    coarse, middle, fine = (after(formulation, steps, **options) for steps in (32, 64, 128))
    return {
        name: float(
            np.log2(
                np.linalg.norm(coarse[name] - middle[name])
                / np.linalg.norm(middle[name] - fine[name])
            )
        )
        for name in coarse
    }


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_every_field_is_second_order_in_time(formulation: Any) -> None:
    """With loads and a driven face that change in time: stage two uses the end of the step."""
    for name, order in orders(formulation).items():
        assert 1.9 < order < 2.15, f"{name}: order {order:.2f}"


def test_the_order_check_notices_a_load_at_the_wrong_instant(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Planted bug: both stages see the load of the start of the step."""
    right = sph.scheme.right_hand_side.RightHandSide.evaluate
    last: list[float] = []

    def late(self: Any, state: Any, geometry: Array, t: float) -> Any:
        last.append(t)
        return right(self, state, geometry, last[-2] if len(last) % 2 == 0 else t)

    monkeypatch.setattr(sph.scheme.right_hand_side.RightHandSide, "evaluate", late)
    assert orders(sph.PF())["p"] < 1.5


def test_shorter_steps_at_one_cfl_number_do_not_change_the_damping() -> None:
    """``tau_F = dt`` is the step that the CFL rule allows: the order is the integrator's own."""
    order = orders(sph.PF(), stabilisation=sph.SUPG(tau_F=1.0, xi_F=0.0))["p"]
    assert 1.9 < order < 2.15


def test_stabilisation_in_units_of_the_step_is_first_order_in_the_cfl_number() -> None:
    """``tau_F = dt`` shrinks with the CFL number: the method itself changes, as in the paper."""
    supg = sph.SUPG(tau_F=1.0, xi_F=0.0)
    coarse, middle, fine = (
        after(sph.PF(), 256, stabilisation=supg, cfl=0.3 / n)["p"] for n in (1, 2, 4)
    )
    apart = [np.linalg.norm(a - b) for a, b in ((coarse, middle), (middle, fine))]
    assert 0.8 < np.log2(apart[0] / apart[1]) < 1.3


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
def test_free_fall_is_exact(formulation: Any) -> None:
    """Uniform body force that grows linearly: ``p`` quadratic in time, which Heun integrates."""
    g = np.array([3.0, -2.0, 1.0])
    scene = Scene(
        "falling", Box(jitter=0.2), RUBBER, 1.0,
        body_force=lambda X, t: np.broadcast_to(RUBBER.density * g * t, X.shape),
        initial_velocity=lambda X: np.broadcast_to(g, X.shape),
    )  # fmt: skip
    sim = sph.Simulation(
        scene, spacing=0.5, formulation=formulation, integrator=sph.TVDRK2()
    )
    dt, steps = 5.0e-4, 10
    for _ in range(steps):
        sim.advance(dt)
    s, t = sim.snapshot(), steps * dt
    np.testing.assert_allclose(s.velocity, np.broadcast_to(g * (1 + t**2 / 2), s.X.shape))
    np.testing.assert_allclose(s.F, np.broadcast_to(np.eye(3), s.F.shape), atol=1e-13)
    # x sums (p^n + p*) / 2, and p* lacks the curvature of p: short by g dt^3 / 6 every step.
    travelled = g * (t + t**3 / 6 - steps * dt**3 / 6)
    np.testing.assert_allclose(s.displacement, np.broadcast_to(travelled, s.X.shape), atol=1e-14)


@pytest.mark.parametrize("formulation", [sph.PJ(), sph.Displacement()], ids=lambda f: f.name)
def test_a_fibre_map_that_is_not_evolved_is_that_of_the_positions(formulation: Any) -> None:
    sim = block(formulation)
    for _ in range(3):
        sim.advance(sim.stable_time_step())
    F = np.empty_like(sim.state.F)
    sim._rhs.deformation_gradient(sim.state.x, F)
    np.testing.assert_array_equal(F, sim.state.F)
