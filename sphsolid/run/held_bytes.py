"""What a simulation holds in memory: one rule for particles and elements, ours and a user's."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

#: Objects of these packages are machinery, not data of a run; so are those of the standard library.
_MACHINERY = frozenset({"numba", "llvmlite", "pandas"}) | sys.stdlib_module_names


def held_bytes(owner: Any) -> int:
    """Bytes of every array reachable from ``owner``, each once, views by what they are views of."""
    arrays: dict[int, int] = {}
    seen: set[int] = set()
    waiting = [owner]
    while waiting:
        value = waiting.pop()
        if isinstance(value, np.ndarray):
            while isinstance(value.base, np.ndarray):
                value = value.base
            arrays[id(value)] = value.nbytes
        elif id(value) not in seen:
            seen.add(id(value))
            waiting += _parts(value)
    return sum(arrays.values())


def _parts(value: Any) -> list[Any]:
    if isinstance(value, list | tuple | set | frozenset):
        return list(value)
    if isinstance(value, dict):
        return list(value.values())
    if isinstance(value, type) or type(value).__module__.split(".")[0] in _MACHINERY:
        return []
    return list(getattr(value, "__dict__", {}).values())
