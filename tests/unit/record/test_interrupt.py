"""Ctrl-C acts between steps; a second one acts at once; the handler is put back."""

from __future__ import annotations

import signal
import threading

import numpy as np
import pytest

from sphsolid.record import march
from sphsolid.record.interrupt import held_interrupt


@pytest.fixture(autouse=True)
def _python_handler():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    signal.signal(signal.SIGINT, before)


class Pressing:
    """Presses Ctrl-C in the middle of step ``at``, ``times`` times."""

    def __init__(self, solver, at, times=1):
        self._advance, self._at, self._times = solver.advance, at, times
        self._solver = solver
        solver.advance = self

    def __call__(self, dt):
        if self._solver.step == self._at:
            for _ in range(self._times):
                signal.raise_signal(signal.SIGINT)
        self._advance(dt)


class Speed:
    def __init__(self, press_at=-1):
        self._press_at = press_at

    def record(self, snapshot, scene):
        if snapshot.step == self._press_at:
            signal.raise_signal(signal.SIGINT)
        return {"speed [m/s]": float(snapshot.velocity[0, 0])}


def test_the_step_is_completed_first(fake_solver):
    solver = fake_solver()
    Pressing(solver, at=5)
    with pytest.raises(KeyboardInterrupt) as stopped:
        march(solver, until=1.0, every=0.1, record=[Speed()])
    assert solver.step == 6
    assert solver.time == pytest.approx(0.15)
    np.testing.assert_array_equal(stopped.value.history["time [s]"], [0.0, 0.1])


@pytest.mark.parametrize("where", ["the last step before a record", "the record itself"])
def test_a_record_is_completed_first(fake_solver, where):
    solver = fake_solver()
    if "step" in where:
        Pressing(solver, at=7)
    with pytest.raises(KeyboardInterrupt) as stopped:
        march(solver, until=1.0, every=0.1, record=[Speed(8 if "itself" in where else -1)])
    assert (solver.step, solver.time) == (8, 0.2)
    np.testing.assert_array_equal(stopped.value.history["time [s]"], [0.0, 0.1, 0.2])


def test_the_run_can_go_on_and_gives_the_same(fake_solver):
    solver, other = fake_solver(), fake_solver()
    Pressing(solver, at=5)
    with pytest.raises(KeyboardInterrupt) as stopped:
        march(solver, until=1.0, every=0.1, record=[Speed()])
    rest = march(solver, until=1.0, every=0.1, record=[Speed()])
    whole = march(other, until=1.0, every=0.1, record=[Speed()])
    joined = np.concatenate([stopped.value.history.table.to_numpy(), rest.table.to_numpy()])
    assert joined.tobytes() == whole.table.to_numpy().tobytes()
    assert solver.x.tobytes() == other.x.tobytes()


def test_a_second_press_does_not_wait(fake_solver):
    solver = fake_solver()
    Pressing(solver, at=5, times=2)
    with pytest.raises(KeyboardInterrupt):
        march(solver, until=1.0)
    assert solver.step == 5


def test_another_handler_is_left_alone(fake_solver):
    pressed = []
    own = lambda *_: pressed.append(1)  # noqa: E731
    signal.signal(signal.SIGINT, own)
    solver = fake_solver()
    Pressing(solver, at=2)
    march(solver, until=0.3)
    assert pressed == [1]
    assert signal.getsignal(signal.SIGINT) is own
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_another_thread_runs_without_handlers(fake_solver):
    solver = fake_solver()
    thread = threading.Thread(target=march, args=(solver,), kwargs={"until": 0.3})
    thread.start()
    thread.join()
    assert solver.time == 0.3


def test_a_press_that_nobody_checked_is_not_lost():
    with pytest.raises(KeyboardInterrupt), held_interrupt():
        signal.raise_signal(signal.SIGINT)
