"""Constrained TOUCH: patch, momentum, budget, signs, order, impedance, restart."""

import copy
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
from fem_reference.cell_tables import Hexahedra
from fem_reference.touch_mesh import touch_mesh
from sphsolid.continuum import NeoHookean
from sphsolid.errors import Diverged, InputError
from sphsolid.record import (
    AngularMomentum,
    EnergyBudget,
    Errors,
    LinearMomentum,
    Positions,
    period_errors,
)
from sphsolid.record.checkpoint import write_checkpoint
from sphsolid.scenes import Box, Constraint, Scene, swinging_cube
from tests.oracles.blocks import MOONEY, loaded_block, spinning_block, stretched_block

FV = fem.FiniteVolumeSimulation


def rates(sim: Any) -> Any:
    return sim._cells.evaluate(sim._v, sim._x, sim._centres, sim.time)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_uniform_stress_and_linear_velocity_are_exact(jitter: float) -> None:
    sim = FV(stretched_block(jitter=jitter), spacing=1.0 / 3.0)
    scale = MOONEY.kappa / (MOONEY.density * 0.3)
    at_rest = rates(sim)
    assert np.abs(at_rest.v).max() < 1e-12 * scale
    assert np.abs(at_rest.x).max() < 1e-11
    # A velocity linear in X moves the nodes with itself: no jump, nothing lost.
    A = np.array([[3.0, 1.0, 0.0], [-2.0, 4.0, 1.0], [0.5, 0.0, -3.0]])
    sim._v[:] = sim._cells.maps.X @ A.T
    moving = rates(sim)
    assert np.abs(moving.v).max() < 1e-11 * scale
    np.testing.assert_allclose(moving.x, sim._points.vertices @ A.T, atol=1e-11)


def test_the_maps_are_exact_for_linear_fields_and_thin_bodies_have_no_slope() -> None:
    tables = Hexahedra().tables(Box(jitter=0.4).mesh(0.25))
    maps = touch_mesh(tables, linear=True)
    f = 2.0 * maps.X[:, 0] - 3.0 * maps.X[:, 1] + maps.X[:, 2]
    on_faces = maps.faces.X @ [2.0, -3.0, 1.0]
    for side in (maps.to_left, maps.to_right):
        np.testing.assert_allclose((side @ f), on_faces, atol=1e-12)
    nodal = maps.from_faces @ on_faces + maps.from_cells @ f
    np.testing.assert_allclose(nodal, tables.mesh.vertices @ [2.0, -3.0, 1.0], atol=1e-12)
    # Closed surfaces of every cell, and the volume by the divergence theorem.
    assert np.abs(maps.balance @ maps.faces.area).max() < 1e-13
    thin = touch_mesh(Hexahedra().tables(Box(upper=(1.0, 1.0, 0.25)).mesh(0.25)), linear=True)
    np.testing.assert_allclose(thin.to_left @ np.ones(16), 1.0, atol=1e-12)


@pytest.mark.parametrize("scene", [spinning_block(jitter=0.2), loaded_block(jitter=0.2)])
def test_momenta_are_exact_and_every_term_is_in_the_budget(scene: Scene) -> None:
    def missing(parts: int) -> tuple[float, float]:
        sim = FV(scene, spacing=0.25)
        sim.track_budget()
        step = sim.stable_time_step() / parts
        for _ in range(2 * parts):
            sim.advance(step)
        end = sim.snapshot()
        budget: Any = end.budget
        size = np.abs(budget.momentum).max(axis=1)
        assert np.all(np.abs(budget.drift).max(axis=1) < 1e-12 * size)
        assert budget.works["dissipation_p"] < 0.0
        change = end.kinetic_energy + end.strain_energy - budget.start_energy
        return abs(change - sum(budget.works.values())), abs(change)

    coarse, size = missing(2)
    fine, _ = missing(6)
    assert coarse < 0.01 * size
    assert fine < 0.2 * coarse


def test_without_the_projection_angular_momentum_drifts() -> None:
    method = fem.ConstrainedTOUCH(projects=False)
    sim = FV(spinning_block(), spacing=0.25, method=method)
    sim.track_budget()
    for _ in range(5):
        sim.advance(sim.stable_time_step())
    budget: Any = sim.snapshot().budget
    assert np.abs(budget.drift[1]).max() > 1e-8 * np.abs(budget.start_momentum[1]).max()


@pytest.mark.parametrize("linear", [True, False])
def test_random_small_motions_lose_energy(linear: bool) -> None:
    sim = FV(
        spinning_block(jitter=0.0), spacing=0.25, method=fem.ConstrainedTOUCH(linear=linear)
    )
    random, X = np.random.default_rng(2), sim._points.vertices
    for _ in range(10):
        sim._v[:] = 1e-3 * random.normal(size=sim._v.shape)
        sim._x[:] = X + 1e-6 * random.normal(size=X.shape)
        sim._budget = type(sim)(sim.scene, spacing=0.25)._budget
        works, _ = sim._open_works()
        sim._evaluate(sim._v, sim._x, sim._centres, 0.0, 1.0)
        assert works.by_name["dissipation_p"] < 0.0


def test_a_wave_takes_the_impedance_of_the_solid_to_a_wall() -> None:
    """A body that flies against a wall answers with ``t = -rho0 c_p v`` at the first instant."""
    material = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)
    speed = 1e-4
    scene = Scene(
        "wall", Box(), material, 1.0, constraints=(Constraint("X-", "all"),),
        initial_velocity=lambda X: np.tile([-speed, 0.7 * speed, 0.0], (len(X), 1)),
    )
    sim = FV(scene, spacing=0.25)
    first = rates(sim)
    wall = sim._cells.boundary.held
    t = first.force[wall] / sim._cells.boundary.size[wall, None]
    c_p, c_s = math.sqrt(1e6 * 0.7 / (1.3 * 0.4) / 1000.0), math.sqrt(1e6 / 2.6 / 1000.0)
    np.testing.assert_allclose(t[:, 0], 1000.0 * c_p * speed, rtol=1e-9)
    np.testing.assert_allclose(t[:, 1], -1000.0 * c_s * 0.7 * speed, rtol=1e-9)


@cache
def cube_errors(n: int, method: fem.ConstrainedTOUCH) -> dict[str, float]:
    scene = swinging_cube(family="A+B+C=0", amplitude=1e-7)
    sim = FV(scene, spacing=1.0 / n, method=method)
    T = scene.end_time
    rows = sim.run(until=T, every=T / 12.0, record=[Errors()]).table.iloc[1:]
    return period_errors(rows.drop(columns=["time [s]", "step"]).to_dict("records"))


def test_it_converges_and_a_constant_reconstruction_is_far_behind() -> None:
    method = fem.ConstrainedTOUCH()
    coarse, fine = cube_errors(4, method), cube_errors(8, method)
    for name in ("p_x", "p_y", "p_z"):
        assert math.log2(coarse[name] / fine[name]) > 1.4, name
    first_order = cube_errors(8, fem.ConstrainedTOUCH(linear=False))
    assert first_order["p_z"] > 3.0 * fine["p_z"]


def test_recorders_checkpoint_and_copy(tmp_path: Path) -> None:
    scene = loaded_block()
    sim = FV(scene, spacing=0.25)
    record = [LinearMomentum(), AngularMomentum(), EnergyBudget(), Positions()]
    history = sim.run(until=1e-3, every=5e-4, record=record)
    assert history["inside_out_share [-]"].max() == 0.0
    write_checkpoint(sim, tmp_path / "half.npz")
    again, twin = FV(scene, spacing=0.25), copy.deepcopy(sim)
    again.track_budget()
    again.restore(tmp_path / "half.npz")
    sim.save(tmp_path / "frame.vtu")
    for each in (sim, again, twin):
        for _ in range(2):
            each.advance(1e-4)
    for other in (again, twin):
        for name, array in sim.state_arrays().items():
            np.testing.assert_array_equal(other.state_arrays()[name], array)
    snapshot = sim.snapshot()
    assert snapshot.V.sum() == pytest.approx(0.96, rel=1e-13)
    assert snapshot.masses.V.sum() == pytest.approx(0.96, rel=1e-13)


@pytest.mark.parametrize(
    ("options", "words"),
    [({"upwind": 0.0}, r"\(0, 1\]"), ({"upwind": math.nan}, "upwind"), ({"linear": 1}, "linear"),
     ({"projects": "no"}, "projects")],
)  # fmt: skip
def test_bad_options_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        fem.ConstrainedTOUCH(**options)


def test_bad_arguments_and_states_are_refused() -> None:
    scene = spinning_block()
    with pytest.raises(InputError, match=r"cfl = 0.0 is outside \(0, 1\]"):
        FV(scene, spacing=0.5, cfl=0.0)
    with pytest.raises(InputError, match=r"ConstrainedTOUCH\(\)"):
        FV(scene, spacing=0.5, method=fem.ConstrainedTOUCH)  # type: ignore[arg-type]
    sim = FV(scene, spacing=0.5)
    assert "Riemann" in sim.plan()
    sim._v[0] = np.nan
    with pytest.raises(Diverged, match="non-finite"):
        sim.stable_time_step()
