"""The evaluation along the lines of a lattice is the general one, and a run knows no difference."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.record import EnergyBudget, MomentumDrift
from sphsolid.scenes import Box, Constraint, Scene, Traction
from sphsolid.scheme.lattice_form import LatticeRightHandSide
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State
from tests.oracles.blocks import MOONEY

SOLID = sph.NeoHookean.from_young(young_modulus=1.7e7, poisson_ratio=0.45, density=1100.0)


def rough(X):
    noise = np.random.default_rng(0).normal(size=X.shape)
    return 0.03 * np.sin(2.0 * X[:, ::-1]) + 0.004 * noise


def velocity(X):
    return np.random.default_rng(1).normal(size=X.shape)


def scene(upper=(1.0, 1.3, 0.8), material=SOLID, end=0.004, **more):
    return Scene(
        "rough", Box(upper=upper), material, end, initial_velocity=velocity,
        initial_displacement=rough, **more,
    )  # fmt: skip


HELD = {
    "constraints": (Constraint("Y-", "all"),),
    "tractions": (Traction("Y+", lambda X, N, t: np.tile([1e5, 2e5, t], (len(X), 1))),),
}
OPTIONS = {
    "usual": {},
    "order two": {"operator": sph.LatticeDifference(2)},
    "order six": {"operator": sph.LatticeDifference(6)},
    "own dilatation": {"dilatation": sph.OwnDilatation()},
    "order-one filter": {"dilatation": sph.FilteredDilatation(order=1)},
    "rest held": {"dilatation": sph.FilteredDilatation(beta=2.0)},
    "elastic, no viscosity": {
        "stabilisation": sph.Restraint(stiffness=sph.Elastic(), viscosity=0.0)
    },
    "bare": {"stabilisation": sph.NoStabilisation(), "dilatation": sph.OwnDilatation(),
             "formulation": sph.Displacement(), "operator": sph.LatticeDifference(4)},
}  # fmt: skip


def general(sim):
    """The same forces by sums over pairs and the terms' plain forms."""
    fields = sim.formulation.fields
    rhs = RightHandSide(sim._set_up, sim._rhs.terms, fields)
    state = rhs.zeros()
    state.x[:], state.p[:] = sim.state.x, sim.state.p
    return rhs.evaluate(state, state.x, 0.0, derives_F=True).p


@pytest.mark.parametrize("upper", [(1.0, 1.3, 0.8), (1.8, 0.2, 0.4), (0.6, 0.5, 1.4)])
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_the_forces_are_those_of_the_general_evaluation(options, upper):
    compared(sph.Simulation(scene(upper, **HELD), spacing=0.1, **options))


def test_the_forces_of_a_law_of_the_cofactor():
    compared(sph.Simulation(scene(material=MOONEY), spacing=0.2))


def compared(sim):
    rhs = sim._rhs
    assert isinstance(rhs, LatticeRightHandSide)
    f = rhs.evaluate(sim.state, sim.state.x, 0.0).p
    scale = np.abs(rhs.P).max() if rhs.P.size else SOLID.mu / sim.cloud.spacing
    np.testing.assert_allclose(f, general(sim), rtol=0.0, atol=1e-12 * scale)


def test_it_stores_no_strain_and_little_else():
    sim = sph.Simulation(scene((2.0, 2.0, 2.0)), spacing=0.1)
    assert set(sim.state) == {"p", "x", "smallest_stretch"}
    snapshot = sim.snapshot()
    np.testing.assert_allclose(snapshot.J, np.linalg.det(snapshot.F), rtol=1e-12)
    assert not snapshot.further


def test_the_step_follows_the_smallest_stretch():
    still = sph.Simulation(Scene("still", Box(), SOLID, 1e-3), spacing=0.125)
    pressed = Scene(
        "pressed", Box(), SOLID, 1e-3, initial_displacement=lambda X: -0.2 * X * [1.0, 0.0, 0.0]
    )
    sim = sph.Simulation(pressed, spacing=0.125)
    assert sim.stable_time_step() == pytest.approx(0.8 * still.stable_time_step(), rel=1e-9)


def test_momenta_and_the_budget_close():
    rests = []
    for cfl in (0.4, 0.2):
        sim = sph.Simulation(scene(end=0.004), spacing=0.15, cfl=cfl)
        history = sim.run(record=[EnergyBudget(), MomentumDrift()])
        rests.append(abs(history["energy_rest [J]"][-1]))
        assert history["dissipation_restraint [J]"][-1] < 0.0
    assert rests[1] < 0.35 * rests[0] < 0.01 * history["total_energy [J]"][0]
    for kind, unit in (("linear", "kg m/s"), ("angular", "kg m^2/s")):
        drift = history[f"{kind}_drift [{unit}]"].max()
        assert drift < 1e-12 * history[f"{kind}_scale [{unit}]"].max()


def test_watching_and_going_on_change_no_bit():
    def simulation():
        return sph.Simulation(scene(**HELD), spacing=0.15)

    plain, watched = simulation(), simulation()
    watched.track_budget()
    for _ in range(3):
        plain.advance(plain.stable_time_step())
        watched.snapshot()
        assert isinstance(watched.state, State)
        watched.advance(watched.stable_time_step())
    branch = copy.deepcopy(watched)
    for sim in (plain, watched, branch):
        sim.run(until=0.004)
        np.testing.assert_array_equal(plain.state.x, sim.state.x)


@pytest.mark.parametrize("integrator", [sph.TVDRK2(), sph.SSPRK3()])
def test_an_integrator_that_takes_its_own_strains_has_the_general_form(integrator):
    sim = sph.Simulation(scene(), spacing=0.25, integrator=integrator)
    assert not isinstance(sim._rhs, LatticeRightHandSide)
    sim.advance(sim.stable_time_step())
