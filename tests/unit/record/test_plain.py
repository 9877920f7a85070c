"""Equal options are equal in words, whatever the types of their numbers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry import Box
from sphsolid.record.checkpoint import common_identity
from sphsolid.record.plain import plain
from sphsolid.scenes.scene import Scene

EQUAL = [
    (1, 1.0),
    (np.float64(0.5), 0.5),
    (np.int64(2), 2.0),
    (np.float32(0.5), 0.5),
    ((1, 2), [1.0, np.float64(2)]),
    (sph.OfMesh(1), sph.OfMesh(np.float64(1.0))),
    (sph.SUPG(tau_F=sph.OfMesh(1)), sph.SUPG(tau_F=sph.OfMesh(1.0))),
    (
        sph.NeoHookean(mu=380000, kappa=np.int64(2), density=1000),
        sph.NeoHookean(mu=380000.0, kappa=2.0, density=np.float64(1000)),
    ),
]


@pytest.mark.parametrize(("one", "other"), EQUAL)
def test_equal_values_read_the_same(one, other):
    assert plain(one) == plain(other)


@pytest.mark.parametrize(
    ("one", "other"),
    [(1.0, 1.0 + 1e-15), (True, 1), ("1", 1), (sph.PF(), sph.PFJ()), (None, 0)],
)
def test_others_do_not(one, other):
    assert plain(one) != plain(other)


def test_what_it_says_can_be_read():
    assert plain(sph.OfMesh(1)) == "OfMesh(c=1.0)"
    assert plain(sph.PF()) == "PF()"


def test_a_problem_is_known_by_the_values_of_its_material():
    mesh = Box().mesh(0.5)
    one = Scene("s", Box(), sph.NeoHookean(mu=380000, kappa=800000, density=1000), np.int64(1))
    other = dataclasses.replace(
        one, material=sph.NeoHookean(mu=380000.0, kappa=np.float64(8e5), density=1e3), end_time=1.0
    )
    V = np.ones(len(mesh.vertices))
    here, there = (common_identity(scene, scene.material, mesh, V) for scene in (one, other))
    assert here == there
    assert type(one.end_time) is float
