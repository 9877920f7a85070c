"""A case: the unit of work of a study, and how one is run, stored and found again.

A case names its function by module path, because a worker process imports it afresh.  Its
outcome is kept in ``<out>/partial/<key>-<hash>.json``; the hash covers the function, its
arguments, the sources of the room it lives in and of both solvers.  So
a study that was killed goes on where it stopped, and a changed source runs again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import json
import os
import re
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sphsolid.compiled import source_hash
from sphsolid.errors import Diverged, InputError, require

ROOT = Path(__file__).resolve().parents[2]
Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One independent run.

    ``key`` names it in progress, failures and reports; ``run`` is ``"package.module:function"``
    and returns a list of rows (dictionaries of numbers and texts); ``arguments`` are its keyword
    arguments: numbers, texts, booleans, ``None``, lists and mappings of those; ``cost`` is its
    expected time in any unit, used for the order of work and the estimate of the time left.
    """

    key: str
    run: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    cost: float = 1.0

    def __post_init__(self) -> None:
        require(
            re.fullmatch(r"[\w.]+:\w+", self.run) is not None,
            f"case {self.key!r}: run = {self.run!r} is not of the form 'package.module:function'",
        )
        require(
            0.0 < self.cost < float("inf"),
            f"case {self.key!r}: cost = {self.cost} must be positive and finite",
        )

    def function(self) -> Callable[..., list[Row]]:
        """Import what ``run`` names."""
        module, name = self.run.split(":")
        return getattr(importlib.import_module(module), name)


@dataclass(frozen=True)
class Outcome:
    """What became of a case: its rows, or in ``failure`` the kind of error and its message.

    ``lost`` is True where the solution itself diverged: a result, the same every time.  Any
    other failure may be the machine's, so ``--resume`` tries it again.
    """

    key: str
    wall_s: float
    rows: list[Row] = field(default_factory=list)
    failure: str = ""
    message: str = ""
    lost: bool = False

    @property
    def failed(self) -> bool:
        """True when there are no rows because the case stopped."""
        return bool(self.failure)


def case_hash(case: Case) -> str:
    """Hash of everything that can change the rows of a case; raises ``InputError``."""
    try:
        arguments = json.dumps(dict(case.arguments), sort_keys=True)
    except TypeError as error:
        raise InputError(
            f"case {case.key!r}: arguments must be numbers, texts, lists and mappings, so that "
            f"they can be compared with those of a stored result ({error})"
        ) from error
    module = importlib.import_module(case.run.split(":")[0])
    # Its neighbours too: a study's cases lean on the other files of their room.
    room = Path(module.__file__).parent if module.__file__ else Path()
    source = b"".join(path.read_bytes() for path in sorted(room.glob("*.py")))
    digest = hashlib.sha256()
    for part in (case.run.encode(), arguments.encode(), source_hash().encode(), source):
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()[:16]


def partial_path(folder: Path, case: Case) -> Path:
    """Where the outcome of ``case`` is kept."""
    readable = re.sub(r"[^A-Za-z0-9.=+-]+", "_", case.key).strip("_")[:80]
    return folder / f"{readable}-{case_hash(case)}.json"


def write_atomically(path: Path, text: str) -> None:
    """Write so that a reader finds the old file or the whole new one, never a part."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def store(path: Path, outcome: Outcome) -> None:
    """Keep an outcome (floats with all digits)."""
    write_atomically(path, json.dumps(dataclasses.asdict(outcome), default=_plain))


def load(path: Path) -> Outcome | None:
    """A kept outcome, or ``None`` where there is none that can be read."""
    try:
        return Outcome(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def execute(case: Case, path: Path | None = None) -> Outcome:
    """Run a case and keep what became of it; an error of the case is an outcome, not raised."""
    start = time.perf_counter()
    try:
        rows = case.function()(**case.arguments)
        outcome = Outcome(case.key, time.perf_counter() - start, rows)
        # Through text and back, so that fresh and resumed rows are the same objects.
        outcome = Outcome(**json.loads(json.dumps(dataclasses.asdict(outcome), default=_plain)))
    except Exception as error:
        outcome = Outcome(
            case.key,
            time.perf_counter() - start,
            failure=type(error).__name__,
            message=_without_paths(_describe(error)),
            lost=isinstance(error, Diverged),
        )
    if path is not None:
        store(path, outcome)
    return outcome


def _describe(error: Exception) -> str:
    """The message; where from too, unless the package itself worded it."""
    if isinstance(error, Diverged | InputError):
        return str(error)
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{error} ({Path(frame.filename).name}, line {frame.lineno}, in {frame.name})"


def _without_paths(text: str) -> str:
    """Reports are shared: take the folders of this machine out of a message."""
    return text.replace(f"{ROOT}{os.sep}", "").replace(str(Path.home()), "~")


def _plain(value: Any) -> Any:
    """Numpy scalars and arrays as plain numbers and lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a number, text, list or mapping")
