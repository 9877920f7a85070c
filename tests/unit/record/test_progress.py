"""Progress against a clock that is set by hand."""

from __future__ import annotations

import io
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from sphsolid.errors import Diverged
from sphsolid.record import Progress, ProgressLine, march
from sphsolid.record.display import Display, duration
from sphsolid.record.progress import TICK, Pace, state
from sphsolid.scenes import Constraint, NoBodyForce, Traction, swinging_cube


class Clock:
    """Advances only when told to."""

    def __init__(self):
        self.seconds = 100.0

    def __call__(self):
        return self.seconds


def paced(step_seconds, *, first=None, steps=10, until=1.0):
    """What a run of equal steps reports when each takes ``step_seconds`` of wall time."""
    told, clock = [], Clock()
    pace = Pace(told.append, start=0.0, until=until, now=clock)
    for k in range(1, steps + 1):
        clock.seconds += first if first is not None and k == 1 else step_seconds
        pace.stepped(until * k / steps, k, until / steps)
    return told, pace


def test_reports_are_half_a_second_apart_whatever_a_step_takes():
    told, _ = paced(0.125, steps=64)
    assert len(told) == 16
    assert [p.step for p in told] == list(range(4, 65, 4))
    assert TICK == 0.5
    # Steps that are longer than that are all reported.
    assert len(paced(2.0, steps=5)[0]) == 5


def test_speed_and_time_left_leave_out_the_first_step():
    told, _ = paced(1.0, first=60.0, steps=10)
    assert math.isnan(told[0].eta)
    assert math.isnan(told[0].steps_per_second)
    for k, p in enumerate(told[1:], start=2):
        assert p.steps_per_second == pytest.approx(1.0)
        assert p.eta == pytest.approx(10.0 - k)
        assert p.wall == 60.0 + k - 1
        assert p.percent == pytest.approx(10.0 * k)


DRIVEN = {
    "traction": {"tractions": (Traction("X+", lambda X, N, t: 0.0 * X),)},
    "body force": {"body_force": lambda X, t: 0.0 * X},
    "motion": {"constraints": (Constraint("X+", "all", lambda X, t: 0.0 * X),)},
}


@pytest.mark.parametrize("what", DRIVEN)
def test_energy_of_a_driven_body_is_said_and_not_compared(what, fake_solver):
    """What a load puts in is no change of what there was."""
    free = replace(swinging_cube(), body_force=NoBodyForce())
    for changes, driven in (({}, False), (DRIVEN[what], True)):
        solver, told = fake_solver(scene=replace(free, **changes)), []
        solver.time = 0.5
        march(solver, until=1.0, progress=told.append)
        last = state(told[-1])
        assert told[-1].driven == driven
        assert ("energy change" in last) != driven
        assert last.endswith("energy 3 J") == driven


def test_energy_is_that_of_the_records(make_snapshot):
    told, pace = paced(0.0, steps=1)
    X, V = np.zeros((1, 3)), np.ones(1)
    for energy in (8.0, 6.0):
        # Density 2: kinetic 2/2 * 1 * 3 = 3.
        pace.looked(make_snapshot(X, V, np.ones((1, 3)), energy=energy))
        pace.recorded()
    assert [(p.start_energy, p.energy, p.energy_change) for p in told] == [
        (11.0, 11.0, 0.0),
        (11.0, 9.0, -2.0),
    ]
    assert [p.records for p in told] == [1, 2]


def test_a_run_says_when_it_is_over(fake_solver):
    told = []
    march(fake_solver(), until=0.3, every=0.1, progress=told.append)
    assert [p.over for p in told] == [False, False, True]
    assert told[-1].percent == 100.0
    told.clear()
    with pytest.raises(Diverged):
        march(fake_solver(fails_at=0.25), until=1.0, every=0.1, progress=told.append)
    assert [p.over for p in told] == [False, False, True]
    assert told[-1].time == pytest.approx(0.25)


def test_a_run_that_goes_on_counts_from_where_it_began(fake_solver):
    solver, told = fake_solver(), []
    march(solver, until=0.5)
    march(solver, until=1.0, every=0.25, progress=told.append)
    assert [p.percent for p in told] == [50.0, 100.0]


NOW = Progress(
    start=0.0, time=0.02, until=0.1, step=40, dt=5e-4, records=3, wall=8.0, steps_per_second=12.5,
    eta=125.0, start_energy=200.0, energy=199.0,
)  # fmt: skip


def changed(**new):
    return Progress(**{**vars(NOW), **new})


def test_the_line_says_all_of_it():
    assert state(NOW) == (
        "t = 0.02 of 0.1 s, 40 steps, dt 0.0005 s, 12.5 steps/s, 2 min 05 s left, "
        "energy change -0.5 %"
    )
    assert "8.0 s taken" in state(changed(over=True))
    # Where loads or dissipation act a change is no error, so the word drift is not used.
    assert "drift" not in state(NOW)


def test_a_body_that_starts_at_rest_has_no_relative_change():
    assert state(changed(start_energy=0.0, energy=3.0e4)).endswith("energy 3e+04 J")
    assert state(changed(driven=True)).endswith("energy 199 J")
    assert state(changed(start_energy=1e-9, energy=3.0e4)).endswith("energy 3e+04 J")
    nothing = changed(start_energy=math.nan, energy=math.nan, steps_per_second=math.nan)
    assert state(nothing).endswith("dt 0.0005 s")


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(None, "?"), (math.nan, "?"), (0.04, "0.0 s"), (59.9, "59.9 s"), (60.0, "1 min 00 s"),
     (3725.0, "1 h 02 min")],
)  # fmt: skip
def test_durations(seconds, text):
    assert duration(seconds) == text


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def screen(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setenv("TERM", "xterm")
    return Terminal()


def lines_of(screen):
    """What was drawn, without colours and movements of the cursor."""
    return re.split(r"\x1b\[[0-9;?]*[A-Za-z]|[\r\n]", screen.getvalue())


def test_a_terminal_gets_one_line_that_changes(screen):
    show = ProgressLine(stream=screen)
    for step in (1, 2, 3):
        show(changed(step=step, over=step == 3))
    drawn = [text for text in lines_of(screen) if "steps" in text]
    assert all(len(text) <= 60 for text in drawn)
    for step in (1, 2, 3):
        assert any(f" t = 0.02 of 0.1 s, {step} steps" in text for text in drawn)
    assert screen.getvalue().endswith("\x1b[?25h"), "the cursor is shown again"


def test_a_line_that_stays_goes_above_the_bar(screen):
    display = Display(stream=screen)
    display.show(10.0, "one [of] two", at=0.0)
    display.say("[news]")
    display.show(20.0, "two [of] two", at=1.0, last=True)
    drawn = "".join(lines_of(screen))
    assert drawn.index("one [of] two") < drawn.index("[news]") < drawn.index("two [of] two")


def test_a_log_gets_a_line_now_and_then_and_the_last():
    log = io.StringIO()
    show = ProgressLine(stream=log, every=10.0)
    for wall in range(100):
        show(changed(wall=wall / 3.0, step=wall, over=wall == 99))
    lines = log.getvalue().splitlines()
    steps = [int(text.split(" steps")[0].split()[-1]) for text in lines]
    assert steps == [0, 30, 60, 90, 99]
    assert "\r" not in log.getvalue()
