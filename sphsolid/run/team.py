"""How many threads take a step: as many as pay, of those that kernels may use.

To wake a thread takes from a few microseconds to some hundred on a shared machine, and every step
wakes them about ten times.  On a body of a few thousand points that is more than they save.  What
pays depends on the machine and on who else uses it, so it is found by the clock while steps are
taken.  Results cannot tell: their bits do not depend on the number of threads.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from functools import wraps
from statistics import median
from typing import Any, Concatenate, ParamSpec, TypeVar

from sphsolid import compiled

#: Points a thread should have at the least, before anything is known of the machine.
POINTS = 4096
#: Steps that one number of threads is tried for; how many are then looked at together, and after
#: how many such looks all is tried again.
TRIAL, LOOK, AGAIN = 5, 25, 80
#: Steps that take so many times longer than they did have another run beside them: try again.
SLOWER = 1.5
#: Share of the time of a step that another number of threads must save.
WORTH = 0.05

_P = ParamSpec("_P")
_Result = TypeVar("_Result")


def counts_of(allowed: int) -> list[int]:
    """The numbers of threads that are tried: powers of two, and all of them."""
    powers = [2**k for k in range(allowed.bit_length()) if 2**k < allowed]
    return [*powers, allowed]


def _search(counts: list[int], start: int) -> Generator[int, float, None]:
    """What the next step is to be taken with; it is sent what the step took [s].

    From ``counts[start]`` on more threads, or if that is of no use fewer, as long as it helps.
    """
    at = start
    while True:
        best = yield from _measured(counts[at], TRIAL)
        for way in (1, -1):
            began = at
            while 0 <= at + way < len(counts):
                took = yield from _measured(counts[at + way], TRIAL)
                if took > (1.0 - WORTH) * best:
                    break
                at, best = at + way, took
            if at != began:
                break
        for _ in range(AGAIN):
            took = yield from _measured(counts[at], LOOK)
            if took > SLOWER * best:
                break


def _measured(count: int, steps: int) -> Generator[int, float, float]:
    seconds = []
    for _ in range(steps):
        seconds.append((yield count))
    return median(seconds)


class Team:
    """The threads that take the steps of one body of ``points``."""

    def __init__(self, points: int, *, clock: Callable[[], float] = time.perf_counter) -> None:
        self._points, self._clock = points, clock
        #: By the number of threads that are allowed: the search, and what it says now.
        self._searches: dict[int, tuple[Generator[int, float, None], int]] = {}
        self._is_at_work = False

    def size(self, allowed: int) -> int:
        """How many of the ``allowed`` threads the next step is taken with."""
        if allowed not in self._searches:
            counts = counts_of(allowed)
            enough = [count for count in counts if count * POINTS <= self._points]
            search = _search(counts, max(0, len(enough) - 1))
            self._searches[allowed] = search, next(search)
        return self._searches[allowed][1]

    def run(self, act: Callable[[], _Result], *, is_step: bool) -> _Result:
        """What ``act()`` returns, done by the team; a step tells it what it took."""
        allowed = compiled.threads()
        if allowed == 1 or self._is_at_work:
            return act()
        started = self._clock()
        compiled.set_threads(self.size(allowed))
        self._is_at_work = True
        try:
            result = act()
        finally:
            self._is_at_work = False
            compiled.set_threads(allowed)
        if is_step:
            search, _ = self._searches[allowed]
            self._searches[allowed] = search, search.send(self._clock() - started)
        return result


def _by_team(
    method: Callable[Concatenate[Any, _P], _Result], *, is_step: bool
) -> Callable[Concatenate[Any, _P], _Result]:
    def done(self: Any, *args: _P.args, **kwargs: _P.kwargs) -> _Result:
        team: Team = self.team
        return team.run(lambda: method(self, *args, **kwargs), is_step=is_step)

    made: Any = wraps(method)(done)
    return made


def step_by_team(
    method: Callable[Concatenate[Any, _P], _Result],
) -> Callable[Concatenate[Any, _P], _Result]:
    """A method that takes a step, taken with as many threads as pay."""
    return _by_team(method, is_step=True)


def by_team(
    method: Callable[Concatenate[Any, _P], _Result],
) -> Callable[Concatenate[Any, _P], _Result]:
    """A method that belongs to a step."""
    return _by_team(method, is_step=False)
