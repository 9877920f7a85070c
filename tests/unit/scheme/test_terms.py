"""A term of one's own: its field, its step limit, its place in checkpoints and snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import h5py
import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import EnergyBudget, RunFolder, write_checkpoint
from sphsolid.record.stored import frame_files, read_frame
from sphsolid.scheme import Field, SetUp, Stage, State, Term, TermOption
from sphsolid.scheme.time_step import STRETCH
from tests.oracles.blocks import spinning_block

RATE, START, LIMIT = 40.0, 293.0, 1.0e-6


class Warming(Term):
    """``dT/dt = RATE`` everywhere."""

    def start(self, state: State) -> None:
        state["temperature"][:] = START

    def add_rates(self, stage: Stage) -> None:
        stage.rates["temperature"] += RATE

    def largest_step(self, state: State) -> float:
        return LIMIT


@dataclass(frozen=True)
class Heat(TermOption):
    """Declares one more field."""

    name: str = "heat"
    fields: ClassVar[tuple[Field, ...]] = (Field("temperature"),)

    def terms(self, set_up: SetUp) -> tuple[Term, ...]:
        return (Warming(),)


def heated(**options: Any) -> sph.Simulation:
    return sph.Simulation(
        spinning_block(), spacing=0.4, formulation=sph.Displacement(),
        stabilisation=sph.NoStabilisation(), terms=[Heat()], **options,
    )  # fmt: skip


@pytest.mark.parametrize(
    "integrator",
    [sph.PositionVerlet(), sph.SymplecticRKN4(), sph.TVDRK2(), sph.SSPRK3()],
    ids=lambda i: i.name,
)
def test_every_integrator_advances_a_field_that_a_term_declares(integrator: Any) -> None:
    sim = heated(integrator=integrator)
    assert set(sim.state) - {STRETCH} == {"p", "x", "F", "temperature"}
    for _ in range(4):
        sim.advance(1.0e-3)
    shot = sim.snapshot().field("temperature")
    np.testing.assert_allclose(shot.values, START + RATE * 4.0e-3, rtol=1e-14)
    assert ", temperature" in sim.plan()
    assert "-heat-" in sim.name


def test_rates_of_an_evaluation_do_not_reach_the_next() -> None:
    """Forces are asked for at set-up too: what terms added there is gone."""
    for options in ({}, {"stabilisation": sph.Restraint()}):
        sim = sph.Simulation(spinning_block(), spacing=0.4, terms=[Heat(), Cold()], **options)
        for _ in range(3):
            sim.advance(1.0e-3)
        warmed = sim.state["temperature"] - START
        np.testing.assert_allclose(warmed, 3.0e-3 * (RATE - 1.0), rtol=1e-9)


class Cooling(Term):
    """``dT/dt - 1``, and a force that is there at rest."""

    def add_rates(self, stage: Stage) -> None:
        stage.rates["temperature"] -= 1.0
        stage.rates.p[:, 2] -= 1.0e7


@dataclass(frozen=True)
class Cold(TermOption):
    """Has no field of its own."""

    name: str = "cold"

    def terms(self, set_up: SetUp) -> tuple[Term, ...]:
        return (Cooling(),)


def test_a_force_at_rest_does_not_change_the_step() -> None:
    bare, loaded = (
        sph.Simulation(spinning_block(), spacing=0.4, terms=terms)
        for terms in ([Still()], [Still(), Cold()])
    )
    assert loaded.stable_time_step() == pytest.approx(bare.stable_time_step(), rel=1e-6)


@dataclass(frozen=True)
class Still(TermOption):
    """A field that nothing changes, and no limit."""

    name: str = "still"
    fields: ClassVar[tuple[Field, ...]] = (Field("temperature"),)

    def terms(self, set_up: SetUp) -> tuple[Term, ...]:
        return ()


def test_frames_and_pictures_have_it(tmp_path: Path) -> None:
    sim = heated()
    sim.run(until=2.0e-6, every=1.0e-6, output=RunFolder(tmp_path / "run"))
    frame = read_frame(frame_files(tmp_path / "run")[-1][1])
    wanted = sim.snapshot().field("temperature").values
    np.testing.assert_allclose(frame.field("temperature").values, wanted, rtol=1e-6)
    assert list(frame.further) == ["temperature"]
    with h5py.File(tmp_path / "run" / "run.vtkhdf") as file:
        stored = file["VTKHDF/PointData/temperature"][...].reshape(3, -1)
    np.testing.assert_allclose(stored[-1], wanted, rtol=1e-6)
    for shot in (sim.snapshot(), frame):
        assert shot.picture("temperature") is not None
        with pytest.raises(InputError, match=r"no picture of .*'temprature'.*'temperature'"):
            shot.picture("temprature")


def test_a_checkpoint_keeps_it(tmp_path: Path) -> None:
    sim, other = heated(), heated()
    sim.advance(1.0e-3)
    write_checkpoint(sim, tmp_path / "state.npz")
    other.restore(tmp_path / "state.npz")
    np.testing.assert_array_equal(other.state["temperature"], sim.state["temperature"])
    bare = sph.Simulation(
        spinning_block(), spacing=0.4, formulation=sph.Displacement(),
        stabilisation=sph.NoStabilisation(),
    )  # fmt: skip
    with pytest.raises(InputError, match="terms"):
        bare.restore(tmp_path / "state.npz")


def test_a_term_limits_the_step() -> None:
    assert heated().stable_time_step() == LIMIT


def test_what_is_no_term_is_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="a member of terms = 3 cannot be used: it has no name"):
        sph.Simulation(spinning_block(), spacing=0.4, terms=[3])  # type: ignore[list-item]
    with pytest.raises(InputError, match=r"terms = .* is no list"):
        sph.Simulation(spinning_block(), spacing=0.4, terms=Heat())  # type: ignore[arg-type]
    with pytest.raises(InputError, match="two fields have one name"):
        sph.Simulation(spinning_block(), spacing=0.4, terms=[Heat(), Heat()])


class Wrong(Term):
    """Returns what it is told to."""

    def __init__(self, step: Any, powers: Any) -> None:
        self._step, self._powers, self.works = step, powers, ("heating",)

    def largest_step(self, state: State) -> Any:
        return self._step

    def powers(self, stage: Stage) -> Any:
        return self._powers


@dataclass(frozen=True)
class Mistaken(TermOption):
    """A term that returns something else."""

    step: Any = 1.0
    powers: Any = (0.0,)
    lone: bool = False
    name: Any = "mistaken"

    def terms(self, set_up: SetUp) -> Any:
        term = Wrong(self.step, self.powers)
        return term if self.lone else (term,)


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan"), None, "1e-3"])
def test_a_step_that_is_none_is_refused(step: Any) -> None:
    sim = sph.Simulation(spinning_block(), spacing=0.4, terms=[Mistaken(step=step)])
    with pytest.raises(InputError, match=r"Wrong\.largest_step returned .*; wanted is a time"):
        sim.run(until=1.0e-3)
    assert sim.step == 0


def test_other_things_that_a_term_returns_are_refused() -> None:
    def made(**options: Any) -> sph.Simulation:
        return sph.Simulation(spinning_block(), spacing=0.4, terms=[Mistaken(**options)])

    with pytest.raises(InputError, match=r"mistaken: terms\(\) returned .*; wanted is a tuple"):
        made(lone=True)
    with pytest.raises(InputError, match="its name None is no text"):
        made(name=None)
    with pytest.raises(InputError, match=r"Wrong\.powers returned 2 numbers; its works are"):
        made(powers=(1.0, 2.0)).run(until=1.0e-4, record=[EnergyBudget()])


def test_a_field_of_another_kind_is_refused() -> None:
    with pytest.raises(InputError, match="kind = 'skalar' is not one of scalar, vector, tensor"):
        Field("T", "skalar")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="name = 'my field' must be a word"):
        Field("my field")


def test_a_state_hands_out_the_arrays_themselves() -> None:
    state = State.zeros(sph.PFJ().fields, 5, particle_major=False)
    assert list(state) == ["p", "x", "F", "J"]
    held = state.J
    state.J = np.ones(5)
    state.F += 2.0
    assert held is state["J"]
    np.testing.assert_array_equal(held, 1.0)
    assert len(state.H) == 0
    assert state.but(J=np.zeros(5)).p is state.p
