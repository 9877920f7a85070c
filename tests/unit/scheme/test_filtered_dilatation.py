"""A pressure that is that of a potential: forces, momenta, budget, and what snapshots show."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, Box, TetBox
from sphsolid.record import Budget, EnergyBudget, MomentumDrift, write_checkpoint
from sphsolid.scenes import Scene
from tests.oracles.blocks import FORMULATIONS, MOONEY, RUBBER, loaded_block, spinning_block
from tests.oracles.laws import LAWS

FILTERED = sph.FilteredDilatation(order=1)
HELD = sph.FilteredDilatation(order=2, beta=0.4)
ELL = Blocks((((0.0, 0.0, 0.0), (1.0, 0.5, 0.5)), ((0.0, 0.0, 0.0), (0.5, 1.0, 0.5))))
BODIES: dict[str, tuple[Any, float]] = {
    "lattice": (Box(), 0.2),
    "jitter 0.4": (Box(jitter=0.4, seed=1), 0.2),
    "L-block": (ELL, 0.125),
    "tetrahedra": (TetBox(upper=(1.0, 1.0, 1.0)), 0.25),
}


def free(body: Any = None, material: Any = RUBBER) -> Scene:
    """A free body, spinning, strained and straining."""
    scene = spinning_block(jitter=0.4)
    given = vars(scene) | {"material": material} | ({} if body is None else {"body": body})
    return Scene(**given)


def simulation(scene: Scene, spacing: float = 0.25, **options: Any) -> sph.Simulation:
    chosen: dict[str, Any] = {
        "formulation": sph.Displacement(), "stabilisation": sph.NoStabilisation(),
        "dilatation": FILTERED,
    }  # fmt: skip
    return sph.Simulation(scene, spacing=spacing, **(chosen | options))


def rough(sim: sph.Simulation) -> Any:
    """Positions that differ from one particle to the next."""
    X = sim.cloud.X
    noise = np.random.default_rng(5).normal(size=X.shape)
    return sim.state.x + 0.02 * sim.cloud.spacing * noise


def force(sim: sph.Simulation, x: Any) -> Any:
    rhs, state = sim._rhs, sim.state
    state.x[:] = x
    return rhs.evaluate(state, state.x, 0.0, derives_F=True).p.copy()


def energy(sim: sph.Simulation, x: Any) -> float:
    sim.state.x[:] = x
    return sim.snapshot().strain_energy


@pytest.mark.parametrize("option", [FILTERED, HELD], ids=["plain", "beta"])
@pytest.mark.parametrize("body", BODIES)
def test_the_force_is_that_of_the_energy_and_has_no_moment(body: str, option: Any) -> None:
    shape, spacing = BODIES[body]
    sim = simulation(free(shape), spacing, dilatation=option)
    assert sim.cloud.is_adjoint
    x, V = rough(sim), sim.cloud.V[:, None]
    f = force(sim, x)
    own = force(simulation(free(shape), spacing, dilatation=sph.OwnDilatation()), x)
    assert np.linalg.norm(f - own) > 0.05 * np.linalg.norm(own)
    direction = np.random.default_rng(1).normal(size=x.shape)
    step = 1e-3 * sim.cloud.spacing
    energies = [energy(sim, x + s * step * direction) for s in (-2, -1, 1, 2)]
    slope = np.dot(energies, [1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    size = np.linalg.norm(V * f) * np.linalg.norm(direction)
    assert abs(np.sum(V * f * direction) + slope) < 1e-8 * size
    scale = np.sum(V[:, 0] * np.linalg.norm(f, axis=1))
    assert np.abs(np.sum(V * f, axis=0)).max() < 1e-13 * scale
    assert np.abs(np.sum(V * np.cross(x, f), axis=0)).max() < 1e-13 * scale


@pytest.mark.parametrize("material", [MOONEY, *LAWS[:2]], ids=lambda m: type(m).__name__)
def test_every_law_is_asked_for_its_volumetric_energy(material: Any) -> None:
    sim = simulation(free(material=material), 0.34, dilatation=HELD)
    x, V = rough(sim), sim.cloud.V[:, None]
    f = force(sim, x)
    direction = np.random.default_rng(1).normal(size=x.shape)
    step = 1e-3 * sim.cloud.spacing
    energies = [energy(sim, x + s * step * direction) for s in (-2, -1, 1, 2)]
    slope = np.dot(energies, [1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    size = np.linalg.norm(V * f) * np.linalg.norm(direction)
    assert abs(np.sum(V * f * direction) + slope) < 1e-8 * size


@pytest.mark.parametrize("body", BODIES)
def test_a_uniform_dilatation_is_unchanged(body: str) -> None:
    shape, spacing = BODIES[body]
    sim = simulation(free(shape), spacing)
    sim.state.x[:] = 1.1 * sim.cloud.X + [0.1, 0.2, -0.3]
    shot = sim.snapshot()
    own = law.volumetric_pressure(RUBBER, 1.1**3)
    np.testing.assert_allclose(shot.pressure, own, rtol=1e-11)
    np.testing.assert_allclose(shot.P, law.first_piola(
        RUBBER, tuple(1.1 * np.eye(3).ravel()), tuple(1.21 * np.eye(3).ravel()), 1.1**3
    )[0] * np.broadcast_to(np.eye(3), shot.P.shape), rtol=1e-11, atol=1e-6)  # fmt: skip


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=lambda f: f.name)
@pytest.mark.parametrize("integrator", [sph.PositionVerlet(), sph.SSPRK3(), sph.TVDRK2()],
                         ids=lambda i: i.name)  # fmt: skip
def test_momenta_are_kept(formulation: Any, integrator: Any) -> None:
    sim = simulation(free(), formulation=formulation, integrator=integrator)
    sim.track_budget()
    for _ in range(20):
        sim.advance(0.5 * sim.stable_time_step())
    row = MomentumDrift().record(sim.snapshot(), sim.scene)
    assert row["linear_drift [kg m/s]"] < 1e-13 * row["linear_scale [kg m/s]"]
    assert row["angular_drift [kg m^2/s]"] < 1e-13 * row["angular_scale [kg m^2/s]"]


SPAN = 2.0e-3
FORCE_ONLY = sph.Consistent(use="force")
DAMPED = sph.SUPG(tau_F=0.5, xi_F=0.1)
VARIANTS: dict[str, dict[str, Any]] = {
    **{f.name: {"formulation": f, "stabilisation": DAMPED} for f in FORMULATIONS},
    "undamped": {},
    "three stages": {"formulation": sph.PFJ(), "integrator": sph.SSPRK3()},
    "D(J)": {"formulation": sph.PFHJ(), "stabilisation": sph.SUPG(tau_p=0.2), "cfl": 0.04},
    "not adjoint": {"formulation": sph.PFJ(), "operator": FORCE_ONLY},
    "no projection": {"formulation": sph.PF(), "angular_momentum": sph.NoProjection()},
}


def energy_left(steps: int, **options: Any) -> tuple[float, Budget]:
    sim = simulation(loaded_block(), **({"dilatation": HELD} | options))
    sim.track_budget()
    for _ in range(steps):
        sim.advance(SPAN / steps)
    shot = sim.snapshot()
    assert isinstance(shot.budget, Budget)
    return abs(EnergyBudget().record(shot, sim.scene)["energy_rest [J]"]), shot.budget


@pytest.mark.parametrize("name", VARIANTS)
def test_the_energy_budget_closes_with_the_step(name: str) -> None:
    left, found = zip(*(energy_left(steps, **VARIANTS[name]) for steps in (60, 120)), strict=True)
    assert left[1] < 2e-4 * sum(abs(work) for work in found[1].works.values())
    assert np.log2(left[0] / left[1]) > 1.9


def test_its_own_column_is_needed_where_something_is_done_to_the_stress() -> None:
    """And is exactly zero in displacement form, where nothing is."""
    for name, options in (("D(J)", {"cfl": 0.04 * 60 / 480}), ("not adjoint", {})):
        left, budget = energy_left(480, **(VARIANTS[name] | options))
        assert abs(budget.works["filtered_dilatation"]) > 8.0 * left, name
    _, budget = energy_left(10)
    assert budget.works["filtered_dilatation"] == 0.0


def energies_of(option: Any, share: float) -> Any:
    """Over 300 stable steps, relative to the first."""
    sim = simulation(free(), dilatation=option)
    dt, found = share * sim.stable_time_step(), []
    for _ in range(int(300 / share)):
        sim.advance(dt)
        shot = sim.snapshot()
        found.append(shot.strain_energy + shot.kinetic_energy)
    return np.array(found) / found[0]


def test_energy_errors_are_those_of_the_integrator_and_do_not_grow() -> None:
    coarse, fine = energies_of(FILTERED, 0.5), energies_of(FILTERED, 0.25)
    assert np.log2(np.ptp(coarse) / np.ptp(fine)) > 1.8
    # Once the rough start is behind.
    own = energies_of(sph.OwnDilatation(), 0.5)
    assert np.std(coarse[300:]) <= np.std(own[300:])
    assert np.std(coarse[300:]) < 1e-4


def test_a_snapshot_shows_the_pressure_that_acts() -> None:
    sim = simulation(free(), dilatation=HELD)
    sim.state.x[:] = rough(sim)
    shot = sim.snapshot()
    force(sim, sim.state.x.copy())
    own = law.volumetric_pressure(RUBBER, shot.J)
    acting = sim._rhs.terms[-1].excess + own
    scale = np.abs(acting).max()
    assert np.abs(acting - own).max() > 0.1 * scale
    np.testing.assert_allclose(shot.pressure, acting, rtol=0.0, atol=1e-12 * scale)
    mean = np.trace(shot.cauchy, axis1=1, axis2=2) / 3.0
    np.testing.assert_allclose(shot.pressure, mean, rtol=0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(shot.P, sim._rhs.P, rtol=0.0, atol=1e-12 * scale)
    bare = simulation(free(), dilatation=sph.OwnDilatation())
    bare.state.x[:] = sim.state.x
    plain = bare.snapshot()
    np.testing.assert_array_equal(plain.pressure, own)
    assert plain.strain_energy - plain.volumetric_energy == pytest.approx(
        shot.strain_energy - shot.volumetric_energy, rel=1e-12
    )
    assert shot.volumetric_energy < plain.volumetric_energy


@pytest.mark.parametrize("formulation", [sph.Displacement(), sph.PFHJ()], ids=lambda f: f.name)
def test_restart_and_branches_have_the_same_bits(formulation: Any, tmp_path: Path) -> None:
    options = {"formulation": formulation, "dilatation": HELD, "spacing": 0.25}
    whole, other = (sph.Simulation(loaded_block(), **options) for _ in range(2))
    dt = 0.5 * whole.stable_time_step()
    for _ in range(3):
        whole.advance(dt)
    write_checkpoint(whole, tmp_path / "state.npz")
    other.restore(tmp_path / "state.npz")
    branch = copy.deepcopy(whole)
    assert branch._rhs.terms[-1]._filter is whole._rhs.terms[-1]._filter
    for sim in (whole, other, branch):
        for _ in range(3):
            sim.advance(dt)
    for field in whole.state:
        expected = np.ascontiguousarray(whole.state[field]).tobytes()
        assert np.ascontiguousarray(other.state[field]).tobytes() == expected, field
        assert np.ascontiguousarray(branch.state[field]).tobytes() == expected, field
    with pytest.raises(InputError, match="dilatation"):
        simulation(loaded_block(), formulation=formulation).restore(tmp_path / "state.npz")


def test_a_body_at_rest_stays_at_rest_to_the_bit() -> None:
    scene = Scene(name="rest", body=Box(jitter=0.3), material=RUBBER, end_time=1.0)
    sim = simulation(scene, formulation=sph.PFJ())
    # The gradient of X is the identity to round-off only.
    sim.state.F[:], sim.state.J[:] = np.eye(3), 1.0
    for _ in range(3):
        sim.advance(1.0e-4)
    np.testing.assert_array_equal(sim._rhs.terms[-1].excess, 0.0)
    np.testing.assert_array_equal(sim.state.p, 0.0)


def test_the_plan_says_which_filter() -> None:
    assert "filtered J (lines of the lattice, order 1)" in simulation(
        free(Box()), 0.25
    ).plan()
    plan = simulation(free(), 0.25, dilatation=HELD).plan()
    assert "filtered J (linear fits 2 spacings wide" in plan
    assert "neighbours, the rest held by " in plan


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"order": 3}, "order = 3 must be 1 or 2"),
        ({"order": True}, "order = True must be 1 or 2"),
        ({"order": 2.0}, "order = 2.0 must be 1 or 2"),
        ({"order": 1 + 0j}, "must be 1 or 2"),
        ({"order": np.array([1, 2])}, "must be 1 or 2"),
        ({"width": 1.0}, "width = 1 spacings must be more than 1"),
        ({"width": 9.0}, "at most 4"),
        ({"width": "wide"}, "width = 'wide' is not a number"),
        ({"beta": -0.1}, "beta = -0.1 must not be negative"),
        ({"beta": float("nan")}, "must be finite"),
    ],
)
def test_bad_options_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        sph.FilteredDilatation(**wrong)


def test_the_rest_is_held_by_the_bulk_modulus_at_most() -> None:
    sim = simulation(free(), 0.34, dilatation=sph.FilteredDilatation(beta=1.0e6))
    assert sim._rhs.terms[-1].stiffness == pytest.approx(RUBBER.kappa)


def test_a_class_is_refused_before_any_step() -> None:
    with pytest.raises(InputError, match=r"write FilteredDilatation\(\)"):
        simulation(free(), 0.34, dilatation=sph.FilteredDilatation)
