"""Checks that what is given can be what its place asks for: an object, its members, a number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from typing import TypeVar

from sphsolid.errors import InputError, require

Member = TypeVar("Member")


def check_protocol(what: str, value: object, members: Sequence[str], advice: str) -> None:
    """Raise ``InputError`` unless ``value`` is an object that has all ``members``.

    One sentence says what ``what`` is, what it lacks, and ``advice``.
    """
    if isinstance(value, type):
        raise InputError(f"{what} = {value!r} is a class; write {value.__name__}(), or {advice}")
    lacking = [name for name in members if not hasattr(value, name)]
    if lacking:
        missing = f"it has no {', '.join(lacking)}"
        raise InputError(f"{what} = {value!r} cannot be used: {missing}; {advice}")


def number(what: str, value: object, unit: str = "") -> float:
    """A finite real number of any type as a ``float``; raises ``InputError`` for anything else.

    ``unit`` is empty for a number without one.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(
            f"{what} = {value!r} is not a number" + (f"; give it in {unit}" if unit else "")
        )
    try:
        made = float(value)
    except OverflowError:
        made = math.inf
    require(math.isfinite(made), f"{what} = {value}{' ' if unit else ''}{unit} must be finite")
    return made


def one_of(what: str, value: object, allowed: Sequence[int]) -> int:
    """One of the ``allowed`` whole numbers, of any type, as an ``int``; else ``InputError``."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value not in allowed:
        listed = ", ".join(map(str, allowed[:-1]))
        raise InputError(f"{what} = {value!r} must be {listed} or {allowed[-1]}")
    return int(value)


def members(what: str, value: object, kind: type[Member]) -> tuple[Member, ...]:
    """A list or tuple of ``kind`` as a tuple; raises ``InputError`` for anything else."""
    name = kind.__name__
    if isinstance(value, kind):
        raise InputError(f"{what} is a lone {name}; put it into a tuple: {what}=({name}(...),)")
    if not isinstance(value, list | tuple):
        raise InputError(f"{what} = {value!r} is not a tuple of {name}(...)")
    for each in value:
        if not isinstance(each, kind):
            raise InputError(f"{what} holds {each!r}, which is no {name}; give {name}(...)")
    return tuple(value)
