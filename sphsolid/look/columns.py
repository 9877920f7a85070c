"""Columns of histories: their names, units and families."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sphsolid.errors import InputError, nearest

#: What every row has, and nobody draws unless asked.
OWN = ("time [s]", "step")
_UNIT = re.compile(r"^(.*) \[([^\]]*)\]$")


def split(column: str) -> tuple[str, str]:
    """Name and unit of a column: ``tip_u_x [m]`` gives ``tip_u_x`` and ``m``."""
    found = _UNIT.match(column)
    return (found[1], found[2]) if found else (column, "")


def chosen(wanted: Sequence[str], known: Sequence[str]) -> list[str]:
    """Columns that ``wanted`` names in full or by how they begin; all but time and step if empty.

    Raises ``InputError`` for a name that is no column and begins none.
    """
    if not wanted:
        return [name for name in known if name not in OWN]
    found: list[str] = []
    for each in wanted:
        matching = [name for name in known if name == each] or [
            name for name in known if str(name).startswith(str(each))
        ]
        if not matching:
            raise InputError(
                f"the history has no column {each!r}{nearest(str(each), known)}; it has "
                f"{', '.join(map(repr, known))}"
            )
        found += [name for name in matching if name not in found]
    return found


def families(columns: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Columns by the unit that they share: ``(unit, columns)``, in the order of the first of each.

    Scales of a drift and shares of energy have the unit of what they belong to, so they stand with
    it.
    """
    found: dict[str, list[str]] = {}
    for column in columns:
        found.setdefault(split(column)[1], []).append(column)
    return list(found.items())


def shortened(names: Sequence[str]) -> tuple[str, list[str]]:
    """What all names share at their start and end, and what is left of each.

    ``tip_u_x, tip_u_y`` give ``tip_u`` and ``x, y``; one name is shared whole.
    """
    words = [name.split("_") for name in names]
    first = words[0]
    if len(names) < 2:
        return names[0], [""]
    start = end = 0
    while all(len(w) > start + 1 and w[start] == first[start] for w in words):
        start += 1
    while all(len(w) > start + end + 1 and w[-1 - end] == first[-1 - end] for w in words):
        end += 1
    shared = [*first[:start], *first[len(first) - end :]]
    return "_".join(shared), ["_".join(w[start : len(w) - end]) for w in words]
