"""Whatever makes up a law is in the name of its type in kernels."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import numpy as np
import pytest

import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.continuum.law_types import __getattr__ as type_of_name
from sphsolid.continuum.tensor import IDENTITY
from sphsolid.kernel_cache import is_foreign
from tests.oracles.laws import LAWS

#: A law in a module of the user's own; ``helpers`` is another one.
TEXT = """
from typing import NamedTuple
import numpy as np
import numba
import helpers
from helpers import bulk
from sphsolid.continuum.law import register_law
from sphsolid.continuum.tensor import contract, scale
FACTOR = 1.0
TABLE = np.array([1.0, 2.0])
class MyLaw(NamedTuple):
    mu: float
    kappa: float
    density: float
    depends_on_H = False
@numba.njit
def doubled(x):
    return 2.0 * x
def energy(m, F, H, J):
    return FACTOR * helpers.shear(m.mu) * contract(F, F) + bulk(m, J) + doubled(TABLE[1])
def conjugate_stresses(m, F, H, J):
    return scale(2.0 * FACTOR * m.mu, F), scale(0.0, H), 0.0 * J
def first_piola(m, F, H, J):
    return scale(2.0 * FACTOR * m.mu, F)
def hessian_action(m, F, H, J, dF, dH, dJ):
    return scale(2.0 * FACTOR * m.mu, dF), scale(0.0, dH), 0.0 * dJ
register_law(MyLaw, energy=energy, conjugate_stresses=conjugate_stresses,
             first_piola=first_piola, hessian_action=hessian_action)
"""
HELPERS = """
SCALE = 0.5
def shear(mu):
    return SCALE * mu
def bulk(m, J):
    return deeper(m.kappa) * (J - 1.0)
def deeper(kappa):
    return 0.25 * kappa
"""
UNUSED = "\ndef nobody_calls_this():\n    return 1\n"


def module(name: str, text: str) -> ModuleType:
    made = ModuleType(name)
    sys.modules[name] = made
    exec(compile(text, f"{name}.py", "exec"), vars(made))
    return made


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch) -> Any:
    for name in ("mylaw", "helpers"):
        monkeypatch.delitem(sys.modules, name, raising=False)
        monkeypatch.setitem(sys.modules, name, ModuleType(name))

    def loaded(text: str = TEXT, helpers: str = HELPERS) -> Any:
        module("helpers", helpers)
        return module("mylaw", text)

    return loaded


def in_kernels(loaded: ModuleType) -> Any:
    return law.in_kernels(loaded.MyLaw(1.0, 2.0, 3.0))


@numba.njit
def energy_in_a_kernel(material, J):  # type: ignore[no-untyped-def]
    return law.energy(material, IDENTITY, IDENTITY, J)


def test_the_same_text_is_the_same_law(load: Any) -> None:
    first = type(in_kernels(load()))
    assert type(in_kernels(load())) is first
    assert type(in_kernels(load(TEXT + UNUSED, HELPERS + UNUSED))) is first


@pytest.mark.parametrize(
    ("text", "helpers"),
    [
        (TEXT.replace("FACTOR = 1.0", "FACTOR = 0.25"), HELPERS),
        (TEXT.replace("[1.0, 2.0]", "[1.0, 3.0]"), HELPERS),
        (TEXT.replace("2.0 * x", "3.0 * x"), HELPERS),
        (TEXT.replace("@numba.njit", "@numba.njit(fastmath=True)"), HELPERS),
        (TEXT.replace("density: float", "density: float\n    more: float = 1.0"), HELPERS),
        (TEXT.replace("return scale(2.0 * FACTOR * m.mu, F)", "return scale(m.mu, F)"), HELPERS),
        (TEXT, HELPERS.replace("SCALE = 0.5", "SCALE = 0.75")),
        (TEXT, HELPERS.replace("0.25 * kappa", "0.5 * kappa")),
    ],
    ids=["constant", "table", "compiled helper", "its options", "fields", "stress",
         "constant of another module", "helper of a helper"],
)  # fmt: skip
def test_any_change_is_another_law(load: Any, text: str, helpers: str) -> None:
    before = type(in_kernels(load()))
    changed = load(text, helpers)
    assert type(in_kernels(changed)) is not before


def test_a_kernel_follows_every_edit_in_the_same_process(load: Any) -> None:
    """Reloaded text, a helper edited elsewhere, a constant set by hand, a function replaced."""

    def both(loaded: ModuleType) -> tuple[float, float]:
        material = loaded.MyLaw(1.0, 2.0, 3.0)
        found = energy_in_a_kernel(law.in_kernels(material), 1.5)
        return found, law.energy(material, IDENTITY, IDENTITY, 1.5)

    found, expected = both(load())
    assert found == pytest.approx(expected) == pytest.approx(1.5 + 0.25 + 4.0)
    found, expected = both(load(TEXT.replace("FACTOR = 1.0", "FACTOR = 3.0")))
    assert found == pytest.approx(expected) == pytest.approx(4.5 + 0.25 + 4.0)
    found, expected = both(load(TEXT, HELPERS.replace("0.25 * kappa", "0.5 * kappa")))
    assert found == pytest.approx(expected) == pytest.approx(1.5 + 0.5 + 4.0)
    # Nothing is registered again: the same functions with another constant, deep down.
    sys.modules["helpers"].SCALE = 1.0  # type: ignore[attr-defined]
    found, expected = both(sys.modules["mylaw"])
    assert found == pytest.approx(expected) == pytest.approx(3.0 + 0.5 + 4.0)
    mine: Any = sys.modules["mylaw"]
    law.register_law(
        mine.MyLaw, energy=lambda m, F, H, J: m.mu * J,
        conjugate_stresses=mine.conjugate_stresses, first_piola=mine.first_piola,
        hessian_action=mine.hessian_action,
    )  # fmt: skip
    found, expected = both(mine)
    assert found == pytest.approx(expected) == pytest.approx(1.5)


def test_laws_of_the_package_keep_their_own_types() -> None:
    rubber = sph.NeoHookean(1.0, 2.0, 3.0)
    assert law.in_kernels(rubber) is rubber
    mine = law.in_kernels(LAWS[0])
    assert law.in_kernels(mine) is mine
    assert isinstance(mine, type(LAWS[0]))
    assert mine == LAWS[0]


def test_what_kernels_are_handed_can_be_copied_and_pickled() -> None:
    mine = law.in_kernels(LAWS[0])
    for again in (copy.deepcopy(mine), pickle.loads(pickle.dumps(mine))):
        assert type(again) is type(mine)
        assert again == mine


def test_a_law_that_was_copied_or_pickled_is_the_same_law(load: Any) -> None:
    """Both write a name into the class, the first time."""
    material = load().MyLaw(1.0, 2.0, 3.0)
    before = type(law.in_kernels(material))
    assert pickle.loads(pickle.dumps(copy.deepcopy(material))) == material
    assert "__slotnames__" in vars(type(material))
    assert type(law.in_kernels(material)) is before


def test_the_name_of_a_law_of_another_program_can_be_read() -> None:
    assert issubclass(type_of_name("Law_0123456789abcdef"), tuple)
    with pytest.raises(AttributeError):
        type_of_name("anything_else")


PROGRAM = """
import sys
import numpy as np
from sphsolid.compiled import cache_base
from sphsolid.continuum import NeoHookean, law
from kernel_of_all import work
try:
    import mylaw
    material = law.in_kernels(mylaw.MyLaw(1.0, 2.0, 3.0))
except ModuleNotFoundError:
    material = NeoHookean(1.0, 2.0, 3.0)
out = np.zeros(1)
work(material, out)
print(out[0], sum(work._cache_hits.values()))
"""
KERNEL = """
from sphsolid.compiled import serial_kernel
from sphsolid.continuum import law
I = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
@serial_kernel
def work(material, out):
    out[0] = law.energy(material, I, I, 1.5)
"""


def test_a_kernel_of_a_class_as_it_is_is_not_stored() -> None:
    rubber, mine = sph.NeoHookean(1.0, 2.0, 3.0), LAWS[0]
    assert is_foreign(numba.typeof(mine))
    assert is_foreign(numba.typeof((1, mine)))
    for kept in (rubber, law.in_kernels(mine), (1.0, 2), np.zeros(3), (1, rubber)):
        assert not is_foreign(numba.typeof(kept))


@pytest.mark.slow
def test_programs_share_a_cache_without_a_trace_of_one_another(tmp_path: Path) -> None:
    """The old text, the new text, a program without the law, one with a law of the same name."""
    shared, one, two = (tmp_path / name for name in ("shared", "one", "two"))
    for folder in (shared, one, two):
        folder.mkdir()
    (shared / "kernel_of_all.py").write_text(KERNEL)

    def run(folder: Path) -> list[float]:
        there = os.environ | {
            "PYTHONPATH": os.pathsep.join(map(str, (shared, folder, Path.cwd()))),
            "SPHSOLID_CACHE": str(tmp_path / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], env=there, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return [float(word) for word in done.stdout.split()]

    def write(folder: Path, text: str, helpers: str = HELPERS) -> None:
        (folder / "mylaw.py").write_text(text)
        (folder / "helpers.py").write_text(helpers)

    write(one, TEXT)
    assert run(one) == [5.75, 0]
    # Compiled once, then read.
    assert run(one) == [5.75, 1]
    write(one, TEXT.replace("FACTOR = 1.0", "FACTOR = 3.0"))
    assert run(one) == [8.75, 0]
    write(one, TEXT, HELPERS.replace("SCALE = 0.5", "SCALE = 1.0"))
    assert run(one) == [7.25, 0]
    write(one, TEXT)
    assert run(one) == [5.75, 1]
    # A law of the same name and another text, in another program.
    write(two, TEXT.replace("2.0 * x", "0.0 * x"))
    assert run(two) == [1.75, 0]
    # A program that knows none of these laws.
    neo_hookean = 0.5 * 1.5 ** (-2 / 3) * 3.0 + 0.25
    found, hits = run(shared)
    assert found == pytest.approx(neo_hookean)
    assert hits == 0
    assert run(shared)[1] == 1
    assert np.isfinite(found)
