"""Only what this package wrote from end to end is kept on disk: an edit of a user's text is seen.

Nothing is solved here: an operator that would be says how often it was asked.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud import operator_cache
from sphsolid.cloud.lengths import Uniform
from sphsolid.cloud.operator import Gradients, Ingredients
from sphsolid.cloud.operator_cache import gradients_of
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.geometry import Box
from sphsolid.geometry.mesh import HexMesh

MESH = Box().mesh(0.5)
COUNT = len(MESH.vertices)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(operator_cache, "cache_base", lambda: tmp_path)
    monkeypatch.setattr(operator_cache, "LEAST_PARTICLES", 0)
    for kind in (sph.Consistent, sph.SummationByParts):
        monkeypatch.setattr(kind, "build", lambda self, cloud: made(1.0))
    return tmp_path / "operators"


def made(number: float) -> Gradients:
    G = np.full((COUNT, 3), number)
    return Gradients(G, G, np.zeros((COUNT, 3)))


def ingredients(smoothing: Any, mesh: Any = MESH) -> Ingredients:
    own = np.arange(COUNT)
    return Ingredients(
        mesh, np.ones(COUNT), np.zeros((COUNT, 3)),
        PairList(np.arange(COUNT + 1), own.astype(np.int32)), smoothing, Uniform(0.5, 1.0),
    )  # fmt: skip


def edited(text: str) -> Any:
    """A class as a user's file has it, before and after an edit of its ``build``."""
    held: dict[str, Any] = {"__name__": "own_file", "sph": sph, "dataclass": dataclass}
    held["made"] = made
    exec(text, held)
    return held["Own"]


@dataclass(frozen=True)
class OwnSmoothing:
    """Of a user; its text may be edited."""

    support: float = 2.0


class Narrower(sph.WendlandC2):
    pass


class Weight(float):
    pass


class OwnMesh(HexMesh):
    pass


@pytest.mark.parametrize("smoothing", [sph.WendlandC2(), sph.CubicSpline(), sph.QuinticSpline()])
@pytest.mark.parametrize(
    "operator",
    [sph.Consistent(), sph.SummationByParts(), sph.Consistent(weight_exponent=np.float64(0.25))],
)
def test_what_is_ours_is_kept(folder: Path, operator: Any, smoothing: Any) -> None:
    gradients_of(operator, ingredients(smoothing))
    assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("smoothing", [OwnSmoothing(), Narrower()])
def test_a_smoothing_function_of_a_users_own_is_not(folder: Path, smoothing: Any) -> None:
    gradients_of(sph.SummationByParts(), ingredients(smoothing))
    assert not folder.exists()


OWN = [
    "@dataclass(frozen=True)\nclass Own(sph.Consistent):\n",
    "class Own(sph.SummationByParts):\n",
    "@dataclass(frozen=True)\nclass Own:\n    is_kept = True\n    name = 'Own'\n",
    "class Own(sph.Consistent):\n    __module__ = 'sphsolid.cloud.operator'\n",
]
BUILD = "    def build(self, cloud):\n        return made(7.0)\n"


@pytest.mark.parametrize("head", OWN)
def test_an_edited_operator_of_a_users_own_is_built_anew(folder: Path, head: str) -> None:
    cloud = ingredients(sph.WendlandC2())
    for number in (7.0, 8.0):
        operator = edited(head + BUILD.replace("7.0", str(number)))()
        assert gradients_of(operator, cloud).force[0, 0] == number
    assert not folder.exists()


def test_ours_with_a_number_of_a_users_own_class_is_not_kept(folder: Path) -> None:
    gradients_of(sph.Consistent(weight_exponent=Weight(0.5)), ingredients(sph.WendlandC2()))
    assert not folder.exists()


def test_on_a_mesh_of_a_users_own_class_nothing_is_kept(folder: Path) -> None:
    parts = {each.name: getattr(MESH, each.name) for each in fields(HexMesh)}
    gradients_of(sph.Consistent(), ingredients(sph.WendlandC2(), OwnMesh(**parts)))
    assert not folder.exists()
