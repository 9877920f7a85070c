"""An object as a pickle would hold it: a callable, its arguments, and a state."""

from __future__ import annotations

from typing import Any


def parts_of(thing: Any) -> list[Any]:
    """Callable, arguments, state, items and pairs; raises where there can be no pickle."""
    reduced = thing.__reduce_ex__(4)
    if isinstance(reduced, str):
        raise TypeError(f"{reduced} is a name only")
    make, arguments, *rest = reduced
    state, items, pairs = (*rest, None, None, None)[:3]
    return [make, tuple(arguments), state, list(items or ()), [tuple(pair) for pair in pairs or ()]]


def put_together(parts: list[Any]) -> Any:
    """The object that has these parts."""
    make, arguments, state, items, pairs = parts
    made = make(*arguments)
    if hasattr(made, "__setstate__") and state is not None:
        made.__setstate__(state)
    elif state is not None:
        named, slots = state if isinstance(state, tuple) and len(state) == 2 else (state, None)
        if named:
            vars(made).update(named)
        for name, value in (slots or {}).items():
            object.__setattr__(made, name, value)
    if items:
        made.extend(items)
    for key, value in pairs:
        made[key] = value
    return made
