"""The options of ``run``, refused in one sentence each where they are something else."""

from __future__ import annotations

import inspect
import os
from collections.abc import Iterable, Mapping
from numbers import Real

import numpy as np

from sphsolid.errors import InputError
from sphsolid.record.history import Row
from sphsolid.record.recorders import Recorder
from sphsolid.scenes.checks import number

#: What every row of a history begins with.
OWN_COLUMNS = ("time [s]", "step")


def time_of(name: str, value: object) -> float | None:
    """``until`` or ``every``: any real number [s] as a ``float``, or None."""
    return None if value is None else number(name, value, "s")


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


def checked_row(recorder: object, made: object, row: Row) -> Row:
    """What ``recorder`` returned, as floats; raises ``InputError`` unless it is a dict of numbers.

    ``row``: the instant and its step, and the columns of the recorders before it.
    """
    def refused(text: str) -> InputError:
        # Asked only when needed: the repr of a recorder that keeps arrays is long.
        return InputError(f"recorder {recorder!r} {text}")

    if not isinstance(made, Mapping) or not all(isinstance(name, str) for name in made):
        raise refused(
            f"returned {_short(made)}; wanted is a dict of columns and numbers: "
            '{"mass [kg]": 1.0}'
        )
    found: Row = {}
    for name, value in made.items():
        if name in OWN_COLUMNS:
            raise refused(f"has a column {name!r}, which every row has; rename it")
        scalar = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
        if not isinstance(scalar, Real | np.bool_):
            raise refused(
                f"returned {_short(value)} for its column {name!r}; wanted is one number"
            )
        found[name] = float(scalar)
        before = row.get(name, found[name])
        agree = before == found[name] or np.isnan(before) or np.isnan(found[name])
        if not agree:
            raise refused(
                f"has a column {name!r}, as a recorder before it, with another number; rename one"
            )
    return found


def _short(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _name(recorder: object) -> str:
    return f"{recorder.__name__}()" if isinstance(recorder, type) else repr(recorder)


def check_progress(progress: object) -> None:
    """``progress`` can be called, or is None."""
    if isinstance(progress, type) or (progress is not None and not callable(progress)):
        raise InputError(
            f"progress = {progress!r} is no object to be called; use ProgressLine() of "
            "sphsolid.record, or a function of one Progress"
        )
    try:
        if progress is not None:
            inspect.signature(progress).bind(None)
    except TypeError as failure:
        raise InputError(
            f"progress = {progress!r} is called with one Progress: {failure}"
        ) from failure
    except ValueError:
        # A function of a library may not say what it takes.
        return


def check_output(output: object) -> None:
    """``output`` is a folder to write into, or nothing at all."""
    if isinstance(output, str | os.PathLike):
        raise InputError(f"output = {str(output)!r} is a path; use RunFolder({str(output)!r})")
    if isinstance(output, type) or not hasattr(output, "take_up"):
        raise InputError(f'output = {output!r} is not an option object; use RunFolder("out/run")')
