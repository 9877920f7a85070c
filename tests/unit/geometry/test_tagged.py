"""Regions of faces: tags split, never overlap, and a condition on one binds only there."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import area_vectors
from sphsolid.scenes import Box, Constraint, Region, Scene, Tagged
from sphsolid.scenes.punch import UpTo

LEFT = Region("left", "Z+", UpTo(0.5))


def area(mesh, name):
    return area_vectors(mesh, mesh.face(name)).sum(axis=0)


def test_a_face_is_split_and_the_boundary_is_not_counted_twice():
    box = Box(jitter=0.3)
    plain, split = box.mesh(0.125), Tagged(box, (LEFT,)).mesh(0.125)
    assert set(split.faces) == {*plain.faces, "left"}
    np.testing.assert_allclose(area(split, "left") + area(split, "Z+"), [0, 0, 1], atol=1e-14)
    assert len(split.face("left")) == len(split.face("Z+")) == 32
    assert len(split.boundary) == len(plain.boundary)
    assert {tuple(q) for q in split.boundary} == {tuple(q) for q in plain.boundary}
    np.testing.assert_allclose(
        area_vectors(split, split.boundary), area_vectors(plain, plain.boundary), atol=1e-15
    )
    np.testing.assert_array_equal(split.vertices, plain.vertices)
    assert Tagged(box, (LEFT,)).volume == box.volume


def test_a_region_ends_on_the_mesh():
    mesh = Tagged(Box(), (LEFT,)).mesh(0.25)
    assert mesh.vertices[mesh.face_particles("left")][:, 0].max() == 0.5
    assert area(Tagged(Box(), (LEFT,)).mesh(1.0 / 3.0), "left")[2] == pytest.approx(2.0 / 3.0)


def test_the_first_region_wins_and_a_face_may_be_used_up():
    wide = Region("wide", "Z+", UpTo(1.0))
    mesh = Tagged(Box(), (LEFT, wide)).mesh(0.25)
    assert area(mesh, "left")[2] == pytest.approx(0.5)
    assert area(mesh, "wide")[2] == pytest.approx(0.5)
    assert "Z+" not in mesh.faces
    assert len(mesh.boundary) == len(Box().mesh(0.25).boundary)


def test_a_condition_on_a_region_binds_only_there(soft):
    """Pulling a region up at 1 m/s moves its particles, and them only, before any wave arrives."""

    def up(X, t):
        return np.tile([0.0, 0.0, 1.0], (len(X), 1))

    scene = Scene(
        name="pulled",
        body=Tagged(Box(), (LEFT,)),
        material=soft,
        end_time=1.0,
        constraints=(Constraint("left", "all", up),),
    )
    for sim in (fem.Simulation(scene, spacing=0.25), sph.Simulation(scene, spacing=0.25)):
        snapshot = sim.snapshot()
        held = (snapshot.X[:, 2] == 1.0) & (snapshot.X[:, 0] <= 0.5)
        np.testing.assert_array_equal(snapshot.velocity[held], np.tile([0, 0, 1], (held.sum(), 1)))
        np.testing.assert_array_equal(snapshot.velocity[~held], 0.0)


@pytest.fixture
def soft():
    return sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1000.0)


@pytest.mark.parametrize(
    ("region", "named"),
    [
        (Region("X+", "Z+", UpTo(0.5)), "taken"),
        (Region("left", "top", UpTo(0.5)), r"'top'.*'X\+'"),
        (Region("left", "Z+", UpTo(0.1)), "no facet.*spacing 0.25"),
        (Region("left", "Z+", lambda X: X[:, 0]), "bool"),
        (Region("left", "Z+", lambda X: X > 0.5), "shape"),
    ],
)
def test_bad_regions_are_refused(region, named):
    with pytest.raises(InputError, match=named):
        Tagged(Box(), (region,)).mesh(0.25)
