"""The options of ``run``, refused in one sentence each where they are something else."""

from __future__ import annotations

import os
from collections.abc import Iterable

from sphsolid.errors import InputError
from sphsolid.record.recorders import Recorder
from sphsolid.scenes.checks import number


def check_times(until: object, every: object) -> None:
    """``until`` and ``every`` are numbers [s] or None."""
    for name, value in (("until", until), ("every", every)):
        if value is not None:
            number(name, value, "s")


def checked_recorders(record: object) -> tuple[Recorder, ...]:
    """The recorders as a tuple; raises ``InputError`` for a lone one, a class or anything else."""
    if hasattr(record, "record"):
        name = _name(record)
        raise InputError(f"record = {name} is one recorder; put it into a list: record=[{name}]")
    if isinstance(record, str) or not isinstance(record, Iterable):
        raise InputError(f"record = {record!r} is no list of recorders; for instance [Energy()]")
    found = tuple(record)
    for each in found:
        if isinstance(each, type):
            raise InputError(f"record holds the class {each.__name__}; write {each.__name__}()")
        if not callable(getattr(each, "record", None)):
            raise InputError(
                f"record holds {each!r}, which is no recorder; for instance [Energy(), "
                'Probe("tip")]'
            )
    return found


def _name(recorder: object) -> str:
    return f"{recorder.__name__}()" if isinstance(recorder, type) else repr(recorder)


def check_progress(progress: object) -> None:
    """``progress`` can be called, or is None."""
    if isinstance(progress, type) or (progress is not None and not callable(progress)):
        raise InputError(
            f"progress = {progress!r} is no object to be called; use ProgressLine() of "
            "sphsolid.record, or a function of one Progress"
        )


def check_output(output: object) -> None:
    """``output`` is a folder to write into, or nothing at all."""
    if isinstance(output, str | os.PathLike):
        raise InputError(f"output = {str(output)!r} is a path; use RunFolder({str(output)!r})")
    if isinstance(output, type) or not hasattr(output, "take_up"):
        raise InputError(f'output = {output!r} is not an option object; use RunFolder("out/run")')
