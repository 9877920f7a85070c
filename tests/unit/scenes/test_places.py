"""Probes are part of the problem: nobody changes them, and otherwise they are a dict."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle

import pytest

from sphsolid.errors import InputError
from sphsolid.record.plain import plain
from sphsolid.scenes import swinging_cube
from sphsolid.scenes.scene import Scene

GIVEN = {"corner": (1.0, 1.0, 1.0)}


def changes():
    def joined(probes):
        probes |= {"new": (0.0, 0.0, 0.0)}

    def taken(probes):
        del probes["corner"]

    return [
        lambda probes: probes.__setitem__("corner", (0.0, 0.0, 0.0)),
        lambda probes: probes.update(new=(0.0, 0.0, 0.0)),
        lambda probes: probes.setdefault("new", (0.0, 0.0, 0.0)),
        lambda probes: probes.pop("corner"), lambda probes: probes.popitem(),
        lambda probes: probes.clear(), joined, taken,
    ]  # fmt: skip


@pytest.mark.parametrize("change", changes())
def test_nobody_changes_the_probes_of_a_scene(change):
    scene = swinging_cube()
    for each in (scene, copy.deepcopy(scene), pickle.loads(pickle.dumps(scene.probes))):
        probes = each.probes if isinstance(each, Scene) else each
        with pytest.raises(InputError, match="the probes of a scene cannot be changed"):
            change(probes)
        assert probes == GIVEN


def test_they_are_a_dict_in_every_other_way():
    probes = swinging_cube().probes
    assert repr(probes) == repr(GIVEN)
    assert plain(probes) == plain(GIVEN)
    assert json.dumps(probes) == json.dumps(GIVEN)
    assert probes | {"a": (0.0, 0.0, 0.0)} == {**GIVEN, "a": (0.0, 0.0, 0.0)}
    for again in (copy.copy(probes), copy.deepcopy(probes), pickle.loads(pickle.dumps(probes))):
        assert again == probes
        assert repr(again) == repr(probes)
    own = probes.copy()
    own["b"] = (0.0, 0.0, 0.0)
    assert probes == GIVEN


def test_a_scene_reads_and_compares_as_before():
    one, other = swinging_cube(), swinging_cube()
    assert one.probes == other.probes
    assert "probes={'corner': (1.0, 1.0, 1.0)}" in repr(one)
    moved = dataclasses.replace(one, probes=one.probes | {"middle": (0.5, 0.5, 0.5)})
    assert set(moved.probes) == {"corner", "middle"}
    assert dataclasses.asdict(moved)["probes"] == moved.probes


def test_what_was_given_may_change_later():
    given = dict(GIVEN)
    scene = dataclasses.replace(swinging_cube(), probes=given)
    given["corner"] = (0.0, 0.0, 0.0)
    assert scene.probes == GIVEN
