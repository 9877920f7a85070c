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


def common_start(names: Sequence[str]) -> str:
    """What all names begin with, up to an underscore; empty for one name."""
    if len(names) < 2:
        return ""
    words = [name.split("_") for name in names]
    shared = 0
    while all(len(w) > shared + 1 and w[shared] == words[0][shared] for w in words):
        shared += 1
    return "_".join(words[0][:shared])
