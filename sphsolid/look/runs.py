"""What can be looked at: a simulation, a snapshot, a run's folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sphsolid.errors import InputError, require
from sphsolid.paths import path_of
from sphsolid.record.history import History, read_history
from sphsolid.record.run_folder import HISTORY, RunFolder
from sphsolid.record.run_json import read_run
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.stored import StoredSnapshot, frame_files, read_frame


@dataclass(frozen=True)
class Run:
    """The last state of a run and its history, which may be empty."""

    label: str
    snapshot: Snapshot | StoredSnapshot
    history: History


def run_of(given: Any) -> Run:
    """``given`` as a run; raises ``InputError`` for what is none."""
    if isinstance(given, Run):
        return given
    if isinstance(given, Snapshot | StoredSnapshot):
        return Run("snapshot", given, History.of([]))
    if isinstance(given, RunFolder):
        given = given.path
    if isinstance(given, str | Path):
        return run_in(path_of(given))
    require(
        not isinstance(given, History),
        "compare: a history has no body; give the simulation, or the folder of its run",
    )
    if callable(getattr(given, "snapshot", None)) and hasattr(given, "history"):
        return Run(given.name, given.snapshot(), given.history)
    raise InputError(
        f"compare: {given!r} is no run; give a simulation, a snapshot, or the folder of a run"
    )


def run_in(folder: Path) -> Run:
    """The last frame and the history of a folder that a run left."""
    frames = frame_files(folder)
    require(len(frames) > 0, f"{folder} has no frame to look at yet")
    last = read_frame(frames[-1][1])
    about = read_run(folder)
    table = folder / HISTORY
    history = read_history(table) if table.is_file() else History.of([])
    return Run(str(about.get("name", folder.name)), last, history)
