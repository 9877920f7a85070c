"""What a step costs, measured side by side: all that is compared takes turns, a window each.

A shared machine is faster at one time than at another, by up to a half, and stays so for minutes.
Windows that take turns meet it all at the same times.  Of each simulation the least window counts,
since whatever else the machine does can only add.  Neither compilation nor set-up is in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from studies.measures.rhythm import cycle


@dataclass
class Windows:
    """Windows of ``steps`` steps of ``sim``, about ``window_s`` seconds of ``clock`` each.

    They are whole cycles (see :mod:`studies.measures.rhythm`) of at least two steps.  ``found`` has
    the seconds a step of each window.
    """

    sim: Any
    window_s: float
    clock: Callable[[], float] = time.process_time
    steps: int = field(init=False)
    found: list[float] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        """Choose the steps of a window by a short one, which also ends what begins a run."""
        self.sim.advance(self.sim.stable_time_step())
        whole = cycle(self.sim)
        fewest = whole * -(-2 // whole)
        guess = max(self._seconds(fewest), 1.0e-9)
        self.steps = max(fewest, whole * round(self.window_s / guess / whole))

    def run(self) -> None:
        """One more window."""
        self.found.append(self._seconds(self.steps))

    @property
    def least(self) -> float:
        """Seconds a step of the fastest window."""
        return min(self.found)

    @property
    def spread(self) -> float:
        """The slowest window over the fastest, less one."""
        return max(self.found) / self.least - 1.0

    def _seconds(self, steps: int) -> float:
        started = self.clock()
        for _ in range(steps):
            self.sim.advance(self.sim.stable_time_step())
        return (self.clock() - started) / steps


def take_turns(
    sims: Iterable[Any],
    *,
    rounds: int,
    window_s: float,
    clock: Callable[[], float] = time.process_time,
) -> list[Windows]:
    """So many ``rounds`` of a window of each of ``sims``, in their order."""
    timed = [Windows(sim, window_s, clock) for sim in sims]
    for _ in range(rounds):
        for each in timed:
            each.run()
    return timed
