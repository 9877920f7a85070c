"""The restraint: a potential and a dissipation potential, on any cloud and in any formulation."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import EnergyBudget
from sphsolid.scenes import Blocks, Box, Scene
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.restraint import Stiffness
from sphsolid.scheme.restraint_term import CYCLE, MOST, MOST_SPACED, PUSHES
from sphsolid.scheme.right_hand_side import RightHandSide

SOLID = sph.NeoHookean.from_young(young_modulus=1.7e7, poisson_ratio=0.3, density=1100.0)
L_SHAPE = Blocks((((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 0.5, 1.0))))
LINES = {"operator": sph.LatticeDifference(4)}


def displacement(X):
    rough = np.random.default_rng(0).normal(size=X.shape)
    return 0.02 * np.sin(3.0 * X[:, ::-1]) + 0.006 * rough


def velocity(X):
    return np.random.default_rng(1).normal(size=X.shape)


def scene(body, end=0.004):
    return Scene(
        "noisy", body, SOLID, end, initial_velocity=velocity, initial_displacement=displacement
    )


CASES = {
    "lines": (Box(upper=(1.0, 1.3, 0.8)), LINES),
    "lattice": (Box(upper=(1.0, 1.3, 0.8)), {"operator": sph.Consistent()}),
    "L-block": (L_SHAPE, {}),
    "jitter": (Box(upper=(1.0, 1.3, 0.8), jitter=0.4), {}),
}


class Body:
    """A simulation whose forces can be asked for at any velocities."""

    def __init__(self, body, restraint, **options):
        options = {"formulation": sph.Displacement(), "spacing": 0.2} | options
        self.sim = sph.Simulation(scene(body), stabilisation=restraint, **options)
        # The general evaluation, whatever the simulation has.
        self.rhs = RightHandSide(
            self.sim._set_up, self.sim._rhs.terms, self.sim.formulation.fields
        )
        self.state = self.rhs.zeros()
        for name in self.state:
            if name in self.sim.state:
                self.state[name][:] = self.sim.state[name]
        self.rhs.begin_step(Units(1.0, self.sim.stable_time_step()))
        self.p, self.x = self.state.p.copy(), self.state.x.copy()
        self.V = self.sim.cloud.V[:, None]
        self.term = self.rhs.terms[0]

    def force(self, p):
        """``V dp/dt (N, 3)`` [N]."""
        self.state.p[:] = p
        rates = self.rhs.evaluate(
            self.state, self.state.x, 0.0, derives_F=not self.sim.formulation.evolves_F
        )
        return self.V * rates.p

    def viscous(self, p):
        return self.force(p) - self.force(0.0 * p)

    def energy(self, x):
        before = self.sim._state.x.copy()
        self.sim._state.x[:] = x
        energy = self.sim.snapshot().strain_energy
        self.sim._state.x[:] = before
        return energy


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param]


@pytest.mark.parametrize(
    "stiffness",
    [sph.Quartic(), sph.Elastic(0.1, compressed=0.0), sph.Quartic(compressed=9.0)],
    ids=["quartic", "elastic", "compressed"],
)
def test_the_stiffness_is_that_of_a_potential(case, stiffness):
    body, options = case
    made = Body(body, sph.Restraint(stiffness=stiffness), **options)
    assert made.term.stored_energy(made.rhs.of_geometry(made.state)) > 0.0
    # Short beside the foot of the ramp, where the stiffness of a pressed pair begins.
    d = 1e-6 * np.random.default_rng(5).normal(size=made.x.shape)
    slope = np.dot(
        [made.energy(made.x + k * d) for k in (-2, -1, 1, 2)], [1 / 12, -2 / 3, 2 / 3, -1 / 12]
    )
    f = made.force(0.0 * made.p)
    assert abs(np.sum(f * d) + slope) < 1e-7 * np.linalg.norm(f) * np.linalg.norm(d)


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PF(), sph.PFJ()])
def test_neither_resultant_nor_moment(case, formulation):
    body, options = case
    made = Body(body, sph.Restraint(viscosity=0.1), formulation=formulation, **options)
    for f in (made.force(0.0 * made.p), made.viscous(made.p)):
        scale = np.sum(np.linalg.norm(f, axis=1))
        assert np.abs(np.sum(f, axis=0)).max() < 1e-13 * scale
        assert np.abs(np.sum(np.cross(made.x, f), axis=0)).max() < 1e-13 * scale


def test_the_viscosity_is_symmetric_takes_energy_and_leaves_rigid_motion_alone(case):
    body, options = case
    made = Body(body, sph.Restraint(), **options)
    other = 1100.0 * np.random.default_rng(9).normal(size=made.p.shape)
    f, g = made.viscous(made.p), made.viscous(other)
    assert np.sum(f * other) == pytest.approx(np.sum(g * made.p), rel=1e-9)
    assert np.sum(f * made.p) < 0.0
    made.term.keep_for_powers()
    made.force(made.p)
    (power,) = made.term.powers(made.rhs.stage)
    assert power == pytest.approx(np.sum(f * made.p) / 1100.0, rel=1e-9)
    spin = 1100.0 * (np.cross([1.0, -2.0, 0.5], made.x) + np.array([3.0, 1.0, -2.0]))
    assert np.abs(made.viscous(spin)).max() < 1e-10 * np.abs(f).max()


def test_an_affine_motion_is_not_restrained(case):
    body, options = case
    made = Body(body, sph.Restraint(stiffness=sph.Elastic()), **options)
    A = np.array([[1.2, 0.1, 0.0], [-0.1, 0.9, 0.2], [0.0, 0.1, 1.1]])
    made.state.x[:] = made.sim.cloud.X @ A.T
    state = made.rhs.of_geometry(made.state)
    assert made.term.stored_energy(state) < 1e-20 * SOLID.mu


def test_energy_falls_and_its_budget_closes_to_the_order_of_the_integrator():
    rests = []
    # Fewer steps than these have one push of the viscosity or two.
    for cfl in (0.2, 0.1):
        sim = sph.Simulation(
            scene(Box(jitter=0.3), end=4e-3), spacing=0.25, formulation=sph.Displacement(),
            stabilisation=sph.Restraint(), cfl=cfl,
        )  # fmt: skip
        history = sim.run(record=[EnergyBudget()])
        assert history["dissipation_restraint [J]"][-1] < 0.0
        rests.append(abs(history["energy_rest [J]"][-1]))
    assert rests[1] < 0.35 * rests[0]


def test_a_spaced_viscosity_takes_as_much_as_one_of_every_step():
    taken = []
    for spaced in (False, True):
        sim = sph.Simulation(
            scene(Box(jitter=0.3), end=4e-3), spacing=0.25, formulation=sph.Displacement(),
            stabilisation=sph.Restraint(spaced=spaced), cfl=0.02,
        )  # fmt: skip
        taken.append(sim.run(record=[EnergyBudget()])["dissipation_restraint [J]"][-1])
    assert taken[1] == pytest.approx(taken[0], rel=0.05)
    term = sim._rhs.terms[0]
    for _ in range(CYCLE):
        number = sim.step % CYCLE
        sim.advance(sim.stable_time_step())
        assert term.acting.viscosity == PUSHES.get(number, 0) * term.parts.viscosity


def growth(pushes, cycle, theta, damping):
    """Spectral radius of a cycle of position Verlet; a step turns by ``theta``, damped apart."""
    half, omega2 = np.array([[1.0, 0.5], [0.0, 1.0]]), (2.0 * np.sin(theta / 2.0)) ** 2
    whole = np.eye(2)
    for n in range(cycle):
        kick = np.array([[1.0, 0.0], [-omega2, 1.0 - damping * pushes.get(n, 0)]])
        whole = half @ kick @ half @ whole
    return np.abs(np.linalg.eigvals(whole)).max()


def test_the_rhythm_damps_every_oscillation():
    assert sum(PUSHES.values()) == CYCLE
    at = sorted(PUSHES)
    assert all(PUSHES[b] == (b - a) % CYCLE for a, b in zip([at[-1], *at], at, strict=False))
    angles = np.linspace(0.01, 2.0 * np.arcsin(0.75), 300)
    for damping in (1e-3, 0.01, 0.05, 0.1, 0.2, MOST_SPACED):
        assert max(growth(PUSHES, CYCLE, angle, damping) for angle in angles) < 1.0
    # Equal intervals do not.
    for interval in (2, 4):
        pushes = {0: interval}
        assert max(growth(pushes, interval, angle, 0.01) for angle in angles) > 1.001
    for damping in (0.01, 0.3, MOST):
        assert max(growth({0: 1}, 1, angle, damping) for angle in angles) < 1.0


@pytest.mark.parametrize("spaced", [0, 4, None, "yes"])
def test_spaced_is_a_yes_or_a_no(spaced):
    with pytest.raises(sph.InputError, match="spaced"):
        sph.Restraint(spaced=spaced)


def test_restart_and_copy_go_on_bit_for_bit(tmp_path):
    def simulation():
        return sph.Simulation(
            scene(Box(jitter=0.3)), spacing=0.25, formulation=sph.Displacement(),
            stabilisation=sph.Restraint(),
        )  # fmt: skip

    whole = simulation()
    whole.run(until=0.002)
    branch = copy.deepcopy(whole)
    whole.run(until=0.004)
    branch.run(until=0.004)
    np.testing.assert_array_equal(whole.state.x, branch.state.x)


def test_nothing_acts_across_a_slot():
    slot = Blocks(
        (
            ((0.0, 0.0, 0.0), (1.0, 0.5, 0.5)),
            ((0.0, 0.5, 0.0), (0.5, 0.75, 0.5)),
            ((0.0, 0.75, 0.0), (1.0, 1.25, 0.5)),
        )
    )
    sim = sph.Simulation(
        Scene("slot", slot, SOLID, 1e-3), spacing=0.25, formulation=sph.Displacement(),
        stabilisation=sph.Restraint(),
    )  # fmt: skip
    near = sim._rhs.terms[0]._near
    X = sim.cloud.X
    middle = 0.5 * (X[near.a] + X[near.b])
    in_slot = (middle[:, 0] > 0.51) & (middle[:, 1] > 0.51) & (middle[:, 1] < 0.74)
    assert not np.any(in_slot)


def test_what_makes_no_sense_is_refused():
    with pytest.raises(InputError, match="does nothing"):
        sph.Restraint(stiffness=sph.NoStiffness(), viscosity=0.0)
    with pytest.raises(InputError, match="Quartic"):
        sph.Restraint(stiffness=3.0)
    with pytest.raises(InputError, match=r"within \[0, 1\)"):
        sph.Restraint(viscosity=-0.1)
    for wrong, why in ((-1.0, r"within \[0, 1000\)"), (0.0, "positive")):
        with pytest.raises(InputError, match=why):
            sph.Quartic(wrong)
    for wrong in (-0.1, 10.0):
        with pytest.raises(InputError, match=r"compressed = .* within \[0, 10\)"):
            sph.Elastic(compressed=wrong)
    for wrong in ("much", True, None):
        with pytest.raises(InputError, match="is not a number"):
            sph.Quartic(compressed=wrong)
        with pytest.raises(InputError, match="is not a number"):
            sph.Restraint(viscosity=wrong)
    with pytest.raises(InputError, match=r"within \[0, 1000\)"):
        sph.Quartic(4000.0)


def test_numbers_of_any_type_are_taken():
    assert sph.Restraint(viscosity=np.float32(0.25)).viscosity == 0.25
    assert sph.Quartic(np.int64(40)) == sph.Quartic()


def test_a_stiffness_of_ones_own_is_a_number_that_is_not_negative():
    class Own(Stiffness):
        def __init__(self, value):
            self.value = value

        @property
        def quartic(self):
            return self.value

    assert sph.Restraint(stiffness=Own(3.0)).stiffness.quartic == 3.0
    for wrong, why in ((-5.0, "not be negative"), (np.nan, "finite"), ("x", "not a number")):
        with pytest.raises(InputError, match=f"Own: quartic = .*{why}"):
            sph.Restraint(stiffness=Own(wrong))
