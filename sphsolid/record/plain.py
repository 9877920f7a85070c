"""Options and parameters in words that are the same for equal values: 1, 1.0 and np.float64(1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from numbers import Real
from types import FunctionType
from typing import Any

import numpy as np

from sphsolid.record.array_words import array_words
from sphsolid.record.class_text import text_of


def plain(value: Any) -> str:
    """As ``repr``, but every number is written as a ``float``, also within objects and tuples.

    An array is known by all its bytes.  An object of a class outside the package is followed by a
    digest of what the class does (``class_text``), so that an edit of it makes other words.
    """
    return words_of(value, text=text_words, other=lambda each: repr(each) + text_words(type(each)))


def values_of(value: Any) -> str:
    """As :func:`plain`, without what classes do: for a law, which has a hash of its own."""
    return words_of(value, text=lambda kind: "", other=repr)


def words_of(value: Any, *, text: Callable[[type], str], other: Callable[[Any], str]) -> str:
    """``value`` in words: ``text`` follows the name of a class, ``other`` says what is no data."""

    def each(part: Any) -> str:
        return words_of(part, text=text, other=other)

    def object_of(kind: str, parts: Mapping[str, Any]) -> str:
        inside = ", ".join(f"{name}={each(part)}" for name, part in parts.items())
        return f"{kind}({inside}){text(type(value))}"

    if isinstance(value, bool | np.bool_):
        return repr(bool(value))
    if isinstance(value, Real):
        try:
            return repr(float(value))
        except OverflowError:
            return repr(value)
    if isinstance(value, np.ndarray):
        if value.dtype.hasobject:
            return f"array{value.shape} of {each(value.tolist())}"
        return array_words(value)
    if isinstance(value, tuple | list):
        names = getattr(value, "_fields", None)
        if names is None:
            return "[" + ", ".join(map(each, value)) + "]"
        # A law that a simulation keeps says the name of the class it was made from.
        kind = repr(value).partition("(")[0]
        return object_of(kind, {name: getattr(value, name) for name in names})
    if isinstance(value, Mapping):
        # Equal dicts may have another order.
        return "{" + ", ".join(sorted(f"{each(k)}: {each(v)}" for k, v in value.items())) + "}"
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(each, value))) + "}"
    if is_dataclass(value) and not isinstance(value, type):
        parts = {one.name: getattr(value, one.name) for one in fields(value) if one.repr}
        return object_of(type(value).__qualname__, parts)
    return other(value)


def text_words(made_by: type | FunctionType) -> str:
    """What to say behind the name of a class or function; nothing for one of the package."""
    digest = text_of(made_by)
    return f" of text {digest}" if digest else ""
