"""One run of a sweep: what a worker is given and what it hands back."""

from __future__ import annotations

import hashlib
import json
import time
import traceback
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from sphsolid.compiled import SOURCE_HASH, set_threads
from sphsolid.errors import Diverged, InputError
from sphsolid.record import History, NoOutput, RunFolder
from sphsolid.record.atomic import atomic
from sphsolid.shell.case import Setting, case_of
from sphsolid.shell.lines import spelled
from sphsolid.shell.settings import shown


@dataclass(frozen=True)
class Member:
    """The case ``text`` of ``file`` in ``folder`` with ``settings``; ``kept`` its run's folder.

    ``inputs`` are hashes of the files that the case names.
    """

    text: str
    file: str
    folder: str
    settings: tuple[Setting, ...]
    kept: str = ""
    inputs: tuple[str, ...] = ()
    sources: str = SOURCE_HASH

    @property
    def values(self) -> dict[str, str]:
        """The settings by name, as they were written."""
        return {spelled(each.place): shown(each.value) for each in self.settings}

    @property
    def key(self) -> str:
        """``material.poisson_ratio=0.3, spacing=1/4``."""
        return ", ".join(f"{name}={value}" for name, value in self.values.items()) or "as it is"

    @property
    def number(self) -> str:
        """A hash of all that can change its rows."""
        content = json.dumps([self.text, self.values, self.inputs, self.sources], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]


def hash_of(file: Path) -> str:
    """Of what a file holds; raises ``InputError`` where it cannot be read."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error}") from None


@dataclass(frozen=True)
class Outcome:
    """What became of a member: ``row`` of the table, columns of its ``history``, or why none."""

    status: str
    row: dict[str, Any] = field(default_factory=dict)
    history: dict[str, list[float]] = field(default_factory=dict)
    reason: str = ""
    wall_s: float = 0.0

    @property
    def is_final(self) -> bool:
        """False where the machine failed, not the case: it is tried again."""
        return self.status in ("complete", "diverged", "refused")


def run_member(member: Member) -> Outcome:
    """Run it, with one kernel thread; whatever goes wrong is an outcome, not raised."""
    if member.sources != SOURCE_HASH:
        return Outcome("failed", reason="the worker has other sources: restart the workers")
    set_threads(1)
    began = time.perf_counter()
    try:
        case = case_of(
            member.text, name=Path(member.file).stem, file=member.file,
            folder=Path(member.folder), settings=member.settings,
        )  # fmt: skip
        simulation = case.simulation()
    except InputError as refused:
        return Outcome("refused", reason=str(refused))
    output = RunFolder(member.kept, resume=True) if member.kept else NoOutput()
    status, reason = "complete", ""
    try:
        simulation.run(
            until=case.run.until, every=case.run.every, record=case.run.record, output=output
        )
    except Diverged as stop:
        status, reason = "diverged", str(stop)
    except InputError as refused:
        return Outcome("refused", reason=str(refused))
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(frame.filename).name}, line {frame.lineno}"
        return Outcome("failed", reason=f"{type(error).__name__}: {error} ({where})")
    wall = time.perf_counter() - began
    return Outcome(status, _row(simulation), _columns(simulation.history), reason, wall)


def _row(simulation: Any) -> dict[str, Any]:
    placement = simulation.placement()
    verdict = simulation.positions.look(placement)
    row: dict[str, Any] = {
        "points": len(placement.x),
        "steps": simulation.step,
        "positions": "folded" if verdict.folded else "sound",
    }
    table = simulation.history.table
    if len(table):
        row |= {str(name): float(table[name].iloc[-1]) for name in table if name != "step"}
    return row


def _columns(history: History) -> dict[str, list[float]]:
    return {str(name): history[str(name)].astype(float).tolist() for name in history.table}


def store(path: Path, outcome: Outcome) -> None:
    """Keep an outcome, floats with all digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic(path) as part:
        part.write_text(json.dumps(asdict(outcome)), encoding="utf-8")


def load(path: Path) -> Outcome | None:
    """A kept outcome that need not be made again, or ``None``."""
    try:
        found = Outcome(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
    return found if found.is_final else None
