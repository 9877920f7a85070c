"""A term of one's own: its field, its step limit, its place in checkpoints and snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import write_checkpoint
from sphsolid.scheme import Field, SetUp, Stage, State, Term, TermOption
from sphsolid.scheme.time_step import STRETCH
from tests.oracles.blocks import spinning_block

RATE, START, LIMIT = 40.0, 293.0, 1.0e-6


class Warming(Term):
    """``dT/dt = RATE`` everywhere."""

    def start(self, state: State) -> None:
        state["temperature"][:] = START

    def add_rates(self, stage: Stage) -> None:
        stage.rates["temperature"][:] = RATE

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
