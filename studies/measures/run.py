"""One run of a solver to its end, or to where it diverged: both are results."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from sphsolid.errors import Diverged
from sphsolid.record.history import History
from sphsolid.record.recorders import Recorder
from studies.measures.folding import folding

#: What :meth:`Ran.columns` gives.
COLUMNS = (
    "survived", "diverged_at", "where", "why", "folded", "folded_at", "steps", "wall_s", "cpu_s",
)  # fmt: skip


@dataclass(frozen=True)
class Ran:
    """What a run was: its ``history`` up to the end or the last good record, and its outcome.

    ``diverged`` is None for a run that reached its end.  ``wall_s`` and ``cpu_s`` [s] are without
    the set-up.
    """

    history: pd.DataFrame
    diverged: Diverged | None
    steps: int
    wall_s: float
    cpu_s: float
    folded: bool
    folded_at: float

    @property
    def survived(self) -> bool:
        """Whether it reached its end."""
        return self.diverged is None

    def columns(self) -> dict[str, Any]:
        """Columns :data:`COLUMNS`; times in s."""
        stop = self.diverged
        return {
            "survived": stop is None,
            "diverged_at": math.nan if stop is None else stop.time,
            "where": "" if stop is None else "({:.3g}, {:.3g}, {:.3g}) m".format(*stop.position),
            "why": "" if stop is None else stop.reason,
            "folded": self.folded,
            "folded_at": self.folded_at,
            "steps": self.steps,
            "wall_s": self.wall_s,
            "cpu_s": self.cpu_s,
        }


def run(
    solver: Any,
    *,
    until: float,
    every: float | None = None,
    record: Sequence[Recorder] = (),
) -> Ran:
    """Advance ``solver`` to ``until`` [s] with records ``every`` [s], and say how it went."""
    return attempt(solver, lambda: solver.run(until=until, every=every, record=record))


def attempt(solver: Any, work: Callable[[], History | None]) -> Ran:
    """Do ``work`` with ``solver``, and say how it went; the history is what ``work`` returns."""
    started, busy = time.perf_counter(), time.process_time()
    diverged = None
    try:
        history = work()
    except Diverged as stop:
        diverged, history = stop, getattr(stop, "history", None)
    return Ran(
        history=pd.DataFrame() if history is None else history.table,
        diverged=diverged,
        steps=solver.step,
        wall_s=time.perf_counter() - started,
        cpu_s=time.process_time() - busy,
        **folding(solver),
    )
