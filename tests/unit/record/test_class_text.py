"""An edit of a user's own class makes other words; comments, other processes and use do not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.geometry import Box
from sphsolid.record.class_text import text_of
from sphsolid.record.plain import plain
from sphsolid.run.base import BaseSimulation
from sphsolid.scenes.scene import Scene

OWN = '''
from dataclasses import dataclass
import numpy as np

STRENGTH = 2.0
TABLE = np.linspace(0.0, 1.0, 2000)
calls = 0


def helper(r):
    """What it says is no matter."""
    return 3.0 * r


@dataclass(frozen=True)
class Bump:
    c: float = 1.0

    tag = "bump"

    def value(self, r, h):
        global calls
        calls += 1
        return STRENGTH * helper(r) + TABLE[0] + 4.0

    @property
    def support(self):
        return 2.0


class Child(Bump):
    pass
'''
EDITS = [
    ("+ 4.0", "+ 5.0"), ("3.0 * r", "3.5 * r"), ("STRENGTH = 2.0", "STRENGTH = 2.5"),
    ("np.linspace(0.0, 1.0, 2000)", "np.linspace(0.0, 1.0, 2000) ** 2"),
    ("        return 2.0\n", "        return 2.5\n"), ('"bump"', '"hump"'), ("* helper(r)", "* r"),
]  # fmt: skip


def executed(text: str, name: str = "mine") -> Any:
    module = ModuleType(name)
    sys.modules[name] = module
    try:
        exec(text, vars(module))
    finally:
        del sys.modules[name]
    return module


@pytest.mark.parametrize("kind", ["Bump", "Child"])
@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_makes_other_words(kind: str, edit: tuple[str, str]) -> None:
    assert edit[0] in OWN
    one, other = executed(OWN), executed(OWN.replace(*edit))
    assert plain(getattr(one, kind)()) != plain(getattr(other, kind)())


@pytest.mark.parametrize(
    "edit",
    [
        ("STRENGTH = 2.0", "STRENGTH = 2.0  # as before"),
        ("is no matter", "counts as little"), ("calls = 0", "calls = 7"),
        ("\n\nclass Child", "\n\nOTHER = 1\n\n\nclass Child"),
    ],
)  # fmt: skip
def test_what_it_does_is_the_same_after_other_edits(edit: tuple[str, str]) -> None:
    assert edit[0] in OWN
    one, other = executed(OWN), executed(OWN.replace(*edit))
    assert plain(one.Bump()) == plain(other.Bump())


@pytest.mark.parametrize("place", ["smoothing", "operator", "terms"])
def test_a_simulation_is_known_by_the_text_of_its_options(place: str) -> None:
    mesh = Box().mesh(0.5)
    scene = Scene("s", Box(), sph.NeoHookean(mu=3.0, kappa=8.0, density=1.0), 1.0)
    found = []
    for text in (OWN, OWN, OWN.replace("+ 4.0", "+ 5.0")):
        option = executed(text).Bump()
        given = {place: (option,) if place == "terms" else option, "method": "SPH"}
        simulation: Any = SimpleNamespace(
            scene=scene, material=scene.material, _points=mesh, _volumes=np.ones(3),
            _options=lambda given=given: given,
        )  # fmt: skip
        found.append(BaseSimulation.identity(simulation))
    assert found[0] == found[1]
    assert {name for name in found[0] if found[0][name] != found[2][name]} == {place}


def test_use_changes_nothing() -> None:
    module = executed(OWN)
    before = plain(module.Bump())
    module.Bump().value(1.0, 1.0)
    assert module.calls == 1
    assert plain(module.Bump()) == before


def test_another_process_has_the_same_words(tmp_path: Path) -> None:
    """With hashes of strings of its own, and from a compiled file the second time."""
    (tmp_path / "own_file.py").write_text(OWN)
    asks = "import own_file; from sphsolid.record.plain import plain; print(plain(own_file.Bump()))"
    found = {
        subprocess.run(
            [sys.executable, "-c", asks], capture_output=True, text=True, check=True,
            env={"PYTHONPATH": f"{tmp_path}:{Path(sph.__file__).parents[1]}",
                 "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1
    assert found.pop().startswith("Bump(c=1.0) of text ")


def test_classes_of_the_package_and_of_libraries_have_no_text() -> None:
    for kind in (sph.Consistent, sph.WendlandC2, sph.NeoHookean, np.ndarray, dict, Path, float):
        assert text_of(kind) == ""
    assert text_of(type(test_use_changes_nothing)) == ""


def test_a_text_that_was_executed_without_a_name_is_read_too() -> None:
    found = []
    for factor in ("2.0", "3.0"):
        held: dict[str, Any] = {}
        exec(f"class Own:\n    def value(self, r):\n        return {factor} * r\n", held)
        found.append(text_of(held["Own"]))
    assert found[0] != found[1]
    assert all(found)


def test_what_cannot_be_read_is_left_out() -> None:
    class Awkward(type):
        def __getattribute__(cls, name: str) -> Any:
            if name == "__mro__":
                raise RuntimeError("not now")
            return super().__getattribute__(name)

    class Own(metaclass=Awkward):
        pass

    assert text_of(Own) == ""


def test_what_a_class_refers_to_may_refer_back() -> None:
    class Own:
        def again(self) -> Any:
            return Own()

    assert text_of(Own) == text_of(Own) != ""
