"""``run.json``: what was run, by what, and how it ended."""

from __future__ import annotations

import datetime
import importlib.metadata
import json
import platform
from pathlib import Path
from typing import Any

from sphsolid.compiled import description
from sphsolid.errors import Diverged
from sphsolid.record.atomic import atomic
from sphsolid.record.output import Task
from sphsolid.record.solver import Solver

FORMAT = "sphsolid run 1"


class RunJson:
    """Says ``running`` from the start; a run that was killed says so for ever."""

    def __init__(self, path: Path, solver: Solver, task: Task) -> None:
        self._path = path
        self._solver = solver
        self._content: dict[str, Any] = {
            "format": FORMAT,
            "name": solver.name,
            "status": "running",
            "scene": solver.scene.name,
            "provenance": solver.scene.provenance,
            "plan": solver.plan().splitlines(),
            "identity": solver.identity(),
            "from_time_s": solver.time,
            "from_step": solver.step,
            "until_s": task.until,
            "every_s": task.every,
            "recorders": [repr(recorder) for recorder in task.record],
            "versions": {"sphsolid": _version(), "python": platform.python_version()}
            | description(),
            "started": _now(),
        }
        self._write()

    def end(self, failure: BaseException | None, *, records: int) -> None:
        """How the run ended; a lost solution with all that is known about it."""
        self._content |= {
            "status": _status(failure),
            "time_s": self._solver.time,
            "step": self._solver.step,
            "records": records,
            "positions": self._solver.positions.account(),
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
