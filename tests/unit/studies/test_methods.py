"""The registry of methods."""

from __future__ import annotations

import pytest

import sphsolid as sph
from sphsolid.scenes import swinging_cube
from studies.methods import LATTICE, METHODS, PACKAGE, SUPG, Times

SCENE = swinging_cube(poisson_ratio=0.3)


def test_names_and_looks_are_one_each() -> None:
    assert list(METHODS) == [method.name for method in METHODS.values()]
    looks = [(each.colour, each.marker, each.line) for each in METHODS.values()]
    assert len(set(looks)) == len(looks)


def test_the_default_is_what_a_user_gets() -> None:
    made, own = PACKAGE.simulation(SCENE, spacing=0.25), sph.Simulation(SCENE, spacing=0.25)
    assert made.plan().splitlines()[1:] == own.plan().splitlines()[1:]


@pytest.mark.parametrize("method", METHODS.values(), ids=lambda method: method.name)
def test_an_option_that_is_none_is_refused_by_name(method) -> None:
    with pytest.raises(sph.InputError, match=r"clf is no option of a method.*cfl"):
        method.but(clf=0.5)


@pytest.mark.parametrize("method", [PACKAGE, LATTICE[4]], ids=lambda method: method.name)
def test_what_has_no_supg_has_no_times_to_change(method) -> None:
    with pytest.raises(sph.InputError, match=r"tau_p belong to sphsolid\.SUPG"):
        method.but(tau_p=0.0)


def test_supg_may_be_changed_where_it_is() -> None:
    assert SUPG.but(tau_p=0.0).simulation(SCENE, spacing=0.25).stabilisation.tau_p.c == 0.0
    mixed = PACKAGE.but(formulation=sph.PF(), tau_F=Times(2.0))
    usual = PACKAGE.but(formulation=sph.PF()).simulation(SCENE, spacing=0.25)
    doubled = mixed.simulation(SCENE, spacing=0.25).stabilisation.tau_F.c
    assert doubled == 2.0 * usual.stabilisation.tau_F.c
    assert mixed.name == "package default, {p,F}, tau_F x 2"
