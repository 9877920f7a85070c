"""A body that is held stretched or pressed: noise decays, and the viscosity only takes energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.scenes import Box, Constraint, Scene
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.restraint import COMPRESSED
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.viscous_share import viscous_share, viscous_shares

LAW = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.3, density=1000.0)
RESTRAINTS = (sph.Restraint(), sph.Restraint(spaced=False), sph.Restraint(viscosity=0.1))
HELD = [
    (2.0, sph.LatticeDifference()), (3.0, sph.LatticeDifference()), (4.0, sph.LatticeDifference()),
    (1.5, sph.Consistent()), (2.0, sph.Consistent()), (3.0, sph.Consistent()),
    (2.0, sph.SummationByParts()),
]  # fmt: skip


def pulled(stretch: float) -> Scene:
    """A cube pulled along X between rollers, its volume kept, with a saw tooth in the velocity."""
    across = stretch**-0.5
    sign = lambda X: np.where(np.round(8.0 * X).sum(axis=1) % 2, 1.0, -1.0)[:, None]  # noqa: E731
    return Scene(
        "pulled", Box(), LAW, 1.0,
        initial_displacement=lambda X: X * (np.array([stretch, across, across]) - 1.0),
        initial_velocity=lambda X: 1.0e-6 * sign(X) * np.array([1.0, 0.3, 0.2]),
        constraints=tuple(Constraint(f"{axis}{end}", "normal") for axis in "XYZ" for end in "-+"),
    )  # fmt: skip


@pytest.mark.parametrize("restraint", RESTRAINTS, ids=str)
@pytest.mark.parametrize(("stretch", "operator"), HELD, ids=str)
def test_noise_decays_and_no_push_makes_energy(
    stretch: float, operator: sph.OperatorKind, restraint: sph.Restraint
) -> None:
    sim = sph.Simulation(
        pulled(stretch), spacing=0.125, operator=operator, stabilisation=restraint
    )
    sim.track_budget()
    start, taken = sim.snapshot().kinetic_energy, [0.0]
    for _ in range(200):
        sim.advance(sim.stable_time_step())
        taken.append(sim.snapshot().budget.works["dissipation_restraint"])
    assert sim.snapshot().kinetic_energy < 0.3 * start
    # To the order of the integrator: a force of the stiffness may turn a velocity round.
    assert np.diff(taken).max() < 0.02 * start
    assert taken[-1] < 0.0


@pytest.mark.parametrize(
    ("stretch", "body", "operator"),
    [(3.5, Box(), sph.Consistent()), (2.5, Box(jitter=0.3), sph.SummationByParts())],
    ids=str,
)
def test_what_is_pressed_across_is_held(
    stretch: float, body: Box, operator: sph.OperatorKind
) -> None:
    """Held at its volume a stretched body is pressed across by two to four shear moduli."""
    scene = replace(pulled(stretch), body=body)
    kept = []
    for compressed in (0.0, COMPRESSED):
        sim = sph.Simulation(
            scene, spacing=0.125 if body.jitter == 0.0 else 0.25, operator=operator,
            stabilisation=sph.Restraint(stiffness=sph.Quartic(compressed=compressed)),
        )  # fmt: skip
        kept.append(kinetic_energy_kept(sim, 120))
    assert kept[0] > 100.0
    # What is left may be a slow vibration of the whole body.
    assert kept[1] < 1.0


@pytest.mark.parametrize("pressure", [2.0, 4.0, 8.0])
def test_noise_decays_under_pressure(pressure: float) -> None:
    """A nearly incompressible cube of disordered particles under shear moduli of pressure."""
    rubber = sph.NeoHookean.from_young(young_modulus=1.0e6, poisson_ratio=0.495, density=1000.0)
    side = (1.0 - pressure * rubber.mu / rubber.kappa) ** (1.0 / 3.0)
    scene = replace(
        pulled(1.0), body=Box(jitter=0.3), material=rubber,
        initial_displacement=lambda X: X * (side - 1.0),
    )  # fmt: skip
    assert kinetic_energy_kept(sph.Simulation(scene, spacing=0.2), 200) < 0.3
    if pressure > 2.0:
        bare = sph.Restraint(stiffness=sph.Quartic(compressed=0.0))
        sim = sph.Simulation(scene, spacing=0.2, stabilisation=bare)
        assert kinetic_energy_kept(sim, 200) > 1.0e4


def kinetic_energy_kept(sim: sph.Simulation, steps: int) -> float:
    """After ``steps``, over that of the start."""
    start = sim.snapshot().kinetic_energy
    for _ in range(steps):
        sim.advance(sim.stable_time_step())
    return sim.snapshot().kinetic_energy / start


def test_the_share_keeps_what_the_largest_stretch_makes_of_the_damping() -> None:
    rng = np.random.default_rng(0)
    most = 2.0
    F = np.eye(3) + rng.standard_normal((200, 3, 3)) * rng.uniform(0.0, 2.0, (200, 1, 1))
    shares = viscous_shares(F, most)
    np.testing.assert_allclose([viscous_share(tuple(f.ravel()), most) for f in F], shares)
    square = np.linalg.norm(F, 2, axis=(1, 2)) ** 2
    assert np.all(shares * square <= most * (1.0 + 1e-12))
    assert np.all(shares * square >= np.minimum(square, most) / 3.0**0.25 * (1.0 - 1e-12))
    assert np.all(shares[3.0**0.25 * square < most] == 1.0)
    turned = np.linalg.qr(rng.standard_normal((3, 3)))[0] @ F
    np.testing.assert_allclose(viscous_shares(turned, most), shares)
    assert np.all(viscous_shares(F, np.inf) == 1.0)


@pytest.mark.parametrize("cfl", [0.5, 0.7])
def test_differences_of_order_four_have_a_step_of_their_own(cfl: float) -> None:
    """Their highest frequency is above that of second-order differences, restraint or none."""
    rng = np.random.default_rng(0)
    free = Scene(
        "free", Box(), LAW, 1.0,
        initial_velocity=lambda X: 1.0e-6 * rng.standard_normal(X.shape),
    )  # fmt: skip
    sim = sph.Simulation(
        free, spacing=0.125, formulation=sph.Displacement(), operator=sph.LatticeDifference(),
        stabilisation=sph.NoStabilisation(), cfl=cfl,
    )  # fmt: skip
    start = sim.snapshot().kinetic_energy
    for _ in range(300):
        sim.advance(sim.stable_time_step())
    assert sim.snapshot().kinetic_energy < 1.05 * start


def test_two_restraints_on_a_lattice_add_up() -> None:
    scene = Scene(
        "wavy", Box(), LAW, 1.0,
        initial_displacement=lambda X: 0.01 * np.where(np.round(4.0 * X) % 2, 1.0, -1.0),
    )  # fmt: skip

    def force(*restraints: sph.Restraint) -> np.ndarray:
        first, *more = restraints
        sim = sph.Simulation(scene, spacing=0.25, stabilisation=first, terms=more)
        sim.advance(1.0e-9)
        return np.asarray(sim.snapshot().momentum) / 1.0e-9

    elastic = sph.Restraint(stiffness=sph.Elastic(1.0), viscosity=0.0)
    none = sph.Restraint(stiffness=sph.NoStiffness(), viscosity=0.01)
    both, one, bare = force(sph.Restraint(), elastic), force(sph.Restraint()), force(none)
    alone = force(elastic)
    largest = np.abs(both).max()
    np.testing.assert_allclose(both + bare, one + alone, atol=1e-5 * largest)


def test_both_forms_on_lines_reduce_the_viscosity_alike() -> None:
    """The kernel of a box lattice, and the plain form that is independent of it."""
    sim = sph.Simulation(pulled(3.0), spacing=0.125, stabilisation=sph.Restraint())
    plain = RightHandSide(sim._set_up, sim._rhs.terms, sim.formulation.fields)
    sim.state.p[:] *= 1.0e6
    state, units = plain.zeros(), Units(1.0, sim.stable_time_step(), 0)
    for name in state:
        if name in sim.state:
            state[name][:] = sim.state[name]
    forces = []
    for rhs in (sim._rhs, plain):
        rhs.begin_step(units)
        rhs.evaluate(sim._state if rhs is sim._rhs else state, state.x, 0.0, derives_F=True)
        forces.append(rhs.rates.p.copy())
    assert plain.terms[0].acting.most < 9.0
    largest = np.abs(forces[1]).max()
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-12 * largest)
    plain.terms[0].acting = plain.terms[0].acting._replace(most=np.inf)
    unlimited = plain.evaluate(state, state.x, 0.0, derives_F=True).p
    assert np.abs(unlimited - forces[1]).max() > 1e-3 * largest
