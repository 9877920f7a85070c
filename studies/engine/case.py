"""A case: the unit of work of a study, and how one is run, stored and found again.

The outcome of a case is kept in ``<out>/partial/<key>-<hash>.json``.  The hash covers the function,
its arguments, the sources of both solvers and what the function reaches of those of the study.  So
a study that was killed goes on where it stopped, and what a change can alter runs again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import json
import os
import re
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sphsolid.errors import Diverged, InputError, require
from sphsolid.record.plain import plain
from studies.engine.sources import ROOT, hash_of_sources, real_name

Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One independent run.

    ``key`` names it in progress, failures and reports.  ``run`` is a function of a module, which
    a worker process imports; it returns a list of rows (dictionaries of numbers and texts).
    ``arguments`` are its keyword arguments: plain values and option objects, told apart by their
    ``repr``.  ``cost`` is the expected time in any unit, used for the order of work and the
    estimate of the time left.
    """

    key: str
    run: Callable[..., list[Row]]
    arguments: Mapping[str, Any] = field(default_factory=dict)
    cost: float = 1.0

    def __post_init__(self) -> None:
        named = inspect.isfunction(self.run) and self.run.__qualname__ == self.run.__name__
        require(
            named and self.run.__name__ != "<lambda>",
            f"case {self.key!r}: run = {self.run!r} must be a function of a module, so that a "
            "worker process can import it",
        )
        require(
            0.0 < self.cost < float("inf"),
            f"case {self.key!r}: cost = {self.cost} must be positive and finite",
        )


@dataclass(frozen=True)
class Outcome:
    """What became of a case: its rows, or in ``failure`` the kind of error and its message.

    ``diverged`` is True where the solution itself diverged: a result, the same every time.  Any
    other failure may be the machine's, so ``--resume`` tries it again.  ``sampled``: the rows are
    of older sources, and another case of its sequence gave the same rows since.  ``older_times``:
    the times in the rows are of older sources.
    """

    key: str
    wall_s: float
    rows: list[Row] = field(default_factory=list)
    failure: str = ""
    message: str = ""
    diverged: bool = False
    sampled: bool = False
    older_times: bool = False

    @property
    def failed(self) -> bool:
        """True when there are no rows because the case stopped."""
        return bool(self.failure)


def case_hash(case: Case) -> str:
    """Hash of everything that can change the rows of a case; raises ``InputError``."""
    words = {name: plain(value) for name, value in sorted(case.arguments.items())}
    for name, text in words.items():
        require(
            re.search(r" at 0x[0-9a-f]+>", text) is None,
            f"case {case.key!r}: argument {name} = {text} has no value that can be compared with "
            "that of a stored result; use numbers, texts, option objects and lists of those",
        )
    name = f"{real_name(case.run.__module__)}:{case.run.__qualname__}"
    kinds = sorted(_kinds(case.arguments), key=repr)
    digest = hashlib.sha256()
    for part in (name, repr(words), hash_of_sources(case.run, *kinds)):
        digest.update(hashlib.sha256(part.encode()).digest())
    return digest.hexdigest()[:16]


def _kinds(value: Any) -> set[type]:
    """Classes of the option objects in an argument: what they do is part of a case too."""
    if isinstance(value, Mapping):
        return set().union(*map(_kinds, value.values()))
    if isinstance(value, list | tuple):
        return set().union(*map(_kinds, value))
    if not dataclasses.is_dataclass(value):
        return set()
    parts = (getattr(value, each.name) for each in dataclasses.fields(value))
    return {type(value)}.union(*map(_kinds, parts))


def partial_path(folder: Path, case: Case) -> Path:
    """Where the outcome of ``case`` is kept."""
    readable = re.sub(r"[^A-Za-z0-9.=+-]+", "_", case.key).strip("_")[:80]
    return folder / f"{readable}-{case_hash(case)}.json"


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write so that a reader finds the old file or the whole new one, never a part."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def store(path: Path, outcome: Outcome) -> None:
    """Keep an outcome (floats with all digits)."""
    write_atomically(path, json.dumps(dataclasses.asdict(outcome), default=_as_json))


def load(path: Path) -> Outcome | None:
    """A kept outcome, or ``None`` where there is none that can be read."""
    try:
        return Outcome(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def execute(case: Case) -> Outcome:
    """Run a case; an error of the case is an outcome, not raised."""
    start = time.perf_counter()
    try:
        rows = case.run(**case.arguments)
        require(
            isinstance(rows, list) and all(isinstance(row, dict) for row in rows),
            f"{case.run.__name__} must return a list of rows (dictionaries), got "
            f"{type(rows).__name__}",
        )
        outcome = Outcome(case.key, time.perf_counter() - start, rows)
        # Through text and back, so that fresh and resumed rows are the same objects.
        return Outcome(**json.loads(json.dumps(dataclasses.asdict(outcome), default=_as_json)))
    except Exception as error:
        return Outcome(
            case.key,
            time.perf_counter() - start,
            failure=type(error).__name__,
            message=_without_paths(_describe(error)),
            diverged=isinstance(error, Diverged),
        )


def _describe(error: Exception) -> str:
    """The message; where from too, unless the package itself worded it."""
    if isinstance(error, Diverged | InputError):
        return str(error)
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{error} ({Path(frame.filename).name}, line {frame.lineno}, in {frame.name})"


def _without_paths(text: str) -> str:
    """Reports are shared: take the folders of this machine out of a message."""
    return text.replace(f"{ROOT}{os.sep}", "").replace(str(Path.home()), "~")


def _as_json(value: Any) -> Any:
    """Numpy scalars and arrays as plain numbers and lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a number, text, list or mapping")
