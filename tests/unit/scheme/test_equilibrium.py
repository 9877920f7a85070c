"""The equilibrated start: the stated strain's force, compatible, nearby, or refused."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.scenes import FromGeometry, Scene, swinging_cube
from tests.oracles import numpy_sph
from tests.oracles.dense import dense

SCENE = swinging_cube(family="A+B+C=0", amplitude=0.03, jitter=0.4, manufactured=True)


def started(scene: Scene = SCENE, spacing: float = 0.25, **options: Any) -> sph.Simulation:
    options = {"initial_strain": sph.Equilibrated()} | options
    return sph.Simulation(scene, spacing=spacing, **options)


def forces(sim: sph.Simulation, F: np.ndarray) -> np.ndarray:
    """``sum_b V_b P_b G_a(X_b)`` at free components, by dense sums."""
    G = dense(sim.cloud.pairs, sim.cloud.gradients.kinematic, sim.cloud.size)
    mu, kappa = sim.scene.material.mu, sim.scene.material.kappa
    J, H = np.linalg.det(F)[:, None, None], numpy_sph.cof(F)
    square = np.einsum("aij,aij->a", F, F)[:, None, None]
    P = mu * J ** (-2 / 3) * (F - square / (3.0 * J) * H) + kappa * (J - 1.0) * H
    rate = np.einsum("b,bij,baj->ai", sim.cloud.V, P, G)
    sim._rhs.essential.release(rate)
    return np.asarray(rate)


def test_it_exerts_the_force_of_the_stated_strain() -> None:
    sim = started()
    stated = SCENE.exact.deformation_gradient(sim.cloud.X, 0.0)
    compatible = started(initial_strain=sph.Compatible())
    wanted = forces(sim, stated)
    lack = np.linalg.norm(forces(sim, sim.state.F) - wanted)
    assert lack < 2e-4 * np.linalg.norm(forces(sim, compatible.state.F) - wanted)


def test_the_strain_is_that_of_the_particles() -> None:
    sim = started()
    G = dense(sim.cloud.pairs, sim.cloud.gradients.kinematic, sim.cloud.size)
    np.testing.assert_allclose(sim.state.F, numpy_sph.gradient(sim.state.x, G), atol=1e-13)


def test_particles_move_by_the_square_of_the_spacing_and_not_through_constraints() -> None:
    moves = []
    for spacing in (1 / 4, 1 / 8):
        sim = started(spacing=spacing)
        move = sim.state.x - sim.cloud.X - SCENE.initial_state(sim.cloud.X)[0]
        fixed = move.copy()
        sim._rhs.essential.release(fixed)
        np.testing.assert_allclose(fixed, move, atol=1e-16)
        moves.append(np.sqrt(np.mean(np.sum(move**2, axis=1))))
    assert np.log2(moves[0] / moves[1]) > 1.7


def test_a_uniform_strain_stays_where_it_is() -> None:
    gradient = np.array([[0.1, 0.02, 0.0], [0.0, -0.05, 0.03], [0.01, 0.0, 0.02]])
    scene = dataclasses.replace(
        SCENE,
        constraints=(),
        tractions=(),
        initial_displacement=lambda X: X @ gradient.T,
        initial_deformation_gradient=lambda X: np.tile(np.eye(3) + gradient, (len(X), 1, 1)),
    )
    sim = started(scene)
    np.testing.assert_allclose(sim.state.x, sim.cloud.X @ (np.eye(3) + gradient).T, atol=1e-13)


def test_a_strain_of_another_displacement_is_refused() -> None:
    scene = dataclasses.replace(SCENE, initial_displacement=lambda X: np.zeros_like(X))
    with pytest.raises(InputError, match=r"Equilibrated\(\).*initial_displacement.*Given\(\)"):
        started(scene)


@pytest.mark.parametrize(
    "options",
    [
        {"scene": dataclasses.replace(SCENE, initial_deformation_gradient=FromGeometry())},
        {"operator": sph.Consistent(use="force")},
    ],
    ids=["nothing stated", "not adjoint"],
)
def test_it_needs_a_strain_and_an_adjoint_operator(options: Any) -> None:
    with pytest.raises(InputError, match=r"Equilibrated\(\) needs.*Compatible\(\)"):
        started(**options)


def test_the_free_body_of_a_stated_strain_is_solved_too() -> None:
    """Without constraints the tangent has the rigid motions as null space."""
    scene = dataclasses.replace(SCENE, constraints=())
    sim = started(scene)
    move = sim.state.x - sim.cloud.X - scene.initial_state(sim.cloud.X)[0]
    assert np.max(np.abs(move)) < 0.05 * sim.cloud.spacing


def test_it_is_what_summation_by_parts_starts_with() -> None:
    assert isinstance(sph.Simulation(SCENE, spacing=0.25).initial_strain, sph.Equilibrated)
    lattice = dataclasses.replace(SCENE, body=Box())
    assert isinstance(sph.Simulation(lattice, spacing=0.25).initial_strain, sph.Compatible)
