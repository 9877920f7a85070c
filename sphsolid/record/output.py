"""What a run leaves behind: nothing, or a folder of files (see ``run_folder``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from sphsolid.errors import require
from sphsolid.record.history import Row
from sphsolid.record.recorders import Recorder
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.solver import Solver


@dataclass(frozen=True)
class Task:
    """What ``run`` was asked for: ``until`` [s], records every ``every`` [s] or at the end only.

    ``recorders``: those of ``record`` in words, as they were before they saw anything.
    """

    until: float
    every: float | None
    record: Sequence[Recorder]
    recorders: Sequence[str] = ()


class Sink(Protocol):
    """Takes the records of one run."""

    def write(self, snapshot: Snapshot, row: Row, *, last: bool) -> None:
        """One record, with the solver at the same instant; ``last`` of the run."""
        ...

    def close(self, failure: BaseException | None) -> None:
        """The run has ended, well or with ``failure``."""
        ...


class Output(Protocol):
    """Where the records of a run go besides the history it returns."""

    @property
    def wants_records(self) -> bool:
        """False when snapshots need not be taken for it."""
        ...

    def take_up(self, solver: Solver) -> list[Row]:
        """Put ``solver`` back where an earlier run ended, and return the rows up to there.

        No rows, and the solver as it was, when there is nothing to go on with.  Raises
        ``InputError`` when the output is not free.  Changes no file.
        """
        ...

    def open(self, solver: Solver, task: Task, rows: Sequence[Row]) -> Sink:
        """Begin to write, after ``rows`` that are there already."""
        ...


@dataclass(frozen=True)
class NoOutput:
    """No file is written."""

    @property
    def wants_records(self) -> bool:
        """False."""
        return False

    def take_up(self, solver: Solver) -> list[Row]:
        """Nothing to go on with."""
        return []

    def open(self, solver: Solver, task: Task, rows: Sequence[Row]) -> Sink:
        """A sink without a drain."""
        return _NoSink()


NO_OUTPUT = NoOutput()


class _NoSink:
    def write(self, snapshot: Snapshot, row: Row, *, last: bool) -> None:
        pass

    def close(self, failure: BaseException | None) -> None:
        pass


@dataclass(frozen=True)
class Every:
    """At every ``records``-th record from the first, and at the last of a run."""

    records: int = 1

    def __post_init__(self) -> None:
        require(
            isinstance(self.records, int)
            and not isinstance(self.records, bool)
            and self.records >= 1,
            f"Every(records={self.records}) must be a whole number of records, at least 1; "
            "use Never() for none",
        )

    def due(self, index: int, *, last: bool) -> bool:
        """True at record ``index`` (from 0) when it is one of these."""
        return last or index % self.records == 0


#: Options are immutable objects, so one default serves every run.
EVERY_RECORD = Every()


@dataclass(frozen=True)
class Never:
    """At no record."""

    def due(self, index: int, *, last: bool) -> bool:
        """False."""
        return False
