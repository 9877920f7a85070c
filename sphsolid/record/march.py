"""The loop over time that both solvers run, and the history it returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import pandas as pd

from sphsolid.errors import InputError, require
from sphsolid.record.recorders import Recorder
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene


class Solver(Protocol):
    """What the loop needs of a method."""

    scene: Scene
    time: float
    step: int

    def stable_time_step(self) -> float:
        """Largest step [s] allowed now; raises ``Diverged`` when the state is invalid."""
        ...

    def advance(self, dt: float) -> None:
        """One step of length ``dt`` [s]."""
        ...

    def snapshot(self) -> Snapshot:
        """The state now."""
        ...


@dataclass(frozen=True)
class Progress:
    """Where a run is: given to the progress callback at every record."""

    time: float
    until: float
    step: int
    dt: float


@dataclass(frozen=True)
class History:
    """One row per record; the columns name their units."""

    table: pd.DataFrame

    def to_csv(self, path: str | Path) -> None:
        """Write all rows with full double precision."""
        self.table.to_csv(path, index=False, float_format="%.17g")

    def __getitem__(self, column: str) -> Any:
        return self.table[column].to_numpy()


def march(
    solver: Solver,
    *,
    until: float | None = None,
    every: float | None = None,
    record: Sequence[Recorder] = (),
    progress: Callable[[Progress], None] | None = None,
) -> History:
    """Advance to ``until`` [s], recording now and then every ``every`` [s].

    ``until`` defaults to the scene's end time, ``every`` to the whole span.  Steps are shortened
    evenly so that each record falls exactly on a step end: between two records all steps are
    ``gap / ceil(gap / dt_stable)`` as long as the stable step does not change.  A record is taken
    after a completed step, when every field is at the same instant.  Raises ``InputError`` for
    times that are not ahead, ``Diverged`` when the solution is lost (the history so far is
    attached to the exception as ``history``).
    """
    end = solver.scene.end_time if until is None else until
    require(
        math.isfinite(end) and end > solver.time,
        f"until = {end} s is not after the present time {solver.time} s",
    )
    gap = end - solver.time if every is None else every
    require(math.isfinite(gap) and gap > 0.0, f"every = {every} s must be positive and finite")
    rows: list[dict[str, float]] = []

    def take() -> None:
        if not record:
            return
        snapshot = solver.snapshot()
        row: dict[str, float] = {"time [s]": snapshot.time, "step": snapshot.step}
        for recorder in record:
            row.update(recorder.record(snapshot, solver.scene))
        rows.append(row)

    try:
        if solver.step == 0:
            take()
        for target in _targets(solver.time, end, gap):
            dt = _march_to(solver, target)
            take()
            if progress is not None:
                progress(Progress(solver.time, end, solver.step, dt))
    except InputError:
        raise
    except Exception as failure:
        failure.history = History(pd.DataFrame(rows))  # type: ignore[attr-defined]
        raise
    return History(pd.DataFrame(rows))


def _targets(start: float, end: float, gap: float) -> Iterator[float]:
    count = max(1, math.ceil((end - start) / gap - 1e-9))
    for k in range(1, count):
        yield start + k * gap
    yield end


def _march_to(solver: Solver, target: float) -> float:
    dt = 0.0
    while True:
        remaining = target - solver.time
        steps = max(1, math.ceil(remaining / solver.stable_time_step() - 1e-9))
        dt = remaining / steps
        solver.advance(dt)
        if steps == 1:
            # The last step of the gap lands on the target; name that instant exactly.
            solver.time = target
            # A solution lost in this very step must not be recorded, nor end the run well.
            solver.stable_time_step()
            return dt
