"""How far a study is, and when it will be done; :class:`Display` shows it."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

from sphsolid.record.display import Display, duration
from studies.engine.case import Case, Outcome
from studies.engine.pool import Watch


@dataclass
class _Pace:
    cost: float = 0.0
    wall: float = 0.0

    def add(self, cost: float, wall: float) -> None:
        """One more finished case."""
        self.cost += cost
        self.wall += wall


class Estimate:
    """Share of the expected work done, and the time left at the pace so far."""

    def __init__(self, cases: Sequence[Case], jobs: int) -> None:
        self.count = len(cases)
        self.done = 0
        self._jobs = jobs
        self._cost = {case.key: case.cost for case in cases}
        self._total = sum(self._cost.values())
        #: Cost and wall time [s] of what is finished: first cases of a worker, and all others.
        self._first, self._later = _Pace(), _Pace()
        self._running: dict[str, float] = {}
        self._begun: list[str] = []

    def started(self, case: Case) -> None:
        """Begin to count the time of a case."""
        self._running[case.key] = time.monotonic()
        if case.key not in self._begun:
            self._begun.append(case.key)

    def finished(self, case: Case, outcome: Outcome) -> None:
        """Learn the pace; a case that stopped early says nothing about it."""
        self._running.pop(case.key, None)
        cost = self._cost.pop(case.key, 0.0)
        self.done += 1
        if not outcome.failed:
            # The first case of a worker pays for its imports and for loading the kernels.
            is_first = case.key in self._begun[: self._jobs]
            (self._first if is_first else self._later).add(cost, outcome.wall_s)

    @property
    def percent(self) -> float:
        """Of the expected work, 0 to 100 (99 at most before the last case is done)."""
        if self.done == self.count:
            return 100.0
        left = sum(self._cost.values())
        pace = self._pace()
        if pace is not None:
            left -= sum(min(0.99 * self._cost[k], self._age(k) / pace) for k in self._running)
        return min(99.0, 100.0 * (1.0 - left / self._total))

    def seconds_left(self) -> float | None:
        """Expected wall time to the end, or ``None`` before the first case is done."""
        pace = self._pace()
        if pace is None:
            return None
        left = {k: max(0.0, pace * c - self._age(k)) for k, c in self._cost.items()}
        return max([sum(left.values()) / self._jobs, *left.values()], default=0.0)

    def text(self) -> str:
        """The time left in words."""
        left = self.seconds_left()
        if self.done == self.count:
            return "done"
        if left is not None and left < 0.5 and self._running:
            return "longer than expected"
        if left is not None and self._later.cost == 0.0:
            return f"at most {duration(left)} left"
        return f"{duration(left)} left"

    def _pace(self) -> float | None:
        """Seconds a unit of cost: too many as long as only first cases of a worker are known."""
        known = self._later if self._later.cost else self._first
        return known.wall / known.cost if known.cost else None

    def _age(self, key: str) -> float:
        return time.monotonic() - self._running[key] if key in self._running else 0.0


def _result(outcome: Outcome) -> str:
    if outcome.failed:
        return f"FAILED after {duration(outcome.wall_s)}: {outcome.failure}: {outcome.message}"
    return duration(outcome.wall_s)


class Reporter(Watch):
    """Tells a display what becomes of the cases."""

    def __init__(self, cases: Sequence[Case], jobs: int, display: Display) -> None:
        self._estimate = Estimate(cases, jobs)
        self._display = display
        self._running: list[str] = []

    def say(self, text: str) -> None:
        """One line of news."""
        self._display.say(text)

    def started(self, case: Case) -> None:
        """A worker took the case."""
        self._estimate.started(case)
        if case.key not in self._running:
            self._running.append(case.key)
        self.tick()

    def finished(self, case: Case, outcome: Outcome) -> None:
        """``[ 3/40]  12 %  key  4.1 s  (2 min 05 s left)``; a terminal keeps what failed alone."""
        e = self._estimate
        e.finished(case, outcome)
        if case.key in self._running:
            self._running.remove(case.key)
        if outcome.failed or not self._display.is_terminal:
            width = len(str(e.count))
            where = f"[{e.done:{width}d}/{e.count}] {e.percent:3.0f} %"
            self.say(f"{where}  {case.key}  {_result(outcome)}  ({e.text()})")
        self.tick()

    def tick(self) -> None:
        """Time passed; a log needs no clock."""
        e = self._estimate
        if self._display.is_terminal:
            text = f"{e.done} of {e.count} cases, {e.text()}  {', '.join(self._running)}"
            self._display.show(e.percent, text, at=time.monotonic())

    def close(self) -> None:
        """Nothing more will come."""
        self._display.close()


def reporter(cases: Sequence[Case], jobs: int) -> Reporter:
    """The reporter of a study, on standard output."""
    return Reporter(cases, jobs, Display(stream=sys.stdout))
