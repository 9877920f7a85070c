"""Shows how far a study is: a bar on a terminal, one line per finished case elsewhere."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn

from studies.engine.case import Case, Outcome


class Reporter(Protocol):
    """What the front tells as a study goes on."""

    def say(self, text: str) -> None:
        """One line of news."""
        ...

    def started(self, case: Case) -> None:
        """A worker took the case."""
        ...

    def finished(self, case: Case, outcome: Outcome) -> None:
        """The case is done, one way or the other."""
        ...

    def tick(self) -> None:
        """Time passed."""
        ...

    def close(self) -> None:
        """Nothing more will come."""
        ...


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


def duration(seconds: float | None) -> str:
    """``4.1 s``, ``2 min 05 s``, ``1 h 10 min``, or ``?``."""
    if seconds is None or seconds != seconds:
        return "?"
    if seconds < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"


def _result(outcome: Outcome) -> str:
    if outcome.failed:
        return f"FAILED after {duration(outcome.wall_s)}: {outcome.failure}: {outcome.message}"
    return duration(outcome.wall_s)


class PlainReporter:
    """One line per case, for logs and pipes."""

    def __init__(self, cases: Sequence[Case], jobs: int) -> None:
        self._estimate = Estimate(cases, jobs)

    def say(self, text: str) -> None:
        """Print a line at once, so that a log shows it while the study runs."""
        print(text, flush=True)

    def started(self, case: Case) -> None:
        """Only the estimate needs to know."""
        self._estimate.started(case)

    def finished(self, case: Case, outcome: Outcome) -> None:
        """``[ 3/40]  12 %  key  4.1 s  (2 min 05 s left)``."""
        e = self._estimate
        e.finished(case, outcome)
        width = len(str(e.count))
        where = f"[{e.done:{width}d}/{e.count}] {e.percent:3.0f} %"
        self.say(f"{where}  {case.key}  {_result(outcome)}  ({e.text()})")

    def tick(self) -> None:
        """A log needs no clock."""

    def close(self) -> None:
        """Nothing is open."""


class BarReporter:
    """A bar with percent and time left; failures stay above it."""

    def __init__(self, cases: Sequence[Case], jobs: int, console: Console) -> None:
        self._estimate = Estimate(cases, jobs)
        self._console = console
        self._running: list[str] = []
        self._bar = Progress(
            TextColumn("{task.fields[count]}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %  {task.fields[left]}  [dim]{task.fields[now]}"),
            console=console,
        )
        self._task: TaskID = self._bar.add_task("", total=100.0, count="", left="", now="")
        self._bar.start()
        self.tick()

    def say(self, text: str) -> None:
        """A line above the bar."""
        self._console.print(escape(text), highlight=False)

    def started(self, case: Case) -> None:
        """Show what is being worked on."""
        self._estimate.started(case)
        if case.key not in self._running:
            self._running.append(case.key)
        self.tick()

    def finished(self, case: Case, outcome: Outcome) -> None:
        """Move the bar; keep a line of what failed."""
        self._estimate.finished(case, outcome)
        if case.key in self._running:
            self._running.remove(case.key)
        if outcome.failed:
            self._console.print(f"[red]{escape(case.key)}[/red]  {escape(_result(outcome))}")
        self.tick()

    def tick(self) -> None:
        """Bring the percentage and the time left up to date."""
        e = self._estimate
        self._bar.update(
            self._task,
            completed=e.percent,
            count=f"{e.done}/{e.count} cases",
            left=e.text(),
            now=escape(", ".join(self._running)),
        )

    def close(self) -> None:
        """Take the bar away from the cursor."""
        self._bar.stop()


def reporter(cases: Sequence[Case], jobs: int) -> Reporter:
    """A bar when a person watches, lines when not."""
    console = Console()
    if console.is_terminal:
        return BarReporter(cases, jobs, console)
    return PlainReporter(cases, jobs)
