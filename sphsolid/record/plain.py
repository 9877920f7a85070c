"""Options and parameters in words that are the same for equal values: 1, 1.0 and np.float64(1)."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from numbers import Real
from typing import Any


def plain(value: Any) -> str:
    """As ``repr``, but every number is written as a ``float``, also within objects and tuples."""
    if isinstance(value, bool):
        return repr(value)
    if isinstance(value, Real):
        try:
            return repr(float(value))
        except OverflowError:
            return repr(value)
    if isinstance(value, tuple | list):
        names = getattr(value, "_fields", None)
        if names is None:
            return "[" + ", ".join(plain(each) for each in value) + "]"
        # A law that a simulation keeps says the name of the class it was made from.
        kind = repr(value).partition("(")[0]
        return _object(kind, {name: getattr(value, name) for name in names})
    if is_dataclass(value) and not isinstance(value, type):
        parts = {each.name: getattr(value, each.name) for each in fields(value) if each.repr}
        return _object(type(value).__qualname__, parts)
    return repr(value)


def _object(kind: str, parts: dict[str, Any]) -> str:
    inside = ", ".join(f"{name}={plain(part)}" for name, part in parts.items())
    return f"{kind}({inside})"
