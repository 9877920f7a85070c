"""The number of threads that take a step: found by the clock, felt by nobody."""

from __future__ import annotations

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid import compiled
from sphsolid.run import team
from sphsolid.run.team import AGAIN, LOOK, POINTS, TRIAL, Team, counts_of
from sphsolid.scenes import swinging_cube


class Machine:
    """Threads and a clock: a step takes ``seconds(threads)``."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, allowed: int, seconds) -> None:
        self.count, self.now, self.seconds, self.used = allowed, 0.0, seconds, []
        monkeypatch.setattr(compiled, "threads", lambda: self.count)
        monkeypatch.setattr(compiled, "set_threads", lambda count: setattr(self, "count", count))

    def steps(self, of: Team, number: int) -> list[int]:
        """The threads of so many steps."""
        self.used = []
        for _ in range(number):
            of.run(self._step, is_step=True)
        return self.used

    def team(self, points: int) -> Team:
        return Team(points, clock=lambda: self.now)

    def _step(self) -> None:
        self.used.append(self.count)
        self.now += self.seconds(self.count)


def waking(work: float, each: float):
    """Work that divides among threads, and what it costs to wake every one of them."""
    return lambda count: work / count + each * (count - 1)


@pytest.mark.parametrize("allowed", [2, 6, 8, 64])
@pytest.mark.parametrize("points", [100, 5000, 10**6])
@pytest.mark.parametrize(
    "seconds", [waking(1e-4, 1e-3), waking(1e-3, 1e-4), waking(1e-2, 1e-6), waking(4e-2, 1e-3)]
)
def test_it_takes_the_number_that_pays_wherever_it_begins(monkeypatch, allowed, points, seconds):
    machine = Machine(monkeypatch, allowed, seconds)
    used = machine.steps(machine.team(points), 300)[-1]
    counts = counts_of(allowed)
    # No neighbour saves more than what a change is worth.
    at = counts.index(used)
    for other in counts[max(0, at - 1) : at + 2]:
        assert seconds(other) > (1.0 - team.WORTH) * seconds(used) or other == used


def test_a_small_body_begins_with_one_thread_and_a_large_one_with_all(monkeypatch):
    machine = Machine(monkeypatch, 8, waking(1e-4, 1e-3))
    assert machine.steps(machine.team(POINTS), 1) == [1]
    assert machine.steps(machine.team(8 * POINTS), 1) == [8]
    assert machine.steps(machine.team(5 * POINTS), 1) == [4]


def test_it_looks_again_when_steps_take_longer_and_in_any_case_later_on(monkeypatch):
    machine = Machine(monkeypatch, 2, waking(1e-3, 1e-6))
    of = machine.team(100)
    assert machine.steps(of, 100)[-1] == 2
    machine.seconds = waking(1e-3, 1e-2)
    assert machine.steps(of, 2 * LOOK + 5 * TRIAL)[-1] == 1
    machine.seconds = waking(1e-3, 1e-6)
    assert machine.steps(of, LOOK * (AGAIN + 1) + 5 * TRIAL)[-1] == 2


def test_the_threads_that_are_allowed_are_given_back_also_by_a_step_that_fails(monkeypatch):
    machine = Machine(monkeypatch, 2, waking(1e-4, 1e-3))
    of = machine.team(100)

    def fails() -> None:
        assert machine.count == 1
        raise ValueError("lost")

    with pytest.raises(ValueError, match="lost"):
        of.run(fails, is_step=True)
    assert machine.count == 2
    # What is done within a step is done by the threads of the step.
    assert of.run(lambda: of.run(lambda: machine.count, is_step=False), is_step=True) == 1
    machine.count = 1
    assert of.run(lambda: machine.count, is_step=True) == 1


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_bits_do_not_depend_on_what_the_team_does(solver, monkeypatch):
    """Steps with any number of threads between them, and with one."""
    before, found = compiled.threads(), []
    most = 2 if compiled.numba.config.NUMBA_NUM_THREADS > 1 else 1
    for allowed in (1, most):
        compiled.set_threads(allowed)
        monkeypatch.setattr(team, "TRIAL", 1)
        monkeypatch.setattr(team, "LOOK", 1)
        monkeypatch.setattr(team, "AGAIN", 1)
        try:
            sim = solver(swinging_cube(), spacing=1 / 6)
            for _ in range(20):
                sim.advance(sim.stable_time_step())
        finally:
            compiled.set_threads(before)
        found.append(sim.state_arrays())
    for name, array in found[0].items():
        np.testing.assert_array_equal(array, found[1][name])
