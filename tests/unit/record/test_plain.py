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


EQUAL += [
    (np.arange(2000.0), np.arange(2000.0)),
    (np.asfortranarray(np.eye(3)), np.eye(3)),
    ({"a": 1, "b": 2}, {"b": 2.0, "a": 1.0}),
    ({"a", "b", "c"}, {"c", "b", "a"}),
    (np.True_, True),
]


@pytest.mark.parametrize(("one", "other"), EQUAL)
def test_equal_values_read_the_same(one, other):
    assert plain(one) == plain(other)


def changed(array, index):
    """``array`` with another number in its middle, which ``repr`` leaves out."""
    array = array.copy()
    array[index] += 1
    return array


def objects(array):
    held = np.empty(1, dtype=object)
    held[0] = array
    return held


@dataclasses.dataclass(frozen=True)
class Held:
    table: np.ndarray


LONG = np.arange(2000.0)
MANY = np.zeros((200, 40), dtype=np.int32)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (LONG, changed(LONG, 1000)),
        (MANY, changed(MANY, (100, 20))),
        ({"table": LONG}, {"table": changed(LONG, 1000)}),
        ((LONG, 1), (changed(LONG, 1000), 1)),
        (Held(LONG), Held(changed(LONG, 1000))),
        (LONG, LONG.reshape(2, -1)),
        (LONG, LONG.astype(np.float32)),
        (objects(LONG), objects(changed(LONG, 1000))),
        (np.ma.masked_less(LONG, 5.0), np.ma.masked_less(LONG, 6.0)),
    ],
)
def test_arrays_are_known_by_all_their_bytes(one, other):
    assert plain(one) != plain(other)


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
