"""Units of length that the numbers of a file can be in."""

from __future__ import annotations

import math

import numpy as np

from sphsolid.errors import InputError

Unit = str | float
_NUMBERS = (int, float, np.integer, np.floating)

#: Metres to a unit of length.
UNITS = {
    "m": 1.0,
    "dm": 1.0e-1,
    "cm": 1.0e-2,
    "mm": 1.0e-3,
    "um": 1.0e-6,
    "µm": 1.0e-6,  # micro sign
    "\N{GREEK SMALL LETTER MU}m": 1.0e-6,
    "nm": 1.0e-9,
    "in": 0.0254,
    "ft": 0.3048,
}
_SHOWN = "m, dm, cm, mm, um (or µm), nm, in, ft"
#: A body larger than this [m], in a file whose unit was not given, may be in millimetres.
LARGE = 5.0


def metres(unit: object, of: str) -> float:
    """Metres to a unit of ``of``, by its name or as a positive number of metres.

    Raises ``InputError`` for another name, or a number that is not positive and finite.
    """
    if isinstance(unit, str) and unit in UNITS:
        return UNITS[unit]
    if isinstance(unit, _NUMBERS) and unit is not True and 0.0 < float(unit) < math.inf:
        return float(unit)
    raise InputError(
        f"unit = {unit!r} of {of}: allowed are {_SHOWN}, or a positive number of metres"
    )


def unit_question(extent: tuple[float, float, float]) -> str:
    """What to ask of a body of ``extent`` [m] whose unit was not given: nothing, or one line.

    A mesh program writes millimetres as plain numbers, and read as metres they make a body that
    is a thousand times too large.  So one that is larger than ``LARGE`` is asked about.
    """
    if max(extent) <= LARGE:
        return ""
    size = " x ".join(f"{length:.4g}" for length in extent)
    return f"the body is {size} m; if the file is in millimetres say unit='mm' (--unit mm)"
