"""A line on the terminal while a set-up takes its time, so that nobody waits in silence."""

from __future__ import annotations

import multiprocessing
import sys
import time as clock
from collections.abc import Callable
from typing import TextIO

#: Seconds after which work is called slow, and between two lines about it.
AFTER, EVERY = 3.0, 0.5


class SlowWork:
    """Says on standard error what is done, where that is a terminal; the line is wiped at the end.

    Nothing is written elsewhere, nor by the workers of a study, which share one terminal.
    """

    def __init__(
        self,
        what: str,
        *,
        stream: TextIO | None = None,
        now: Callable[[], float] = clock.perf_counter,
    ) -> None:
        self._what, self._now = what, now
        self._stream = sys.stderr if stream is None else stream
        self._heard = self._stream.isatty() and multiprocessing.parent_process() is None
        self._next = now() + AFTER if self._heard else 0.0
        self._written = 0

    def at(self, state: str) -> None:
        """Where the work is: written at most twice a second."""
        if not self._heard or self._now() < self._next:
            return
        self._next = self._now() + EVERY
        line = f"set-up: {self._what}: {state}"
        self._stream.write("\r" + line.ljust(self._written))
        self._stream.flush()
        self._written = len(line)

    def over(self) -> None:
        """Wipe the line, if there is one."""
        if self._written:
            self._stream.write("\r" + " " * self._written + "\r")
            self._stream.flush()
