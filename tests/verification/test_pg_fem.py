"""The Petrov-Galerkin method {p, F, H, J}: patch, momentum, budget, signs, order, restart."""

import copy
import dataclasses
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
from sphsolid.continuum import law
from sphsolid.continuum.tensor import join, split
from sphsolid.errors import Diverged, InputError
from sphsolid.record import Errors, period_errors
from sphsolid.scenes import Scene, swinging_cube
from tests.oracles.blocks import AFFINE, MOONEY, loaded_block, spinning_block, stretched_block

CELLS = [fem.Tetrahedra(), fem.Hexahedra()]
#: Every term of eq. (28) and (29c) at once.
ALL = {"tau_H": 0.5, "tau_J": 0.5, "xi_H": 0.1, "xi_J": 0.1}


def simulation(scene: Scene, cells: Any, spacing: float = 0.5, **options: Any) -> Any:
    return fem.MixedSimulation(scene, spacing=spacing, method=fem.PGFEM(cells=cells, **options))


@pytest.mark.parametrize("cells", CELLS)
def test_affine_motion_has_no_rates_and_no_dissipation(cells: Any) -> None:
    scene = stretched_block(jitter=0.3)
    sim = simulation(scene, cells, 1.0 / 3.0, **ALL)
    sim._cells.begin_step(sim.stable_time_step())
    np.testing.assert_allclose(sim._strains[:, :9], np.tile(AFFINE.ravel(), (len(sim._x), 1)),
                               atol=1e-12)
    sim._evaluate(0.0)
    scale = MOONEY.kappa / (MOONEY.density * 0.3)
    assert np.abs(sim._cells.v_dot).max() < 1e-11 * scale
    assert np.abs(sim._cells.strains_dot).max() < 1e-9
    # The same with a velocity that is linear in X: strains change, nothing is dissipated.
    sim._v[:] = 30.0 * sim._points.vertices @ np.arange(9.0).reshape(3, 3).T
    sim._evaluate(0.0)
    powers = sim._cells.stress_powers(sim._x, sim._v, sim._strains)
    rate = np.abs(sim._cells.strains_dot[:, :9]).max() * MOONEY.kappa
    assert abs(powers["dissipation_p"]) < 1e-12 * rate
    assert abs(powers["dissipation_J"]) < 1e-12 * rate
    assert abs(powers["adjoint_defect"]) < 1e-11 * rate


def rates_said_again(sim: Any, tau: dict[str, float], xi: dict[str, float]) -> tuple[Any, Any]:
    """``dp/dt`` and ``d(F, H, J)/dt`` of a free body by the text of ``pg_fem``, in plain numpy."""
    tables, V, rho = sim._cells.cells.tables, sim._volumes, sim.material.density
    nodes, N = tables.nodes.astype(int), tables.N
    G = np.broadcast_to(tables.G, (len(nodes), *tables.G.shape[1:]))
    w = np.broadcast_to(tables.w, (len(nodes), tables.w.shape[1]))
    S = sim._strains
    F, H, J = S[:, :9].reshape(-1, 3, 3), S[:, 9:18].reshape(-1, 3, 3), S[:, 18]

    def at_points(f: Any) -> Any:
        return np.einsum("qn,en...->eq...", N, f[nodes])

    def gradient(f: Any) -> Any:
        return np.einsum("eni,eqnk->eqik", f[nodes], G)

    def to_nodes(f: Any) -> Any:
        given, total = np.einsum("eq,qn,eq...->en...", w, N, f), np.zeros((len(V), *f.shape[2:]))
        np.add.at(total, nodes, given)
        return total / V.reshape(-1, *[1] * (f.ndim - 2))

    def cross(A: Any, B: Any) -> Any:
        e = np.zeros((3, 3, 3))
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            e[i, j, k], e[i, k, j] = 1.0, -1.0
        return np.einsum("ijk,IJK,...jJ,...kK->...iI", e, e, A, B)

    def stress(F: Any, H: Any, J: Any) -> Any:
        tensors = split(F), split(H)
        return join(law.first_piola(sim.material, *tensors, J))

    L, F_x = gradient(sim._v), gradient(sim._x)
    F_q, H_q, J_q = at_points(F), at_points(H), at_points(J)
    dF, dH, dJ = L, cross(F_q, L), np.sum(H_q * L, axis=(2, 3))
    rates = to_nodes(dF), to_nodes(dH), to_nodes(dJ)
    F_st = F_q + tau["F"] * (dF - at_points(rates[0])) + xi["F"] * (F_x - F_q)
    cof = 0.5 * cross(F_x, F_x)
    H_st = H_q + tau["H"] * (dH - at_points(rates[1])) + xi["H"] * (cof - H_q)
    J_st = J_q + tau["J"] * (dJ - at_points(rates[2])) + xi["J"] * (np.linalg.det(F_x) - J_q)
    P = stress(F_st, H_st, J_st)
    pushed = np.zeros_like(sim._x)
    np.add.at(pushed, nodes, -np.einsum("eq,eqik,eqnk->eni", w, P, G))
    p_dot = pushed / V[:, None]
    R = np.einsum("enik,eqnk->eqi", stress(F, H, J)[nodes], G) - at_points(p_dot)
    flux = -tau["p"] / rho * np.einsum("eq,eqji,eqj->eqi", w, H_q, R)
    D_J = np.zeros(len(V))
    np.add.at(D_J, nodes, np.einsum("eqnk,eqk->en", G, flux))
    parts = rates[0].reshape(-1, 9), rates[1].reshape(-1, 9), (rates[2] + D_J / V)[:, None]
    return p_dot, np.concatenate(parts, axis=1)


@pytest.mark.parametrize("cells", CELLS)
def test_all_rates_are_those_of_the_text_said_again_in_numpy(cells: Any) -> None:
    sim = simulation(
        stretched_block(loaded=False, jitter=0.2), cells, tau_F=0.7, tau_p=0.3, projects=False,
        **ALL,
    )
    random, dt = np.random.default_rng(11), 1e-4
    sim._v[:] = 20.0 * random.normal(size=sim._v.shape)
    sim._x += 0.01 * random.normal(size=sim._x.shape)
    sim._strains += 0.01 * random.normal(size=sim._strains.shape)
    sim._cells.begin_step(dt)
    sim._evaluate(0.0)
    tau = {"F": 0.7 * dt, "H": 0.5 * dt, "J": 0.5 * dt, "p": 0.3 * dt}
    p_dot, strains_dot = rates_said_again(sim, tau, {"F": 0.1, "H": 0.1, "J": 0.1})
    found = sim.material.density * sim._cells.v_dot
    np.testing.assert_allclose(found, p_dot, rtol=0, atol=1e-12 * np.abs(p_dot).max())
    for columns in (slice(0, 9), slice(9, 18), slice(18, 19)):
        expected = strains_dot[:, columns]
        size = np.abs(expected).max()
        assert np.abs(sim._cells.strains_dot[:, columns] - expected).max() < 1e-12 * size


@pytest.mark.parametrize("cells", CELLS)
def test_a_free_body_keeps_both_momenta_to_round_off(cells: Any) -> None:
    sim = simulation(spinning_block(), cells)
    sim.track_budget()
    for _ in range(10):
        sim.advance(sim.stable_time_step())
    budget = sim.snapshot().budget
    size = np.abs(budget.start_momentum).max(axis=1)
    assert np.all(np.abs(budget.drift).max(axis=1) < 1e-12 * size)


def test_without_the_projection_angular_momentum_drifts() -> None:
    sim = simulation(spinning_block(), fem.Tetrahedra(), projects=False)
    sim.track_budget()
    for _ in range(10):
        sim.advance(sim.stable_time_step())
    budget = sim.snapshot().budget
    assert np.abs(budget.drift[1]).max() > 1e-8 * np.abs(budget.start_momentum[1]).max()


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("scene", [spinning_block(jitter=0.2), loaded_block(jitter=0.2)])
def test_every_term_is_in_the_energy_budget(scene: Scene, cells: Any) -> None:
    """What the works do not explain is the integrator's, and falls with the square of the step."""

    def missing(parts: int) -> tuple[float, float]:
        sim = simulation(scene, cells, **ALL)
        sim.track_budget()
        step = sim.stable_time_step() / parts
        for _ in range(parts):
            sim.advance(step)
        end = sim.snapshot()
        budget: Any = end.budget
        change = end.kinetic_energy + end.strain_energy - budget.start_energy
        # Momentum too: what loads and constraints gave, no more.
        assert np.abs(budget.drift).max() < 1e-12 * np.abs(budget.momentum).max()
        assert abs(budget.works["dissipation_p"]) > 1.0
        return abs(change - sum(budget.works.values())), abs(change)

    coarse, size = missing(4)
    fine, _ = missing(12)
    assert coarse < 0.03 * size
    assert fine < 0.3 * coarse


@pytest.mark.parametrize("cells", CELLS)
def test_the_full_hessian_dissipates_at_random_velocities(cells: Any) -> None:
    """At rest ``P_st - P`` is a positive operator on residuals when the three times are equal."""
    sim = simulation(spinning_block(), cells, tau_H=1.0, tau_J=1.0, xi_F=0.0, tau_p=0.0)
    cells_, random = sim._cells, np.random.default_rng(3)
    X = sim._points.vertices
    strains = cells_.start(X)
    cells_.begin_step(1e-3)
    for _ in range(5):
        v = 1e-4 * random.normal(size=X.shape)
        cells_.galerkin_rates(v, strains)
        assert cells_.stress_powers(X, v, strains)["dissipation_p"] < 0.0


def test_a_dilation_of_single_points_is_answered_the_right_way() -> None:
    """``P_st - P`` of a residual ``r I`` at rest, of time and of position, points along it."""
    c = simulation(spinning_block(), fem.Tetrahedra())._cells
    c.begin_step(1.0)
    material, one = c.material, c.coefficients
    r, one_tensor = 1e-6, np.eye(3)

    def answer(F: float, H: float, J: float) -> float:
        strains = split(one_tensor * (1.0 + r * F)), split(one_tensor * (1.0 + 2.0 * r * H))
        return float(law.first_piola(material, *strains, 1.0 + 3.0 * r * J)[0]) / r

    for given in ((one.tau_F, one.tau_H, one.tau_J), (one.xi_F, one.xi_H, one.xi_J)):
        shear = material.mu * (given[0] + 2.0 * given[1])
        expected = 3.0 * (material.kappa + material.mu) * given[2] - shear
        assert answer(*given) == pytest.approx(expected, rel=1e-4)
        assert answer(*given) > material.mu * given[0]
        assert answer(given[0], given[1], 0.0) < 0.0


@pytest.mark.parametrize("cells", CELLS)
def test_the_term_of_tau_p_takes_energy_from_pressures_inside(cells: Any) -> None:
    sim = simulation(spinning_block(jitter=0.0), cells, 0.2)
    X, random = sim._points.vertices, np.random.default_rng(3)
    inside = np.all((X > 0.3) & (X < 0.7), axis=1)
    sim._x[:], sim._v[:] = X, 0.0
    start = sim._cells.start(X)
    sim._cells.begin_step(1e-3)
    for _ in range(5):
        sim._strains[:] = start
        sim._strains[inside, 18] += 1e-4 * random.normal(size=int(inside.sum()))
        sim._evaluate(0.0)
        powers = sim._cells.stress_powers(sim._x, sim._v, sim._strains)
        assert powers["dissipation_J"] < 0.0


@cache
def cube_errors(cells: Any, n: int, poisson_ratio: float) -> dict[str, float]:
    scene = swinging_cube(family="A+B+C=0", amplitude=1e-7, poisson_ratio=poisson_ratio)
    sim = simulation(scene, cells, 1.0 / n)
    T = scene.end_time
    rows = sim.run(until=T, every=T / 12.0, record=[Errors()]).table.iloc[1:]
    return period_errors(rows.drop(columns=["time [s]", "step"]).to_dict("records"))


@pytest.mark.parametrize("cells", CELLS)
def test_momentum_converges_with_second_order(cells: Any) -> None:
    coarse, fine = (cube_errors(cells, n, 0.3) for n in (4, 8))
    for name in ("p_x", "p_y", "p_z"):
        assert math.log2(coarse[name] / fine[name]) > 1.7, name


def test_a_run_goes_on_from_a_checkpoint_and_a_copy_bit_for_bit(tmp_path: Path) -> None:
    from sphsolid.record.checkpoint import write_checkpoint

    scene = loaded_block()
    sim = simulation(scene, fem.Tetrahedra())
    sim.track_budget()
    for _ in range(3):
        sim.advance(1e-4)
    write_checkpoint(sim, tmp_path / "half.npz")
    again, twin = simulation(scene, fem.Tetrahedra()), copy.deepcopy(sim)
    again.track_budget()
    again.restore(tmp_path / "half.npz")
    for each in (sim, again, twin):
        for _ in range(3):
            each.advance(1e-4)
    for other in (again, twin):
        for name, array in sim.state_arrays().items():
            np.testing.assert_array_equal(other.state_arrays()[name], array)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tau_F": -1.0}, "tau_F"), ({"tau_p": math.nan}, "tau_p"), ({"xi_F": 0.6}, "0 to 0.5"),
        ({"tau_J": True}, "tau_J"), ({"cells": "tets"}, r"Tetrahedra\(\) or Hexahedra\(\)"),
        ({"projects": 1}, "projects"),
    ],
)  # fmt: skip
def test_bad_options_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        fem.PGFEM(**options)


def test_bad_arguments_and_states_are_refused() -> None:
    scene = spinning_block()
    with pytest.raises(InputError, match=r"cfl = 2.0 is outside \(0, 1\]"):
        fem.MixedSimulation(scene, spacing=0.5, cfl=2.0)
    with pytest.raises(InputError, match=r"PGFEM\(\)"):
        fem.MixedSimulation(scene, spacing=0.5, method=fem.BBarHex)  # type: ignore[arg-type]
    folded = dataclasses.replace(scene, initial_displacement=lambda X: -2.0 * X)
    with pytest.raises(InputError, match="inside out"):
        fem.MixedSimulation(folded, spacing=0.5)
    sim = simulation(scene, fem.Tetrahedra())
    sim._strains[3, 18] = -0.1
    with pytest.raises(Diverged, match="Jacobian"):
        sim.stable_time_step()


def test_plan_and_summary_say_what_is_active() -> None:
    sim = simulation(loaded_block(), fem.Hexahedra())
    for words in ("8 hexahedra", "TVD-RK2", "tau_p 0.1 dt", "body force, traction on X+"):
        assert words in sim.plan()
    sim.advance(1e-5)
    assert "ns per node-step" in sim.summary()
    assert "sound" in sim.summary()
    assert sim.name == "loaded block_fem_pg_fem_hexahedra"
