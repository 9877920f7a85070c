"""``run.json``: what was run, by what, and how it ended."""

from __future__ import annotations

import datetime
import importlib.metadata
import json
import os
import platform
from pathlib import Path
from typing import Any

from sphsolid.compiled import description
from sphsolid.errors import Diverged, InputError
from sphsolid.paths import path_of
from sphsolid.record.atomic import atomic
from sphsolid.record.folder_lock import in_use
from sphsolid.record.output import Task
from sphsolid.record.solver import Solver

FORMAT = "sphsolid run 1"


NAME = "run.json"


def read_run(folder: str | Path) -> dict[str, Any]:
    """What ``run.json`` of a run's folder says; its ``status`` as it is now.

    ``running`` while a process writes there; ``complete``, ``interrupted``, ``diverged`` or
    ``failed`` as the run said at its end; ``killed`` when it could not say anything any more.
    Raises ``InputError`` for a folder without such a file.
    """
    path = path_of(folder) / NAME
    # The lock first: a run that ends in between has said how by the time the file is read.
    alive = in_use(path.parent)
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        status = found["status"]
    except FileNotFoundError:
        raise InputError(f"{path.parent} holds no run: there is no {NAME}") from None
    except (OSError, ValueError, TypeError, KeyError) as damage:
        raise InputError(f"{path} is not about a run, or is damaged ({damage!r})") from None
    if status == "running" and not alive:
        found["status"] = "killed"
    return dict(found)


def earlier_run(folder: Path) -> dict[str, Any]:
    """How the run that is already in ``folder`` ended, in short; empty where none says."""
    try:
        found = read_run(folder)
    except InputError:
        return {}
    kept = ("status", "started", "ended", "time_s", "records", "process")
    return {name: found[name] for name in kept if name in found}


def recorders_of(folder: Path) -> list[str]:
    """In words, what the run that is already in ``folder`` was recorded by; empty if unknown."""
    try:
        found = read_run(folder).get("recorded_by", [])
    except InputError:
        return []
    return [str(each) for each in found] if isinstance(found, list) else []


class RunJson:
    """Says ``running`` from the start; what a run that was killed leaves, see :func:`read_run`.

    ``earlier``: how the run ended that this one goes on with or replaces.
    """

    def __init__(
        self, path: Path, solver: Solver, task: Task, *, earlier: dict[str, Any]
    ) -> None:
        self._path = path
        self._solver = solver
        self._content: dict[str, Any] = {
            "format": FORMAT,
            "name": solver.name,
            "status": "running",
            "process": os.getpid(),
            "host": platform.node(),
            **({"earlier": earlier} if earlier else {}),
            "scene": solver.scene.name,
            "provenance": solver.scene.provenance,
            "plan": solver.plan().splitlines(),
            "identity": solver.identity(),
            "from_time_s": solver.time,
            "from_step": solver.step,
            "until_s": task.until,
            "every_s": task.every,
            "recorders": [repr(recorder) for recorder in task.record],
            "recorded_by": list(task.recorders),
            "versions": {"sphsolid": _version(), "python": platform.python_version()}
            | description(),
            "started": _now(),
        }
        self._write()

    def end(self, failure: BaseException | None, *, records: int) -> None:
        """How the run ended; a diverged solution with all that is known about it."""
        self._content |= {
            "status": _status(failure),
            "time_s": self._solver.time,
            "step": self._solver.step,
            "records": records,
            "positions": self._solver.positions.report(),
            "ended": _now(),
        }
        if isinstance(failure, Diverged):
            self._content["failure"] = {
                "reason": failure.reason,
                "time_s": failure.time,
                "step": failure.step,
                "particle": failure.particle,
                "X_m": list(failure.position),
                "advice": failure.advice,
            }
        elif failure is not None and str(failure):
            self._content["failure"] = {"reason": f"{type(failure).__name__}: {failure}"}
        self._write()

    def _write(self) -> None:
        with atomic(self._path) as part:
            part.write_text(json.dumps(self._content, indent=2) + "\n", encoding="utf-8")


def _status(failure: BaseException | None) -> str:
    if failure is None:
        return "complete"
    if isinstance(failure, KeyboardInterrupt):
        return "interrupted"
    return "diverged" if isinstance(failure, Diverged) else "failed"


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def _version() -> str:
    try:
        return importlib.metadata.version("sphsolid")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"
