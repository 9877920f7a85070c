"""The punch test: published lattices, and the readings of its velocity."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes import Constraint, HeldVelocity, InitialVelocity, punch

INITIAL, TOP, HELD = InitialVelocity(), InitialVelocity(where="top"), HeldVelocity()


def momentum(scene, spacing):
    """``sum V rho0 v_z`` [kg m/s] of the initial state."""
    mesh = scene.body.mesh(spacing)
    _, v = scene.initial_state(mesh.vertices)
    assert not v[:, :2].any()
    return scene.material.density * float(vertex_volumes(mesh) @ v[:, 2])


@pytest.mark.parametrize("press", [INITIAL, TOP, HELD])
@pytest.mark.parametrize(
    ("spacing", "lattice"), [(1 / 20, (21, 3, 11)), (1 / 40, (41, 4, 21)), (1 / 80, (81, 7, 41))]
)
def test_published_lattices(press, spacing, lattice):
    mesh = punch(press=press).body.mesh(spacing)
    assert tuple(len(np.unique(mesh.vertices[:, d])) for d in range(3)) == lattice
    assert mesh.spacing == pytest.approx(spacing)
    assert vertex_volumes(mesh).sum() == pytest.approx(0.05, rel=1e-13)


def test_published_data():
    scene = punch()
    assert scene.end_time == 0.015
    assert scene.body.volume == pytest.approx(0.05)
    assert scene.material.density == 1000.0
    assert scene.material.kappa / scene.material.mu == pytest.approx(500.0, rel=2e-3)
    assert {(c.face, c.direction) for c in scene.constraints} == {
        (face, "normal") for face in ("X-", "X+", "Y-", "Y+", "Z-")
    }
    assert "Not published: region" in scene.provenance
    assert "InitialVelocity(limit=0.5, where='height')" in scene.provenance


def test_initial_momentum_of_each_reading():
    """Half the block and the column of particles on its edge; of the top face a layer dx / 2."""
    for spacing in (1 / 20, 1 / 40):
        half = 0.5 + 0.5 * spacing
        assert momentum(punch(), spacing) == pytest.approx(-10.0 * 1000.0 * 0.05 * half)
        layer = -10.0 * 1000.0 * 0.1 * half * 0.5 * spacing
        assert momentum(punch(press=TOP), spacing) == pytest.approx(layer)
        assert momentum(punch(press=HELD), spacing) == pytest.approx(layer)


def test_the_region_is_a_parameter():
    X = np.array([[0.2, 0.0, 0.5], [0.3, 0.05, 0.1], [0.3000001, 0.0, 0.5], [1.0, 0.1, 0.5]])
    _, v = punch(press=InitialVelocity(limit=0.3), speed=4.0).initial_state(X)
    np.testing.assert_array_equal(v[:, 2], [-4.0, -4.0, 0.0, 0.0])
    _, v = punch(press=InitialVelocity(limit=1.0, where="top"), speed=4.0).initial_state(X)
    np.testing.assert_array_equal(v[:, 2], [-4.0, 0.0, -4.0, -4.0])


@pytest.mark.parametrize("direction", ["normal", "all"])
@pytest.mark.parametrize("solver", [fem.Simulation, sph.Simulation])
def test_held_particles_move_at_the_speed_and_the_sides_stay(direction, solver):
    scene = punch(press=HeldVelocity(direction=direction))
    sim = solver(scene, spacing=1 / 10)
    sim.run(until=1e-3)
    s = sim.snapshot()
    pressed = (s.X[:, 2] == 0.5) & (s.X[:, 0] <= 0.5)
    np.testing.assert_allclose(s.displacement[pressed, 2], -0.01, rtol=1e-12)
    np.testing.assert_array_equal(s.velocity[pressed, 2], -10.0)
    slides = np.abs(s.displacement[pressed & (s.X[:, 0] > 0.0), 0])
    assert np.all(slides > 0.0) if direction == "normal" else not slides.any()
    for axis, plane in ((0, 0.0), (0, 1.0), (1, 0.0), (1, 0.1), (2, 0.0)):
        on_plane = np.isclose(s.X[:, axis], plane, atol=1e-12)
        np.testing.assert_array_equal(s.displacement[on_plane, axis], 0.0)
    free = (s.X[:, 2] == 0.5) & (s.X[:, 0] > 0.5)
    assert s.displacement[free, 2].max() > 0.0


def test_held_and_initial_differ_in_their_conditions_only_on_the_top():
    held, initial = punch(press=HELD), punch()
    assert held.constraints[1:] == initial.constraints
    pressed = held.constraints[0]
    assert (pressed.face, pressed.direction) == ("pressed", "normal")
    assert isinstance(pressed, Constraint)
    assert "Z+" in held.body.mesh(0.1).faces
    everything = punch(press=HeldVelocity(limit=1.0)).body.mesh(0.1)
    assert "Z+" not in everything.faces


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: InitialVelocity(limit=0.0), "limit"),
        (lambda: InitialVelocity(limit=1.1), "limit"),
        (lambda: HeldVelocity(limit=-0.5), "limit"),
        (lambda: HeldVelocity(limit=np.nan), "limit"),
        (lambda: InitialVelocity(where="side"), "where"),
        (lambda: HeldVelocity(direction="tangential"), "direction"),
        (lambda: punch(press="held"), "press"),
        (lambda: punch(speed=np.inf), "speed"),
    ],
)
def test_bad_input_is_refused(make, named):
    with pytest.raises(InputError, match=named):
        make()
