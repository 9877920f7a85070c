"""Options of ``run`` that are something else, in one sentence each, before any step."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.record import (
    AngularMomentum,
    Energy,
    EnergyBudget,
    LinearMomentum,
    MomentumDrift,
    NoOutput,
    Probe,
    ProgressLine,
    RunFolder,
    march,
    read_run,
)
from sphsolid.scenes import Box, Scene, twisting_column

WRONG = [
    ({"record": Energy()}, r"record = Energy\(\) is one recorder; .*record=\[Energy\(\)\]"),
    ({"record": Energy}, r"record=\[Energy\(\)\]"),
    ({"record": Probe("tip")}, r"Probe\(point='tip'\) is one recorder"),
    ({"record": [Energy]}, r"the class Energy; write Energy\(\)"),
    ({"record": "energy"}, "'energy' is no list of recorders"),
    ({"record": None}, "None is no list"),
    ({"record": ["tip"]}, "'tip', which is no recorder"),
    ({"output": "out/run"}, r"'out/run' is a path; use RunFolder\('out/run'\)"),
    ({"output": Path("out")}, r"use RunFolder\('out'\)"),
    ({"output": NoOutput}, "is not an option object"),
    ({"output": None}, "is not an option object"),
    ({"progress": True}, r"progress = True is no object to be called; use ProgressLine\(\)"),
    ({"progress": ProgressLine}, "is no object to be called"),
    ({"progress": lambda: 0}, "is called with one Progress"),
    ({"until": "0.1"}, "until = '0.1' is not a number"),
    ({"until": True}, "until = True is not a number"),
    ({"until": np.nan}, "until = nan s must be finite"),
    ({"until": (0.1,)}, "not a number"),
    ({"every": "1e-3"}, "every = '1e-3' is not a number"),
]


@pytest.mark.parametrize(("options", "named"), WRONG)
def test_a_wrong_option_is_named(fake_solver, options, named):
    solver = fake_solver()
    with pytest.raises(InputError, match=named):
        march(solver, **{"until": 0.1, **options})
    assert solver.step == 0


def test_numbers_of_numpy_and_any_iterable_are_fine(fake_solver):
    record = (each for each in (Energy(),))
    history = march(fake_solver(), until=np.float32(0.5), every=np.float64(0.25), record=record)
    assert len(history.table) == 3


def test_recorders_that_need_it_get_a_budget(fake_solver):
    solver = fake_solver()
    with pytest.raises(InputError, match="needs the budget"):
        march(solver, until=0.1, record=[EnergyBudget()])
    assert solver.tracks


@pytest.mark.parametrize(
    ("until", "every"),
    [(np.float32(0.5), 0.25), (Fraction(1, 2), Fraction(1, 4)), (np.int64(1), np.float32(0.5))],
)
def test_numbers_of_any_type_can_be_written_down(fake_solver, tmp_path, until, every):
    history = march(fake_solver(), until=until, every=every, output=RunFolder(tmp_path / "run"))
    assert history["time [s]"][-1] == float(until)
    assert read_run(tmp_path / "run")["until_s"] == float(until)


class Says:
    """A recorder that says whatever it was told to."""

    def __init__(self, said):
        self.said = said

    def __repr__(self):
        return "Says()"

    def record(self, snapshot, scene):
        return self.said


@pytest.mark.parametrize(
    ("said", "named"),
    [
        (np.zeros(3), r"Says\(\) returned an array of shape \(3,\); wanted is a dict"),
        (None, r"Says\(\) returned None"),
        ("mass", r"Says\(\) returned 'mass'"),
        (1.0, r"Says\(\) returned 1.0"),
        ({1: 2.0}, r"Says\(\) returned \{1: 2.0\}"),
        ({"a": np.zeros(2)}, r"returned an array of shape \(2,\) for its column 'a'"),
        ({"a": "1"}, "returned '1' for its column 'a'; wanted is one number"),
        ({"a": None}, "returned None for its column 'a'"),
        ({"time [s]": 0.0}, r"has a column 'time \[s\]', which every row has"),
        ({"step": 0}, "has a column 'step'"),
    ],
)
def test_a_recorder_that_says_no_numbers_is_named(fake_solver, tmp_path, said, named):
    solver = fake_solver()
    with pytest.raises(InputError, match=named):
        march(solver, until=0.1, record=[Says(said)], output=RunFolder(tmp_path / "run"))
    assert solver.step == 0
    assert not (tmp_path / "run").exists()


def test_a_recorder_may_say_numbers_of_any_type(fake_solver):
    said = {"a": np.float32(0.5), "b": np.array(2), "c": True, "d": 3}
    table = march(fake_solver(), until=0.1, record=[Says(said)]).table
    assert table[["a", "b", "c", "d"]].iloc[-1].tolist() == [0.5, 2.0, 1.0, 3.0]


def test_a_recorder_cannot_change_what_the_next_one_sees(fake_solver):
    class Vandal:
        def record(self, snapshot, scene):
            snapshot.velocity[:] = 0.0
            return {}

    with pytest.raises(ValueError, match="read-only"):
        march(fake_solver(), until=0.1, record=[Vandal(), Energy()])


class Constant:
    """A recorder with one column."""

    def __init__(self, value):
        self.value = value

    def record(self, snapshot, scene):
        return {"a [m]": self.value}


def test_two_recorders_may_share_a_column_if_they_agree_on_it(fake_solver):
    table = march(fake_solver(), until=0.1, record=[Constant(1.0), Constant(1.0)]).table
    assert list(table.columns) == ["time [s]", "step", "a [m]"]
    with pytest.raises(InputError, match=r"a column 'a \[m\]', as a recorder before it"):
        march(fake_solver(), until=0.1, record=[Constant(1.0), Constant(2.0)])


@pytest.mark.parametrize("solver", [sph, fem])
def test_recorders_of_one_momentum_say_it_in_the_same_bits(solver):
    sim = solver.Simulation(twisting_column(end_time=0.002), spacing=0.5)
    # A column that differs in one bit is refused.
    table = sim.run(record=[MomentumDrift(), LinearMomentum(), AngularMomentum()]).table
    assert table["linear_momentum_x [kg m/s]"].notna().all()
    assert table["angular_momentum_y [kg m^2/s]"].iloc[-1] != 0.0


def test_rows_before_a_load_that_fails_are_kept():
    def fails(X, t):
        return np.full_like(X, np.nan if t > 1e-3 else 1.0)

    law = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)
    sim = fem.Simulation(
        Scene("s", Box(), law, 2e-3, body_force=fails), spacing=0.5
    )
    with pytest.raises(InputError, match=r"body force at t = .* is not finite"):
        sim.run(every=2e-4, record=[Energy()])
    assert len(sim.history.table) >= 4
