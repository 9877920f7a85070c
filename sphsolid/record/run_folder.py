"""A folder that holds one run: history, frames, checkpoint; readable whenever the run is killed.

    run.json         what was run, by what, and how it ended
    history.csv      one row per record
    frames.pvd       all frames with their times: the file to open in ParaView
    frames/*.vtu     the body at its records
    run.vtkhdf       the same in one file, with the mesh once (see ``vtkhdf``)
    checkpoint.npz   the complete state at a record, from which a run goes on bit for bit
    manifest.txt     which of the files here are the run's
    .sphsolid-lock   while a run writes here (see ``folder_lock``)

A record is written in the order row, frame, collection, VTKHDF, checkpoint.  A row is appended by
one system call, the collection names a frame only when that is there, the one file of all records
grows as ``vtkhdf`` says, and every other file takes its place when it is complete: at any moment
everything can be read.  What is newer than the checkpoint,
a row and a frame at most if every record makes one, a resumed run makes again.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

from sphsolid.errors import InputError, require
from sphsolid.paths import path_of
from sphsolid.record.checkpoint import restore, write_checkpoint
from sphsolid.record.folder_lock import FolderLock, refuse_in_use
from sphsolid.record.folder_place import make_folder, refuse_no_folder, refuse_no_name
from sphsolid.record.history import HistoryFile, Row, read_rows
from sphsolid.record.manifest import NAME as MANIFEST
from sphsolid.record.manifest import Manifest
from sphsolid.record.output import EVERY_RECORD, Every, Never, Sink, Task
from sphsolid.record.recorder_words import refuse_other_recorders
from sphsolid.record.run_json import NAME as RUN
from sphsolid.record.run_json import RunJson, earlier_run, recorders_of
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.solver import Solver
from sphsolid.record.vtkhdf import VtkHdfFile, expected_records
from sphsolid.record.vtu import write_pvd, write_vtu

HISTORY, PVD, CHECKPOINT = "history.csv", "frames.pvd", "checkpoint.npz"
VTKHDF = "run.vtkhdf"
FIXED = [PVD, CHECKPOINT, HISTORY, VTKHDF, RUN]
FRAMES = "frames"
_FRAME = re.compile(FRAMES + r"/frame_(\d{6,})\.vtu")


@dataclass(frozen=True)
class RunFolder:
    """Write a run into the folder ``path``: ``run(..., output=RunFolder("out/column"))``.

    A folder that holds a run already is refused, unless ``replace`` says to remove that run's files
    (those on its manifest, nothing else) or ``resume`` to go on from its checkpoint; where there is
    no run, both begin one.  ``frames``, ``vtkhdf`` and ``checkpoints`` say at which records these
    are made: ``Every(records=5)``, ``Never()``.
    """

    path: str | Path
    _: KW_ONLY
    replace: bool = False
    resume: bool = False
    frames: Every | Never = EVERY_RECORD
    vtkhdf: Every | Never = EVERY_RECORD
    checkpoints: Every | Never = EVERY_RECORD

    def __post_init__(self) -> None:
        """Refuse what is no path, and options that contradict each other."""
        for name in ("replace", "resume"):
            value = getattr(self, name)
            # Anything else that is true would remove a run, the text "no" too.
            require(
                isinstance(value, bool), f"RunFolder: {name} = {value!r} must be True or False"
            )
        refuse_no_name(path_of(self.path))
        require(
            not (self.replace and self.resume),
            f"RunFolder({str(self.path)!r}): replace removes the run that resume would go on with; "
            "ask for one of them",
        )
        for name in ("frames", "vtkhdf", "checkpoints"):
            value = getattr(self, name)
            require(
                isinstance(value, Every | Never),
                f"RunFolder: {name} = {value!r} is not an option object; use Every(records=n) or "
                "Never()",
            )

    @property
    def wants_records(self) -> bool:
        """True."""
        return True

    def take_up(self, solver: Solver) -> list[Row]:
        """Restore ``solver`` from the folder's checkpoint when asked to; no file is changed."""
        folder = path_of(self.path)
        refuse_no_folder(folder)
        refuse_in_use(folder)
        manifest = Manifest(folder)
        _refuse_foreign(manifest)
        if not manifest.exists or self.replace:
            return []
        require(
            self.resume,
            f"{folder} already holds a run{_how_it_ended(folder)}; choose another folder, or "
            "RunFolder(..., replace=True) to remove that run's files first, or resume=True to go "
            "on from its checkpoint",
        )
        return _resume(folder, solver)

    def open(self, solver: Solver, task: Task, rows: Sequence[Row]) -> Sink:
        """Begin to write after ``rows``; raises ``InputError`` where there can be no folder.

        And where a recorder took the place of another of the run that goes on.
        """
        if rows:
            folder = path_of(self.path)
            refuse_other_recorders(recorders_of(folder), task.recorders, f"the run in {folder}")
        return _Writer(self, solver, task, rows)


def _how_it_ended(folder: Path) -> str:
    earlier = earlier_run(folder)
    return f" ({earlier['status']})" if earlier else ""


def _resume(folder: Path, solver: Solver) -> list[Row]:
    history = folder / HISTORY
    rows = read_rows(history) if history.exists() else []
    if not (folder / CHECKPOINT).exists():
        require(
            len(rows) <= 1,
            f"{folder} holds {len(rows)} records but no checkpoint to go on from; use replace=True",
        )
        return []
    records = restore(solver, folder / CHECKPOINT).records
    require(
        len(rows) >= records,
        f"{history} has {len(rows)} rows where the checkpoint was taken after {records}; use "
        "replace=True",
    )
    return rows[:records]


def _refuse_foreign(manifest: Manifest) -> None:
    folder = manifest.folder
    made = [f"{FRAMES}/{file.name}" for file in sorted(folder.glob(f"{FRAMES}/*"))]
    names = [*FIXED, *(name for name in made if _FRAME.fullmatch(name))]
    if foreign := manifest.foreign(names):
        raise InputError(
            f"{folder} has files that a run would overwrite but that are not on the list of its "
            f"own ({MANIFEST}): {', '.join(foreign[:5])}; move them or choose another folder"
        )


class _Writer:
    """Writes the records of one run; what there is after ``rows`` is removed first."""

    def __init__(
        self, options: RunFolder, solver: Solver, task: Task, rows: Sequence[Row]
    ) -> None:
        folder = path_of(options.path)
        make_folder(folder, FRAMES)
        self._options, self._solver, self._folder = options, solver, folder
        self._records, self._until = len(rows), task.until
        # Read before the lock is ours: with it, a killed run would look alive.
        earlier = earlier_run(folder)
        self._lock = FolderLock(folder)
        try:
            self._begin(task, rows, earlier)
        except BaseException:
            self._lock.release()
            raise

    def _begin(self, task: Task, rows: Sequence[Row], earlier: dict[str, Any]) -> None:
        folder = self._folder
        self._manifest = manifest = Manifest(folder)
        kept = {_frame(k): row["time [s]"] for k, row in enumerate(rows)}
        self._frames = [
            (time, name) for name, time in kept.items()
            if name in manifest.names and (folder / name).exists()
        ]  # fmt: skip
        if rows:
            # The collection first: it must not name what is about to go.
            write_pvd(self._frames, manifest.add(PVD))
        else:
            manifest.remove(FIXED)
        manifest.remove(
            [name for name in sorted(manifest.names) if _FRAME.fullmatch(name) and name not in kept]
        )
        manifest.remove_parts()
        times = [row["time [s]"] for row in rows]
        self._hdf = VtkHdfFile(
            folder / VTKHDF,
            until_kept=times[-1] if times else None,
            expected=expected_records(
                times[-1] if times else self._solver.time, task.until, task.every,
                already=len(times),
            ),
        )  # fmt: skip
        self._history = HistoryFile(manifest.add(HISTORY), keep=len(rows))
        self._run = RunJson(manifest.add(RUN), self._solver, task, earlier=earlier)

    def write(self, snapshot: Snapshot, row: Row, *, last: bool) -> None:
        """Row, frame, collection, checkpoint, in this order."""
        index = self._records
        self._history.append(row)
        self._records += 1
        if self._options.frames.due(index, last=last):
            name = _frame(index)
            write_vtu(snapshot, self._manifest.add(name))
            self._frames.append((snapshot.time, name))
            write_pvd(self._frames, self._manifest.add(PVD))
        if self._options.vtkhdf.due(index, last=last):
            self._manifest.add(VTKHDF)
            self._hdf.append(snapshot)
        if self._options.checkpoints.due(index, last=last):
            write_checkpoint(
                self._solver,
                self._manifest.add(CHECKPOINT),
                records=self._records,
                until=self._until,
            )

    def close(self, failure: BaseException | None) -> None:
        """Say how the run ended."""
        try:
            self._history.close()
            self._hdf.close()
            self._run.end(failure, records=self._records)
        finally:
            self._lock.release()


def _frame(index: int) -> str:
    return f"{FRAMES}/frame_{index:06d}.vtu"
