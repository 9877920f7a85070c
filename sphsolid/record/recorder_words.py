"""Recorders in words, by which a run that goes on knows those that it began with.

A recorder may be any object, with a memory of what it has seen.  Its words hold what it was made
with: not what its own methods write to, and no place in memory.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from types import FunctionType
from typing import Any

from sphsolid.errors import InputError
from sphsolid.record.class_text import changed_by_use
from sphsolid.record.plain import plain, text_words, words_of

_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def recorder_words(recorder: Any) -> str:
    """Class, parameters and what the class does; the same in another process."""
    try:
        return _ADDRESS.sub("", _words(recorder))
    except Exception:
        # What it is made of may do anything when it is looked at.
        return type(recorder).__qualname__


def _words(recorder: Any) -> str:
    kind: Any = type(recorder)
    if is_dataclass(recorder):
        parts = {one.name: getattr(recorder, one.name) for one in fields(recorder) if one.repr}
    elif kind.__repr__ is object.__repr__:
        parts = dict(getattr(recorder, "__dict__", {}))
    else:
        return words_of(recorder, text=text_words, other=_other)
    state = changed_by_use(kind)
    inside = [
        f"{name}={words_of(part, text=text_words, other=_other)}"
        for name, part in parts.items() if name not in state
    ]  # fmt: skip
    return f"{kind.__qualname__}({', '.join(inside)}){text_words(kind)}"


def _other(value: Any) -> str:
    if isinstance(value, FunctionType):
        return f"{value.__qualname__}{text_words(value)}"
    return plain(value)


def refuse_other_recorders(there: Sequence[str], here: Sequence[str], what: str) -> None:
    """Raise ``InputError`` where a recorder took the place of another of ``what``, the earlier run.

    One that is only added or left out shows in the columns, or has none.
    """
    gone, new = Counter(there) - Counter(here), Counter(here) - Counter(there)
    if gone and new:
        raise InputError(
            f"{what} was recorded by {', '.join(gone)}, not by {', '.join(new)}: one column would "
            "hold two things; go on with the same recorders, or start the run anew"
        )
