"""A law as a simulation met it: whatever it reads is followed by content, copied, or refused."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum import law
from sphsolid.continuum.check_law import check_first_use
from sphsolid.continuum.compiles import require_compilable
from sphsolid.continuum.tensor import IDENTITY
from sphsolid.errors import InputError
from sphsolid.geometry import Box
from sphsolid.scenes.scene import Scene

#: Shear by ``{factor}``, a formula over what ``{head}`` defines.
TEXT = """
import enum, fractions, functools, threading
from typing import NamedTuple
import numba
import numpy as np
from sphsolid.continuum import register_law
from sphsolid.continuum.tensor import add, axpy, contract, cross, scale
{head}
class MyLaw(NamedTuple):
    mu: float
    kappa: float
    density: float
    depends_on_H = False
    {own}
def factor(m): return {factor}
def energy(m, F, H, J):
    c = factor(m) * m.mu * J ** (-2 / 3)
    return 0.5 * c * contract(F, F) + 0.25 * m.kappa * (J * J - 1.0 - 2.0 * np.log(J))
def conjugate_stresses(m, F, H, J):
    c = factor(m) * m.mu * J ** (-2 / 3)
    return (scale(c, F), scale(0.0, H),
            0.5 * m.kappa * (J - 1.0 / J) - c * contract(F, F) / (3.0 * J))
def first_piola(m, F, H, J):
    S_F, S_H, S_J = conjugate_stresses(m, F, H, J)
    return axpy(S_J, H, add(S_F, cross(S_H, F)))
def hessian_action(m, F, H, J, dF, dH, dJ):
    c = factor(m) * m.mu * J ** (-2 / 3)
    W_FJ, W_JJ = -2.0 * c / (3.0 * J), 5.0 * c * contract(F, F) / (9.0 * J * J)
    W_JJ = W_JJ + 0.5 * m.kappa * (1.0 + 1.0 / (J * J))
    return axpy(W_FJ * dJ, F, scale(c, dF)), scale(0.0, dH), W_FJ * contract(F, dF) + W_JJ * dJ
register_law(MyLaw, energy=energy, conjugate_stresses=conjugate_stresses,
             first_piola=first_piola, hessian_action=hessian_action)
"""
STRETCHED = (1.2, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def module(head: str = "", factor: str = "1.0", own: str = "") -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(TEXT.format(head=head, factor=factor, own=own), names)
    return names


def material(names: dict[str, Any]) -> Any:
    return names["MyLaw"](4.0e5, 8.0e5, 1.0e3)


READ = {
    "Enum": ("class K(enum.Enum):\n    N = {}", "K.N.value"),
    "member": ("class K(enum.Enum):\n    N = {}\nk = K.N", "k.value"),
    "IntEnum": ("class K(enum.IntEnum):\n    N = {}", "K.N"),
    "method of an Enum": (
        "class K(enum.Enum):\n    N = 1\n    def f(self): return {}", "K.N.f()",
    ),
    "class attribute": ("class K:\n    N = {}", "K.N"),
    "inherited": ("class B:\n    N = {}\nclass K(B): pass", "K.N"),
    "static method": ("class K:\n    @staticmethod\n    def f(): return {}", "K.f()"),
    "property": ("class K:\n    @property\n    def f(self): return {}\nk = K()", "k.f"),
    "object": ("class K:\n    def __init__(self): self.N = {}\nk = K()", "k.N"),
    "slots": ("class K:\n    __slots__ = 'N',\nk = K(); k.N = {}", "k.N"),
    "callable object": ("class K:\n    def __call__(self): return {}\nk = K()", "k()"),
    "bound method": ("class K:\n    def f(self): return {}\nf = K().f", "f()"),
    "partial": ("f = functools.partial(lambda k: k, {})", "f()"),
    "default of a NamedTuple": ("class P(NamedTuple):\n    a: int = {}", "P().a"),
    "dict in a dict": ("D = dict(a=dict(b={}))", "D['a']['b']"),
    "named like NumPy's": ("@functools.wraps(np.log)\ndef f(x): return {}", "f(1)"),
    "vectorized": ("@numba.vectorize\ndef f(x): return {} * x", "f(1.0)"),
    "array of objects": ("A = np.array([{}, None], dtype=object)", "A[0]"),
    "fraction": ("A = fractions.Fraction({})", "float(A)"),
    "polynomial": ("p = np.poly1d([{}])", "p(0.0)"),
    "keyword default": ("def f(*, a={}): return a", "f()"),
    "set": ("S = frozenset(['x', {}])", "len(S)"),
}  # fmt: skip


@pytest.mark.parametrize("what", READ)
def test_what_a_law_reads_is_part_of_its_name(what: str) -> None:
    head, factor = READ[what]
    one, again, other = (
        type(law.in_kernels(material(module(head.format(v), factor)))) for v in (1, 1, 4)
    )
    assert one is again
    assert one is not other


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("k = threading.Lock()", "k"),
        ("k = np.frompyfunc(lambda x: x, 1, 1)", "k(1.0)"),
        ("k = functools.lru_cache(lambda: 1.0)", "k()"),
        ("k = []\nk.append(k)", "k"),
        ("k = numba.cfunc('f8(f8)')(lambda x: x)", "k(1.0)"),
    ],
)
def test_what_cannot_be_followed_is_refused_by_its_name(head: str, factor: str) -> None:
    with pytest.raises(InputError, match=r"law MyLaw reads factor\.k, of type ") as caught:
        law.in_kernels(material(module(head, factor)))
    assert "\n" not in str(caught.value)


def test_plain_python_runs_the_law_as_it_was() -> None:
    """A constant, an array, a list, a default, a property, a class attribute changed later."""
    names = module(
        "A = 1.0\nB = np.array([1.0])\nC = [1.0]\ndef d(x=C): return x[0]",
        "A * B[0] * C[0] * d() * m.own",
        "own = 1.0\n    @property\n    def shear(self): return A * self.mu",
    )
    mine = material(names)
    frozen = law.in_kernels(mine)
    state = (STRETCHED, STRETCHED, 1.2)

    def all_of_it() -> tuple[Any, ...]:
        return (
            law.first_piola(frozen, *state), law.stored_energy(frozen, *state),
            law.volumetric_energy(frozen, 1.2), frozen.depends_on_H, frozen.shear, frozen.own,
        )  # fmt: skip

    before = all_of_it()
    names["A"] = 2.0
    names["B"][0] = 3.0
    names["C"][0] = 5.0
    names["MyLaw"].own = 7.0
    names["MyLaw"].depends_on_H = True
    assert all_of_it() == before
    now = law.in_kernels(mine)
    assert type(now) is not type(frozen)
    assert now.shear == 2.0 * frozen.shear
    ratio = law.energy(now, IDENTITY, IDENTITY, 1.0) / law.energy(frozen, IDENTITY, IDENTITY, 1.0)
    assert ratio == pytest.approx(2.0 * 3.0 * 25.0 * 7.0)
    assert copy.deepcopy(frozen) is copy.copy(frozen) is frozen
    assert repr(frozen) == repr(mine)


def moving(solver: Any, mine: Any, **options: Any) -> Any:
    scene = Scene(
        name="stretched", body=Box(upper=(1.0, 1.0, 1.0)), material=mine, end_time=0.01,
        initial_velocity=lambda X: 30.0 * X * [1.0, -1.0, 0.0],
    )  # fmt: skip
    made = solver(scene, spacing=0.5, **options)
    made.advance(2.0e-4)
    return made


@pytest.mark.slow
@pytest.mark.parametrize(
    ("solver", "options"),
    [
        (fem.Simulation, {}),
        (sph.Simulation, {"formulation": sph.PF(), "operator": sph.Consistent()}),
    ],
)
def test_a_simulation_keeps_the_law_it_was_built_with(solver: Any, options: Any) -> None:
    names = module("A = 1.0\nB = np.array([1.0])", "A * B[0]")
    simulation = moving(solver, material(names), **options)
    before, identity = simulation.snapshot(), simulation.identity()
    names["A"], names["B"][0] = 4.0, 3.0
    branch = copy.deepcopy(simulation)
    for same in (simulation, branch):
        after = same.snapshot()
        np.testing.assert_array_equal(after.P, before.P)
        np.testing.assert_array_equal(after.pressure, before.pressure)
        assert after.strain_energy == before.strain_energy
        assert after.volumetric_energy == before.volumetric_energy
        assert same.identity() == identity
    with pytest.warns(UserWarning, match="mu in shear"):
        assert moving(solver, material(names), **options).identity()["law"] != identity["law"]


def test_a_missing_attribute_is_seen_although_the_law_was_checked() -> None:
    names = module()
    sph.check_law(material(names))
    del names["MyLaw"].depends_on_H
    with pytest.raises(InputError, match="depends_on_H must be True or False"):
        sph.check_law(material(names))
    names["MyLaw"].depends_on_H = False
    sph.check_law(material(names))


@pytest.mark.parametrize(
    ("head", "factor", "own", "words"),
    [
        ("", "m.third", "third = 1.0", "Unknown attribute 'third' of type MyLaw"),
        ("D = dict(a=1.0)", "D['a']", "", "Untyped global name 'D'"),
        ("def f(**k): return 1.0", "f(a=1)", "", "kernels cannot compile energy"),
        ("", "float(f'{m.mu:.3g}') / m.mu", "", "f-string"),
    ],
)
def test_what_numba_cannot_compile_is_one_sentence(
    head: str, factor: str, own: str, words: str
) -> None:
    mine = material(module(head, factor, own))
    sph.check_law(mine)
    with pytest.raises(InputError) as caught:
        check_first_use(mine)
    text = str(caught.value)
    assert text.startswith("law MyLaw: kernels cannot compile energy: ")
    assert words in text
    assert "\n" not in text
    assert len(text) < 400


def test_a_law_that_compiles_is_asked_once() -> None:
    frozen = check_first_use(material(module("class K(enum.Enum):\n    N = 1.0", "K.N.value")))
    assert check_first_use(frozen) is frozen
    require_compilable(frozen)
    require_compilable(sph.NeoHookean(1.0, 2.0, 3.0))


def test_a_law_that_was_used_is_the_same_law() -> None:
    names = module("@numba.vectorize\ndef f(x): return 2.0 * x", "f(1.0)")
    before = type(law.in_kernels(material(names)))
    law.energy(material(names), IDENTITY, IDENTITY, 1.0)
    assert type(law.in_kernels(material(names))) is before
