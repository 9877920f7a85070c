"""Loads carry the right totals; essential conditions hold exactly, moving ones too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud import build_cloud
from sphsolid.cloud.cloud import Cloud
from sphsolid.errors import InputError
from sphsolid.scenes import Box, Constraint, Scene, Traction
from sphsolid.scheme.boundary import EssentialConditions, Loads
from tests.oracles.blocks import (
    RUBBER,
    held_in_loaded_block,
    loaded_block,
    loads_in_loaded_block,
    velocity_in_loaded_block,
)

Array = NDArray[np.float64]
BODY = Box(upper=(1.0, 0.8, 1.2), jitter=0.3)


def cloud_of(scene: Scene) -> Cloud:
    return build_cloud(
        scene.body.mesh(0.2), smoothing=sph.WendlandC2(), h_over_dx=0.9, operator=sph.Literal()
    )


def loads_of(**options: object) -> tuple[Loads, Cloud]:
    scene = Scene("loaded", BODY, RUBBER, 1.0, **options)  # type: ignore[arg-type]
    cloud = cloud_of(scene)
    return Loads(scene, cloud), cloud


def total(cloud: Cloud, density: Array) -> Array:
    return np.sum(cloud.V[:, None] * density, axis=0)


def test_a_linear_traction_has_the_resultant_of_its_face() -> None:
    """``int (3, Y, Z) dA`` over ``X+``, 0.8 x 1.2 m: the areas of a plane face sum linears."""
    traction = Traction("X+", lambda X, N, t: np.stack([0 * X[:, 0] + 3, X[:, 1], X[:, 2]], 1))
    loads, cloud = loads_of(tractions=(traction,))
    assert loads.any
    assert not loads.has_body_force
    E, f0 = loads.at(0.0)
    np.testing.assert_allclose(total(cloud, E), 0.96 * np.array([3.0, 0.4, 0.6]), rtol=1e-13)
    np.testing.assert_array_equal(f0, 0.0)
    on_face = np.isclose(cloud.X[:, 0], 1.0)
    assert np.all(E[~on_face] == 0.0)
    assert np.all(E[on_face, 0] > 0.0)


def test_a_pressure_follows_the_outward_normal_and_closes_on_itself() -> None:
    def pressure(X: Array, N: Array, t: float) -> Array:
        np.testing.assert_allclose(np.linalg.norm(N, axis=1), 1.0, rtol=1e-14)
        return -N

    tractions = tuple(Traction(face, pressure) for face in ("X-", "X+", "Y-", "Y+", "Z-", "Z+"))
    loads, cloud = loads_of(tractions=tractions)
    E, _ = loads.at(0.0)
    np.testing.assert_allclose(total(cloud, E), 0.0, atol=1e-14)
    outward = np.sign(np.round(cloud.X - [0.5, 0.4, 0.6], 12) / [0.5, 0.4, 0.6])
    corner = np.argmin(np.sum((cloud.X - [1.0, 0.8, 1.2]) ** 2, axis=1))
    assert np.all(E[corner] * outward[corner] < 0.0)  # three faces meet there, all three push
    # Each particle feels its own area vector: E_a V_a = -A_a N_a.
    np.testing.assert_allclose(cloud.V[:, None] * E, -cloud.areas, atol=1e-14)


def test_a_body_force_acts_on_every_particle_and_only_there() -> None:
    loads, cloud = loads_of(body_force=lambda X, t: np.full_like(X, 2.0 + t))
    E, f0 = loads.at(0.5)
    np.testing.assert_array_equal(E, f0)
    np.testing.assert_allclose(total(cloud, E), 2.5 * BODY.volume, rtol=1e-13)
    assert loads.has_body_force


def test_loads_are_those_of_the_instant_asked_for() -> None:
    scene = loaded_block()
    cloud = cloud_of(scene)
    loads = Loads(scene, cloud)
    for t in (0.0, 2e-3, 2e-3, 0.0, 1e-3):
        E, f0 = loads.at(t)
        expected = loads_in_loaded_block(cloud, t)
        np.testing.assert_allclose(E, expected[0], rtol=1e-13, atol=1e-6)
        np.testing.assert_array_equal(f0, expected[1])


def test_no_load_is_nothing_and_a_load_that_is_not_finite_is_refused() -> None:
    assert not loads_of()[0].any
    bad, _ = loads_of(body_force=lambda X, t: X / 0.0 if t > 0.1 else X)
    bad.at(0.0)
    with np.errstate(all="ignore"), pytest.raises(InputError, match=r"body force .* t = 0.2 s"):
        bad.at(0.2)
    bad, _ = loads_of(tractions=(Traction("Z+", lambda X, N, t: np.nan * X),))
    with pytest.raises(InputError, match=r"traction on Z\+"):
        bad.at(0.0)
    with pytest.raises(InputError, match="'lid' is unknown"):
        loads_of(tractions=(Traction("lid", lambda X, N, t: X),))


def test_impose_sets_what_is_held_and_nothing_else() -> None:
    scene = loaded_block()
    cloud = cloud_of(scene)
    essential = EssentialConditions(scene, cloud)
    held = held_in_loaded_block(cloud.X)
    before = np.random.default_rng(2).normal(size=cloud.X.shape)
    p = before.copy()
    essential.impose(p, 0.7)
    np.testing.assert_array_equal(p[~held], before[~held])
    exact = scene.material.density * velocity_in_loaded_block(cloud.X, 0.7)
    np.testing.assert_allclose(p[held], exact[held], rtol=1e-14)
    again = p.copy()
    essential.impose(again, 0.7)
    np.testing.assert_array_equal(again, p)

    rate = before.copy()
    essential.release(rate)
    np.testing.assert_array_equal(rate, np.where(held, 0.0, before))


def test_a_scene_without_constraints_is_left_alone() -> None:
    scene = Scene("free", BODY, RUBBER, 1.0)
    essential = EssentialConditions(scene, cloud_of(scene))
    p = np.ones((5, 3))
    essential.impose(p, 0.0)
    essential.release(p)
    np.testing.assert_array_equal(p, 1.0)
    assert len(essential.particles) == 0


@pytest.mark.parametrize("formulation", [sph.PF(), sph.PFHJ(), sph.Displacement()])
def test_a_prescribed_velocity_holds_after_every_step_of_a_run(formulation: object) -> None:
    scene = loaded_block()
    sim = sph.Simulation(scene, spacing=0.4, formulation=formulation)  # type: ignore[arg-type]
    X = sim.cloud.X
    held = held_in_loaded_block(X)
    start = sim.state.x.copy()
    for _ in range(8):
        velocity = sim.snapshot().velocity
        np.testing.assert_allclose(
            velocity[held], velocity_in_loaded_block(X, sim.time)[held], rtol=1e-13, atol=1e-15
        )
        sim.advance(sim.stable_time_step())
    # driven is linear in t, so its trapezoidal path is exact.
    half = velocity_in_loaded_block(X, 0.5 * sim.time)
    moved = (sim.state.x - start)[held]
    np.testing.assert_allclose(moved, sim.time * half[held], rtol=1e-11, atol=1e-16)


def test_a_clamp_that_moves_rigidly_carries_a_stress_free_body() -> None:
    """All particles start with the velocity of the clamp: nothing strains, nothing is loaded."""

    def along(X: Array, t: float) -> Array:
        return np.broadcast_to([3.0, -1.0, 2.0], X.shape)

    scene = Scene(
        "carried", BODY, RUBBER, 1.0,
        initial_velocity=lambda X: along(X, 0.0), constraints=(Constraint("Y-", "all", along),),
    )  # fmt: skip
    sim = sph.Simulation(scene, spacing=0.2)
    for _ in range(20):
        sim.advance(sim.stable_time_step())
    s = sim.snapshot()
    np.testing.assert_allclose(s.velocity, along(s.X, 0.0), rtol=1e-11)
    assert np.max(np.abs(s.P)) < 1e-10 * RUBBER.mu


SQUARE = (1.0, 1.0, 1.0)


@pytest.mark.parametrize("operator", [sph.Literal(), sph.SummationByParts()])
@pytest.mark.parametrize(
    ("field", "force"),
    [
        (lambda X, N, t: np.broadcast_to([0.0, 0.0, 1e3], X.shape), 6000.0),
        (lambda X, N, t: np.where(X[:, 2:] > 0.999, [0.0, 0.0, 1e3], 0.0), None),
        (lambda X, N, t: np.where(N[:, 2:] > 0.9, [0.0, 0.0, 1e3], 0.0), 1000.0),
        (lambda X, N, t: -N, 0.0),
    ],
)
def test_a_tag_round_its_edges_carries_the_load_of_all_its_sides(operator, field, force) -> None:
    """The skin of a unit cube under one tag: 6 m^2, and a normal for each of its sides."""
    mesh = Box(upper=SQUARE).mesh(0.25)
    skin = replace(mesh, faces={"skin": np.concatenate(list(mesh.faces.values()))})
    cloud = build_cloud(skin, smoothing=sph.WendlandC2(), h_over_dx=1.0, operator=operator)
    scene = Scene("skin", Box(upper=SQUARE), RUBBER, 1.0, tractions=(Traction("skin", field),))
    E, _ = Loads(scene, cloud).at(0.0)
    if force is None:
        # Of the sides too, where they meet the top: a half spacing of each.
        force = 1000.0 * (1.0 + 4 * 0.125)
    np.testing.assert_allclose(total(cloud, E), [0.0, 0.0, force], atol=1e-9 * 6000.0)
