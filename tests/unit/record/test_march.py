"""The loop over time: records on time, even steps, histories that survive a lost solution."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from sphsolid.errors import Diverged, InputError
from sphsolid.record import Errors, Probe, RunFolder, march
from sphsolid.scenes import swinging_cube


@dataclasses.dataclass(frozen=True)
class Speed:
    def record(self, snapshot, scene):
        return {"speed [m/s]": float(snapshot.velocity[0, 0])}


def test_records_fall_exactly_on_their_times(fake_solver):
    solver = fake_solver()
    history = march(solver, until=1.0, every=0.1, record=[Speed()])
    # Bitwise: a record names the instant that was asked for, not the sum of the steps.
    np.testing.assert_array_equal(history["time [s]"], [*(k * 0.1 for k in range(10)), 1.0])
    np.testing.assert_allclose(history["speed [m/s]"], history["time [s]"], rtol=1e-13)
    assert solver.time == 1.0
    assert solver.step == 40
    np.testing.assert_allclose(solver.steps, 0.025, rtol=1e-12)
    np.testing.assert_array_equal(history["step"], 4 * np.arange(11))


def test_steps_never_exceed_the_stable_one(fake_solver):
    solver = fake_solver(dt=lambda t: 0.03 / (1.0 + 4.0 * t))
    march(solver, until=1.0, every=0.25)
    start = np.concatenate([[0.0], np.cumsum(solver.steps)[:-1]])
    assert np.all(np.array(solver.steps) <= 0.03 / (1.0 + 4.0 * start) * (1.0 + 1e-6))
    assert sum(solver.steps) == pytest.approx(1.0, rel=1e-13)


def test_a_gap_that_is_a_whole_number_of_steps_gets_no_sliver(fake_solver):
    solver = fake_solver(dt=lambda t: 0.1)
    march(solver, until=1.0)
    assert solver.step == 10


def test_last_gap_may_be_shorter(fake_solver):
    history = march(fake_solver(), until=0.25, every=0.1, record=[Speed()])
    np.testing.assert_array_equal(history["time [s]"], [0.0, 0.1, 0.2, 0.25])


def test_defaults_are_the_scene_and_its_ends(fake_solver):
    solver = fake_solver(dt=lambda t: 1e-3)
    history = march(solver, record=[Speed()])
    np.testing.assert_array_equal(history["time [s]"], [0.0, solver.scene.end_time])


def test_a_run_goes_on_where_it_stopped(fake_solver):
    solver = fake_solver()
    first = march(solver, until=0.2, every=0.1, record=[Speed()])
    second = march(solver, until=0.4, every=0.1, record=[Speed()])
    times = np.concatenate([first["time [s]"], second["time [s]"]])
    np.testing.assert_allclose(times, [0.0, 0.1, 0.2, 0.3, 0.4], rtol=1e-15)
    assert np.all(np.diff(times) > 0.0), "the instant of the restart is not recorded twice"


def test_records_fall_on_multiples_wherever_a_run_goes_on(fake_solver):
    """The instants do not depend on where a run was cut: bitwise the same after a restart."""
    solver = fake_solver()
    march(solver, until=0.25)
    rest = march(solver, until=1.0, every=0.1, record=[Speed()])
    np.testing.assert_array_equal(rest["time [s]"], [*(k * 0.1 for k in range(3, 10)), 1.0])


def test_two_calls_give_the_bits_of_one(fake_solver):
    solver, other = fake_solver(), fake_solver()
    cut = 7 * 0.1
    march(solver, until=cut, every=0.1)
    march(solver, until=1.0, every=0.1)
    march(other, until=1.0, every=0.1)
    assert solver.steps == other.steps
    assert solver.x.tobytes() == other.x.tobytes()


def test_no_recorder_no_rows_and_no_snapshot(fake_solver):
    solver = fake_solver()
    solver.snapshot = lambda: pytest.fail("a snapshot nobody wants")
    assert len(march(solver, until=0.1).table) == 0


class Fickle:
    """Names its column by what it sees."""

    def __init__(self, *names):
        self.names = list(names)

    def record(self, snapshot, scene):
        return dict.fromkeys(self.names.pop(0), 1.0)


@pytest.mark.parametrize("has_folder", [True, False])
@pytest.mark.parametrize(
    "names",
    [(["a"], ["b"], ["b"]), (["a"], ["a", "b"]), (["a", "b"], ["b"]), (["a", "b"], ["b", "a"])],
)
def test_columns_that_change_are_refused_with_and_without_a_folder(
    fake_solver, tmp_path, names, has_folder
):
    output = {"output": RunFolder(tmp_path / "run")} if has_folder else {}
    with pytest.raises(InputError, match="other columns than the history before it") as refused:
        march(fake_solver(), until=0.2, every=0.1, record=[Fickle(*names)], **output)
    table = refused.value.history.table
    assert list(table) == ["time [s]", "step", *names[0]]
    assert not table.isna().to_numpy().any()


def test_progress_is_told_at_every_record(fake_solver):
    told = []
    march(fake_solver(), until=0.3, every=0.1, progress=told.append)
    assert [p.time for p in told] == [0.1, 0.2, 0.3]
    assert [p.step for p in told] == [4, 8, 12]
    assert {p.until for p in told} == {0.3}
    assert told[0].dt == pytest.approx(0.025)


def test_a_lost_solution_keeps_its_history(fake_solver):
    with pytest.raises(Diverged, match="step 12") as lost:
        march(fake_solver(fails_at=0.3), until=1.0, every=0.1, record=[Speed()])
    np.testing.assert_allclose(lost.value.history["time [s]"], [0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("times", "named"),
    [
        ({"until": 0.0}, "until"),
        ({"until": -1.0}, "until"),
        ({"until": np.nan}, "until"),
        ({"until": 1.0, "every": 0.0}, "every"),
        ({"until": 1.0, "every": np.inf}, "every"),
    ],
)
def test_bad_times_are_refused(fake_solver, times, named):
    solver = fake_solver()
    with pytest.raises(InputError, match=named):
        march(solver, **times)
    assert solver.step == 0


def test_bad_recorders_are_refused_before_any_step(fake_solver):
    solver = fake_solver()
    with pytest.raises(InputError, match=r"'tip'.*'corner'"):
        march(solver, until=1.0, every=0.1, record=[Probe("tip")])
    free = dataclasses.replace(swinging_cube(), constraints=())
    with pytest.raises(InputError, match="no constraints"):
        march(fake_solver(scene=free), until=1.0, record=[Errors()])
    assert solver.step == 0


def test_history_survives_csv(fake_solver, tmp_path):
    history = march(fake_solver(), until=1.0 / 3.0, every=0.1, record=[Speed()])
    history.to_csv(tmp_path / "h.csv")
    # Texts parsed by Python's own exact rule, so that only the file is on trial.
    back = pd.read_csv(tmp_path / "h.csv", dtype=str)
    for column in history.table:
        np.testing.assert_array_equal([float(text) for text in back[column]], history[column])
