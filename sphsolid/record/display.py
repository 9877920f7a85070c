"""Shows how far a run or a study is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import math
import sys
from typing import Any, TextIO


class Display:
    """What is shown of something that takes its time.

    ``stream`` is standard error unless given; ``every`` [s] apart are the lines of state that go to
    a file or a pipe (the last one always comes).
    """

    def __init__(self, *, stream: TextIO | None = None, every: float = 10.0) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._every = every
        self._printed_at = -math.inf
        self._bar: Any = None

    @property
    def is_terminal(self) -> bool:
        """Whether a person watches."""
        return self._stream.isatty()

    def show(self, percent: float, text: str, *, at: float, last: bool = False) -> None:
        """The state at ``at`` [s] of wall time, if it is time to."""
        if self.is_terminal:
            self._draw(percent, text)
        elif last or at - self._printed_at >= self._every:
            self._printed_at = -math.inf if last else at
            self.say(f"{percent:5.1f} %  {text}")
        if last:
            self.close()

    def say(self, text: str) -> None:
        """A line that stays, above the bar if there is one."""
        if self._bar is not None:
            self._bar.console.print(text, markup=False, highlight=False)
        else:
            print(text, file=self._stream, flush=True)

    def close(self) -> None:
        """Leave the bar as it is, with the cursor below it."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _draw(self, percent: float, text: str) -> None:
        if self._bar is None:
            self._bar = _bar(self._stream)
            self._bar.start()
        [task] = self._bar.task_ids
        self._bar.update(task, completed=percent, description=text, refresh=True)


def _bar(stream: TextIO) -> Any:
    # Most processes show nothing and need not load it.
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn
    from rich.table import Column

    text = TextColumn(
        "{task.description}",
        markup=False,
        table_column=Column(no_wrap=True, overflow="ellipsis"),
    )
    made = Progress(
        BarColumn(bar_width=20),
        TextColumn("{task.percentage:5.1f} %"),
        text,
        console=Console(file=stream),
        # No thread of its own: it changes when it is told to.
        auto_refresh=False,
    )
    made.add_task("", total=100.0)
    return made


def duration(seconds: float | None) -> str:
    """``4.1 s``, ``2 min 05 s``, ``1 h 10 min``, or ``?`` for None and nan."""
    if seconds is None or math.isnan(seconds):
        return "?"
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
