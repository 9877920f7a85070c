"""The loop over time that both solvers run."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence

from sphsolid.errors import FoldingWarning, require
from sphsolid.record.history import History, Row, check_columns
from sphsolid.record.interrupt import Interrupt, held_interrupt
from sphsolid.record.output import NO_OUTPUT, Output, Sink, Task
from sphsolid.record.positions import PositionVerdict
from sphsolid.record.progress import Pace, Progress
from sphsolid.record.recorder_words import recorder_words
from sphsolid.record.recorders import Recorder, asks_for_budget
from sphsolid.record.run_options import (
    check_output,
    check_progress,
    checked_recorders,
    checked_row,
    time_of,
)
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.solver import Solver

#: Share of a gap or a step within which two instants are the same.
SAME = 1e-9
#: Column from which a resumed run knows the energy that it began with.
TOTAL_ENERGY = "total_energy [J]"
_OURS = ("sphsolid", "fem_reference")


def march(
    solver: Solver,
    *,
    until: float | None = None,
    every: float | None = None,
    record: Sequence[Recorder] = (),
    progress: Callable[[Progress], None] | None = None,
    output: Output = NO_OUTPUT,
) -> History:
    """Advance to ``until`` [s], recording now and then every ``every`` [s].

    ``until`` defaults to the scene's end time, ``every`` to the whole span.  Records fall on whole
    multiples of ``every`` and on ``until``, so that a run that goes on, in this process or from a
    checkpoint, has the same instants as one that never stopped.  Steps are shortened evenly so that
    each record falls exactly on a step end: between two records all steps are
    ``gap / ceil(gap / dt_stable)`` as long as the stable step does not change.  A record is taken
    after a completed step, when every field is at the same instant.

    ``output`` takes every record as it is made; when it resumes an earlier run, the history begins
    with that run's rows.  ``progress`` is called at records and twice a second.  Ctrl-C acts
    between two steps, or after the record being made.  Raises ``InputError`` for times that are not
    ahead, ``Diverged`` when the solution does; the history so far is attached to that exception,
    and to ``KeyboardInterrupt``, as ``history``.

    Positions are judged at the start, at records, at the end and every ``solver.positions.every``
    steps (see ``positions``); the first time that they are folded a ``FoldingWarning`` says so, and
    the run goes on.
    """
    until, every = time_of("until", until), time_of("every", every)
    record = checked_recorders(record)
    check_progress(progress)
    check_output(output)
    end = solver.scene.end_time if until is None else until
    require(every is None or 0.0 < every < math.inf, f"every = {every} s must be positive, finite")
    if asks_for_budget(record):
        solver.track_budget()
    # Before they look: what a recorder remembers is no part of what it is.
    words = tuple(map(recorder_words, record)) if output.wants_records else ()
    rows = output.take_up(solver)
    if rows and solver.time == end:
        # Nothing is left to do but what a kill at the very end may have left undone.
        output.open(solver, Task(end, every, record, words), rows).close(None)
        return History.of(rows)
    require(
        math.isfinite(end) and end > solver.time,
        f"until = {end} s is not after the present time {solver.time} s",
    )
    began_with = rows[0].get(TOTAL_ENERGY, math.nan) if rows else math.nan
    pace = Pace(
        progress,
        start=solver.time,
        until=end,
        driven=solver.scene.is_driven,
        start_energy=began_with,
    )
    return _Run(solver, Task(end, every, record, words), output, rows, pace).go()


class _Run:
    """One call of :func:`march`: the solver, and all who are told of its records and steps."""

    def __init__(
        self,
        solver: Solver,
        task: Task,
        output: Output,
        rows: list[Row],
        pace: Pace,
    ) -> None:
        self._solver, self._task, self._output = solver, task, output
        self._rows, self._pace = rows, pace
        self._keeps_rows = bool(task.record) or output.wants_records
        self._judged_step = -1
        self._has_warned = False

    def go(self) -> History:
        solver, task = self._solver, self._task
        until = task.until
        at_start = solver.step == 0 and not self._rows
        # Recorders are tried before a file is touched, and against the rows they will continue.
        first = self._look() if at_start or self._rows or self._pace.is_told else None
        if first is not None and self._rows:
            check_columns(list(self._rows[-1]), list(first[1]))
        sink = self._output.open(solver, task, self._rows)
        try:
            self._judge()
            with held_interrupt() as interrupt:
                if at_start:
                    self._keep(first, sink, last=False)
                for target in _targets(solver.time, until, task.every):
                    self._march_to(target, interrupt)
                    seen = self._look()
                    if seen is not None or target == until:
                        self._judge()
                    self._keep(seen, sink, last=target == until)
                    interrupt.check()
        except BaseException as failure:
            failure.history = History.of(self._rows)  # type: ignore[attr-defined]
            sink.close(failure)
            self._pace.failed()
            raise
        sink.close(None)
        return History.of(self._rows)

    def _judge(self) -> None:
        """Look at the positions, once a step, and warn of the first fold."""
        solver = self._solver
        if self._judged_step == solver.step:
            return
        self._judged_step = solver.step
        verdict = solver.positions.look(solver.placement())
        if verdict.folded and not self._has_warned:
            self._has_warned = True
            self._pace.folded(solver.positions.folded_since)
            _warn(solver, verdict)

    def _look(self) -> tuple[Snapshot, Row] | None:
        if not (self._keeps_rows or self._pace.is_told):
            return None
        snapshot = self._solver.snapshot()
        self._pace.looked(snapshot)
        row: Row = {"time [s]": snapshot.time, "step": snapshot.step}
        for recorder in self._task.record:
            row |= checked_row(recorder, recorder.record(snapshot, self._solver.scene), row)
        return snapshot, row

    def _keep(self, seen: tuple[Snapshot, Row] | None, sink: Sink, *, last: bool) -> None:
        if seen is None:
            return
        snapshot, row = seen
        if self._keeps_rows:
            if self._rows:
                check_columns(list(self._rows[-1]), list(row))
            sink.write(snapshot, row, last=last)
            self._rows.append(row)
        if snapshot.step > 0:
            self._pace.recorded()

    def _march_to(self, target: float, interrupt: Interrupt) -> None:
        solver = self._solver
        while True:
            remaining = target - solver.time
            steps = max(1, math.ceil(remaining / solver.stable_time_step() - SAME))
            dt = remaining / steps
            solver.advance(dt)
            if steps == 1:
                # The last step of the gap lands on the target; name that instant exactly.
                solver.time = target
                # What diverged in this very step must not be recorded, nor end the run well.
                solver.check_state()
            self._pace.stepped(solver.time, solver.step, dt)
            if steps == 1:
                return
            if solver.step % solver.positions.every == 0:
                self._judge()
            interrupt.check()


def _warn(solver: Solver, verdict: PositionVerdict) -> None:
    warnings.warn(
        f"{solver.name}: the positions have folded, found at t = {solver.time:.4g} s, step "
        f"{solver.step}: {'; '.join(verdict.reasons)}. The run goes on, but what it gives from now "
        "on is of no use, however sound its stresses and Jacobians look: compare with the finite "
        "elements of fem_reference, or take a finer spacing",
        FoldingWarning,
        stacklevel=_levels_up(),
    )


def _levels_up() -> int:
    """Frames from :func:`_warn` to whoever called ``run``: that line is what a warning names."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals["__name__"].split(".")[0] in _OURS:
        level, frame = level + 1, frame.f_back
    return level


def _targets(now: float, end: float, every: float | None) -> Iterator[float]:
    if every is not None:
        k = math.floor(now / every + SAME) + 1
        while k * every < end - SAME * every:
            yield k * every
            k += 1
    yield end
