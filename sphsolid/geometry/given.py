"""Numbers that bodies are described with, refused in one sentence where they are none."""

from __future__ import annotations

from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.protocols import number

Array = NDArray[np.float64]
Triple = tuple[float, float, float]


def triple(what: str, value: object, unit: str) -> Triple:
    """Three finite numbers, along X, Y, Z, as floats; raises ``InputError`` for anything else."""
    try:
        if not isinstance(value, list | tuple | np.ndarray):
            raise TypeError
        x, y, z = (number(what, each) for each in value)
    except (TypeError, ValueError):  # an InputError of one of them is a ValueError
        raise InputError(
            f"{what} = {value!r} is not three finite numbers; give (X, Y, Z) in {unit}"
        ) from None
    return x, y, z


def disorder(jitter: object, seed: object) -> float:
    """The ``jitter``, checked; raises ``InputError`` for one outside [0, 0.9] and for a bad seed.

    ``seed`` is a whole number that is not negative.
    """
    share = number("jitter", jitter, "shares of the spacing")
    require(0.0 <= share <= 0.9, f"jitter = {jitter} is outside [0, 0.9] of the spacing")
    check_seed(seed)
    return share


def check_seed(seed: object) -> None:
    """Raises ``InputError`` unless ``seed`` is a whole number that is not negative."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise InputError(f"seed = {seed!r} is not a whole number from 0 on; give one such as 0")
