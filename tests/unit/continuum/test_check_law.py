"""``check_law`` names what fails: every kind of contradiction is planted once."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.continuum import check_law as exported
from sphsolid.continuum import register_law
from sphsolid.continuum.check_law import check_first_use
from sphsolid.continuum.tensor import axpy, contract, scale
from sphsolid.continuum.wave_speed import moduli_at_rest, reference_p_wave_speed
from sphsolid.errors import InputError
from sphsolid.scenes import twisting_column
from tests.oracles import laws
from tests.oracles.laws import LAWS, LOG, MIXED, neo_hookean_with


class Base(NamedTuple):
    mu: float
    kappa: float
    density: float
    depends_on_H = False


def law_with(
    changed: dict[str, Callable[..., Any]] | None = None,
    volumetric: Any = LOG,
    mu: float = 1.0e6,
    kappa: float = 1.0e8,
) -> Any:
    """A correct law with some functions replaced; every call registers a class of its own."""
    kind = type("Planted", (Base,), {"__slots__": ()})
    register_law(kind, **(neo_hookean_with(*LOG) | (changed or {})), volumetric=volumetric)
    return kind(mu, kappa, 1000.0)


def refusal(material: Any) -> str:
    with pytest.raises(InputError) as caught:
        sph.check_law(material)
    return str(caught.value)


def test_the_laws_of_the_package_and_of_the_oracles_pass(material: Any) -> None:
    for law in (material, *LAWS, law_with()):
        sph.check_law(law)
    assert exported is sph.check_law


RIGHT = neo_hookean_with(*LOG)


def shifted_energy(m: Any, F: Any, H: Any, J: Any) -> Any:
    return RIGHT["energy"](m, F, H, J) + 1.0e-3 * m.mu * (contract(F, F) - 3.0)


def prestressed(m: Any, F: Any, H: Any, J: Any) -> Any:
    return RIGHT["energy"](m, F, H, J) + 0.1 * m.mu * (J - 1.0)


def not_objective(m: Any, F: Any, H: Any, J: Any) -> Any:
    return RIGHT["energy"](m, F, H, J) + 0.1 * m.mu * F[1] * F[1] * F[1]


def not_objective_stresses(m: Any, F: Any, H: Any, J: Any) -> Any:
    S_F, S_H, S_J = RIGHT["conjugate_stresses"](m, F, H, J)
    extra = 0.3 * m.mu * F[1] * F[1]
    return (S_F[0], S_F[1] + extra, *S_F[2:]), S_H, S_J


def not_objective_piola(m: Any, F: Any, H: Any, J: Any) -> Any:
    S_F, _, S_J = not_objective_stresses(m, F, H, J)
    return axpy(S_J, H, S_F)


def not_objective_hessian(m: Any, F: Any, H: Any, J: Any, dF: Any, dH: Any, dJ: Any) -> Any:
    S_F, S_H, S_J = RIGHT["hessian_action"](m, F, H, J, dF, dH, dJ)
    extra = 0.6 * m.mu * F[1] * dF[1]
    return (S_F[0], S_F[1] + extra, *S_F[2:]), S_H, S_J


def wrong_sign(m: Any, F: Any, H: Any, J: Any) -> Any:
    return scale(-1.0, RIGHT["first_piola"](m, F, H, J))


def no_coupling(m: Any, F: Any, H: Any, J: Any, dF: Any, dH: Any, dJ: Any) -> Any:
    S_F, S_H, S_J = RIGHT["hessian_action"](m, F, H, J, dF, dH, 0.0 * dJ)
    return S_F, S_H, S_J


def numbers_only(m: Any, F: Any, H: Any, J: Any) -> Any:
    return RIGHT["energy"](m, F, H, J) + 0.0 * math.log(J)


def scalar_branch(m: Any, F: Any, H: Any, J: Any) -> Any:
    return RIGHT["energy"](m, F, H, J) * (1.0 if np.max(J) < 1.2 else 2.0)


@pytest.mark.parametrize(
    ("changed", "volumetric", "words"),
    [
        ({"energy": shifted_energy}, LOG, ("dW/dF11", "derivative of energy")),
        ({"energy": prestressed}, LOG, ("dW/dJ", "derivative of energy")),
        ({"first_piola": wrong_sign}, LOG, ("first_piola", "Sigma_H x F")),
        ({"hessian_action": no_coupling}, LOG, ("hessian_action along J",)),
        ({"energy": numbers_only}, LOG, ("energy fails for arrays", "np.log")),
        ({"energy": scalar_branch}, LOG, ("energy of an array",)),
        (
            {
                "energy": not_objective, "conjugate_stresses": not_objective_stresses,
                "first_piola": not_objective_piola, "hessian_action": not_objective_hessian,
            },
            LOG, ("W(QF, QH, J)",),
        ),
        ({}, MIXED, ("U, the first of `volumetric`", "J = 0.7")),
        ({}, (LOG[0], MIXED[1], LOG[2]), ("U', the second of `volumetric`",)),
        ({}, (LOG[0], LOG[1], MIXED[2]), ("U'', the third of `volumetric`",)),
        ({}, (lambda m, J: LOG[0](m, J) + 1.0e6, *LOG[1:]), ("U, the first",)),
    ],
)  # fmt: skip
def test_what_fails_is_named_with_place_and_size(
    changed: Any, volumetric: Any, words: tuple[str, ...]
) -> None:
    text = refusal(law_with(changed, volumetric))
    assert text.startswith("law Planted: ")
    for word in words:
        assert word in text
    assert "docs/laws.md" in text or "np.log" in text


def test_a_stress_at_rest_is_refused() -> None:
    def stresses(m: Any, F: Any, H: Any, J: Any) -> Any:
        S_F, S_H, S_J = RIGHT["conjugate_stresses"](m, F, H, J)
        return S_F, S_H, S_J + 0.1 * m.mu

    def piola(m: Any, F: Any, H: Any, J: Any) -> Any:
        return axpy(0.1 * m.mu, H, RIGHT["first_piola"](m, F, H, J))

    text = refusal(
        law_with({"energy": prestressed, "conjugate_stresses": stresses, "first_piola": piola})
    )
    assert "undeformed state" in text
    assert "no stress" in text


class Moduli(NamedTuple):
    """Its energy has the moduli ``a`` and ``b``; what it says of them may be wrong."""

    a: float
    b: float
    mu: float
    kappa: float
    density: float
    depends_on_H = False


def _with_moduli_ab(which: str) -> Callable[..., Any]:
    right = RIGHT[which]

    def function(m: Any, *rest: Any) -> Any:
        return right(Base(m.a, m.b, m.density), *rest)

    return function


register_law(Moduli, **{which: _with_moduli_ab(which) for which in RIGHT})


def test_moduli_that_are_not_those_of_the_energy() -> None:
    sph.check_law(Moduli(1.0e6, 1.0e8, 1.0e6, 1.0e8, 1000.0))
    assert "U''(1)" in refusal(Moduli(1.0e6, 1.0e8, 1.0e6, 1.1e8, 1000.0))
    assert "mu in shear" in refusal(Moduli(1.0e6, 1.0e8, 1.1e6, 1.0e8, 1000.0))


def test_a_solver_asks_such_a_law_for_its_wave_speed_and_warns() -> None:
    right, wrong = (Moduli(1.0e6, 1.0e7, mu, kappa, 1000.0) for mu, kappa in
                    ((1.0e6, 1.0e7), (4.0e6, 2.0e6)))  # fmt: skip
    speed = math.sqrt((1.0e7 + 4.0 / 3.0 * 1.0e6) / 1000.0)
    for law in (right, wrong):
        assert reference_p_wave_speed(law) == pytest.approx(speed, rel=1e-12)
        assert moduli_at_rest(law) == pytest.approx((1.0e6, 1.0e7), rel=1e-12)
    assert moduli_at_rest(right) == (1.0e6, 1.0e7)
    with pytest.warns(UserWarning, match="kappa is 2e"):
        check_first_use(wrong)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_first_use(right)


@pytest.mark.parametrize(
    ("values", "word"),
    [((0.0, 1.0, 1.0), "mu"), ((1.0, math.inf, 1.0), "kappa"), ((1.0, 1.0, None), "density")],
)
def test_bad_parameters_are_named(values: Any, word: str) -> None:
    assert f"{word} = " in refusal(type(LAWS[0])(*values))


class NeverRegistered(NamedTuple):
    mu: float = 1.0
    kappa: float = 1.0
    density: float = 1.0


@pytest.mark.parametrize(
    "material", [NeverRegistered(), None, 3.0, {"mu": 1.0}, sph.NeoHookean, NeverRegistered]
)
def test_what_is_no_law_gets_one_sentence_from_the_scene(material: Any) -> None:
    scene = twisting_column(poisson_ratio=0.3)
    with pytest.raises(InputError) as caught:
        replace(scene, material=material)
    text = str(caught.value)
    assert "material = " in text
    assert "\n" not in text
    assert refusal(material)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_both_solvers_check_a_law_before_anything_else(solver: Any) -> None:
    scene = replace(
        twisting_column(poisson_ratio=0.3), material=law_with({"first_piola": wrong_sign})
    )
    with pytest.raises(InputError, match="first_piola"):
        solver(scene, spacing=0.5)


def test_the_answer_is_remembered_until_the_law_changes() -> None:
    calls = []

    def counting(m: Any, F: Any, H: Any, J: Any) -> Any:
        calls.append(1)
        return RIGHT["energy"](m, F, H, J)

    material = law_with({"energy": counting})
    sph.check_law(material)
    first = len(calls)
    assert first > 0
    assert laws.LAWS[0] != material
    register_law(type(material), **(RIGHT | {"first_piola": wrong_sign}), volumetric=LOG)
    assert "first_piola" in refusal(material)
    assert "first_piola" in refusal(material)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"volumetric": LOG[:2]}, "three functions"),
        ({"volumetric": LOG[0]}, "three functions"),
        ({"energy": 3.0}, "energy = 3.0"),
    ],
)
def test_a_registration_that_cannot_work_is_refused(arguments: Any, word: str) -> None:
    with pytest.raises(InputError, match=word):
        register_law(Base, **(RIGHT | arguments))
    with pytest.raises(InputError, match="NamedTuple"):
        register_law(dict, **RIGHT)
