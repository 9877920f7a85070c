"""Ctrl-C between two steps, never inside one.

The ``KeyboardInterrupt`` goes on to the caller.  A script that does not catch it is ended by
Python with the signal itself: status 130 in a shell, ``-SIGINT`` in ``subprocess``.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Interrupt:
    """Whether Ctrl-C was pressed."""

    def __init__(self) -> None:
        self.pressed = False

    def check(self) -> None:
        """Raise the ``KeyboardInterrupt`` that was held back."""
        if self.pressed:
            self.pressed = False
            raise KeyboardInterrupt


@contextmanager
def held_interrupt() -> Iterator[Interrupt]:
    """Hold Ctrl-C back until ``check`` is called; a second one acts at once.

    An interrupt inside a step would leave fields of two instants, and one inside a record half a
    record.  Where Python's own handler is not in charge (another thread, a host program with a
    handler of its own) nothing is changed and ``check`` does nothing.
    """
    interrupt = Interrupt()
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interrupt
        return

    def hold(number: int, frame: FrameType | None) -> None:
        if interrupt.pressed:
            raise KeyboardInterrupt
        interrupt.pressed = True

    signal.signal(signal.SIGINT, hold)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # Pressed after the last check: the run is complete, but whoever pressed wants to stop.
    interrupt.check()
