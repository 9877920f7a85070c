"""Checks that an object can do what its place asks for, whoever wrote its class."""

from __future__ import annotations

from collections.abc import Sequence

from sphsolid.errors import InputError


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
