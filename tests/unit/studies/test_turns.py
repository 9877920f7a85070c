"""Windows of steps that take turns."""

from __future__ import annotations

import pytest

from studies.measures.turns import Windows, take_turns


class FakeSim:
    """Counts its steps in ``log`` and needs a stated time for each."""

    stabilisation = None

    def __init__(self, name="sim", log=None, clock=None, pace=lambda step: 1.0):
        self.name, self.step, self.pace = name, 0, pace
        self.log, self.clock = [] if log is None else log, clock or [0.0]

    def stable_time_step(self):
        return 1.0

    def advance(self, dt):
        self.clock[0] += self.pace(self.step)
        self.step += 1
        self.log.append(self.name)


def test_the_least_of_the_windows_counts():
    """A clock that runs slowly in the second window of three."""
    sim = FakeSim(pace=lambda step: 1.8 if 8 <= step < 13 else 1.0)
    windows = Windows(sim, 5.0, lambda: sim.clock[0])
    for _ in range(3):
        windows.run()
    assert windows.steps == 5
    assert windows.found == pytest.approx([1.0, 1.8, 1.0])
    assert windows.least == pytest.approx(1.0)
    assert windows.spread == pytest.approx(0.8)
    assert sim.step == 1 + 2 + 3 * 5


def test_a_window_has_two_steps_however_long_they_are():
    sim = FakeSim(pace=lambda step: 100.0)
    assert Windows(sim, 5.0, lambda: sim.clock[0]).steps == 2


def test_all_take_turns():
    log, clock = [], [0.0]
    sims = [FakeSim(name, log, clock) for name in "abc"]
    timed = take_turns(sims, rounds=2, window_s=4.0, clock=lambda: clock[0])
    assert [each.steps for each in timed] == [4, 4, 4]
    assert "".join(log[-24:]) == 2 * ("aaaa" + "bbbb" + "cccc")
