"""Intrinsic times: what they are multiples of, what a number means, when they are resolved."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import Diverged, InputError
from sphsolid.scheme.intrinsic_time import Times, Units, as_time
from tests.oracles.blocks import spinning_block

UNITS = Units(mesh=2.0e-3, step=1.0e-3)


def test_seconds() -> None:
    assert sph.OfMesh(0.5).seconds(UNITS) == 1.0e-3
    assert sph.OfStep(0.1).seconds(UNITS) == pytest.approx(1.0e-4)
    # No time of the step is needed where its share is zero.
    assert sph.OfStep(0.0).seconds(Units(mesh=1.0, step=math.nan)) == 0.0


@pytest.mark.parametrize("number", [1, 1.0, np.float64(1.0), np.int64(1)])
def test_a_number_is_one_of_the_step_whatever_its_type(number: Any) -> None:
    supg = sph.SUPG(tau_F=number, fine_scale=sph.FullHessian(tau_H=number, tau_J=number))
    assert supg.tau_F == sph.OfStep(1.0)
    assert repr(supg.tau_F) == "OfStep(c=1.0)", "a checkpoint compares it"
    assert supg.fine_scale == sph.FullHessian(tau_H=sph.OfStep(1.0), tau_J=sph.OfStep(1.0))
    assert repr(supg) == repr(sph.SUPG(tau_F=1.0, fine_scale=supg.fine_scale))


def test_every_time_takes_either_kind() -> None:
    strains = sph.StabilisedStrains(tau_H=sph.OfMesh(0.3), tau_J=0.2)
    supg = sph.SUPG(tau_F=sph.OfStep(2.0), tau_p=sph.OfMesh(0.1), fine_scale=strains)
    assert supg.seconds(UNITS) == Times(F=2.0e-3, p=2.0e-4, H=6.0e-4, J=2.0e-4)
    assert supg.follows_step
    assert supg.damps_J
    assert replace(supg, tau_F=0.5).tau_F == sph.OfStep(0.5)
    mesh = sph.SUPG(tau_F=sph.OfMesh(1.0), tau_p=0.0)
    assert not mesh.follows_step
    assert not mesh.damps_J


@pytest.mark.parametrize("kind", [sph.OfMesh, sph.OfStep])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, "1", None, True])
def test_what_is_no_time_is_refused(kind: Any, value: Any) -> None:
    with pytest.raises(InputError, match=rf"{kind.__name__}: c = .*finite and >= 0"):
        kind(value)


@pytest.mark.parametrize("value", ["dt", None, sph.OfMesh])
def test_what_is_neither_number_nor_time_is_refused(value: Any) -> None:
    with pytest.raises(InputError, match=r"SUPG: tau_p = .*OfMesh\(c\).*OfStep\(c\)"):
        sph.SUPG(tau_p=value)
    with pytest.raises(InputError, match=r"FullHessian: tau_H = "):
        sph.FullHessian(tau_H=value)


def test_no_time_at_all_is_refused_whatever_its_kind() -> None:
    with pytest.raises(InputError, match=r"NoStabilisation\(\)"):
        sph.SUPG(tau_F=sph.OfMesh(0.0), xi_F=0.0, tau_p=sph.OfMesh(0.0))


def test_terms_of_the_mesh_need_the_law_they_stabilise_too() -> None:
    with pytest.raises(InputError, match="tau_p"):
        sph.SUPG(tau_p=sph.OfMesh(0.1)).check(sph.PF())
    with pytest.raises(InputError, match="tau_H"):
        sph.SUPG(fine_scale=sph.FullHessian(tau_H=sph.OfMesh(0.1))).check(sph.PFJ())


# ------------------------------------------------------------------ in a simulation
def block(**options: Any) -> sph.Simulation:
    return sph.Simulation(spinning_block(), spacing=0.4, formulation=sph.PFJ(), **options)


def test_they_are_those_of_the_state_at_the_start_of_the_step() -> None:
    supg = sph.SUPG(tau_F=sph.OfMesh(0.5), tau_p=0.3)
    sim = block(stabilisation=supg, cfl=0.4)
    crossing = sim._time_step.crossing
    # The body starts deformed: the step is shorter than that of the undeformed one.
    assert sim.stable_time_step() < 0.9 * 0.4 * crossing
    seen = []
    for share in (1.0, 0.1, 0.7):
        allowed = sim.stable_time_step()
        sim.advance(share * allowed)
        seen.append((sim._rhs.terms[0].times.F, sim._rhs.terms[0].times.p / allowed))
    assert seen == [(pytest.approx(0.5 * crossing), pytest.approx(0.3, rel=1e-14))] * 3


def test_whoever_advances_need_not_ask_for_the_step_first() -> None:
    asked, bare, asked_twice = (block(stabilisation=sph.SUPG(tau_p=0.1)) for _ in range(3))
    dt = 0.5 * asked.stable_time_step()
    for _ in range(4):
        asked.stable_time_step()
        asked.advance(dt)
        bare.advance(dt)
        asked_twice.stable_time_step()
        asked_twice.snapshot()
        asked_twice.stable_time_step()
        asked_twice.advance(dt)
    for name, field in asked.state.items():
        for other in (bare, asked_twice):
            np.testing.assert_array_equal(getattr(other.state, name), field)


def test_a_state_that_was_changed_after_the_step_was_asked_for_is_asked_again() -> None:
    """Somebody looks, somebody else deforms the body, and then it is advanced."""
    watched, unseen = (block(stabilisation=sph.SUPG(tau_p=0.1)) for _ in range(2))
    watched.stable_time_step()
    for sim in (watched, unseen):
        sim.state.F[:] *= 0.8
        sim.state.J[:] *= 0.8**3
        sim.advance(1e-5)
    assert watched._rhs.terms[0].times == unseen._rhs.terms[0].times
    np.testing.assert_array_equal(watched.state.p, unseen.state.p)


def test_a_step_of_an_invalid_state_is_refused_before_it_is_taken() -> None:
    sim = block(stabilisation=sph.SUPG(tau_p=0.1))
    sim.state.J[3] = -1.0
    before = sim.state.p.copy()
    with pytest.raises(Diverged, match="negative Jacobian"):
        sim.advance(1e-5)
    np.testing.assert_array_equal(sim.state.p, before)


def test_the_step_is_asked_for_once_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = block(stabilisation=sph.SUPG(tau_p=0.1))
    asked = []
    right = type(sim._time_step).stable

    def counted(self: Any, *arguments: Any) -> float:
        asked.append(1)
        return right(self, *arguments)

    monkeypatch.setattr(type(sim._time_step), "stable", counted)
    sim.run(until=10.5 * sim._time_step.reference)
    # Once a step, and once at the end for a solution that is lost in the last step.
    assert len(asked) == sim.step + 1


def test_the_plan_says_their_kind_and_seconds() -> None:
    plan = block(stabilisation=sph.SUPG(tau_F=sph.OfMesh(0.5), tau_p=0.1), cfl=0.4).plan()
    crossing = block()._time_step.crossing
    assert f"tau_F 0.5 h/c_p = {0.5 * crossing:.4g} s, " in plan
    assert f"tau_p 0.1 dt = {0.04 * crossing:.4g} s undeformed" in plan
    assert "(no R_p pass)" not in plan
    plan = block(
        stabilisation=sph.SUPG(tau_p=0.0, fine_scale=sph.FullHessian(tau_J=sph.OfMesh(0.25)))
    ).plan()
    assert "tau_p 0, tau_J 0.25 h/c_p = " in plan
    assert "(no R_p pass)" in plan
    assert "tau_H" not in plan


def test_as_time_keeps_a_time() -> None:
    time = sph.OfMesh(0.5)
    assert as_time(time) is time
