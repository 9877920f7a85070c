"""Where the instances of the parts of an Abaqus model stand."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_cards import Card
from sphsolid.geometry.abaqus_part import number

Array = NDArray[np.float64]


def moved(where: str, card: Card, points: Array) -> Array:
    """Points ``(n, 3)`` of a part at the place of its instance.

    The first line of data is a shift, the second a turn about the axis from ``a`` to ``b`` by an
    angle in degrees, which follows it:

        X' = a + cos (X - a) + sin n x (X - a) + (1 - cos) n (n . (X - a)),  n = (b - a)/|b - a|

    Raises ``InputError`` for other lines, or an axis without a direction.
    """
    try:
        rows = [[number(word) for word in row.removesuffix(",").split(",")] for row in card.data]
    except ValueError as error:
        raise InputError(f"{where}: its shift or turn cannot be read ({error})") from error
    if rows:
        rows[0] += [0.0] * (3 - len(rows[0]))  # what is left out at the end is zero
    require(
        len(rows) <= 2 and all(len(row) == size for row, size in zip(rows, (3, 7), strict=False)),
        f"{where}: its lines must be a shift of three numbers and a turn of seven, got {card.data}",
    )
    if rows:
        points = points + np.array(rows[0])
    if len(rows) < 2:
        return points
    a, b = np.array(rows[1][:3]), np.array(rows[1][3:6])
    angle = math.radians(rows[1][6])
    require(
        math.dist(a, b) > 0.0,
        f"{where}: the two points of the axis of its turn are one point {a.tolist()}",
    )
    n = (b - a) / math.dist(a, b)
    arm = points - a
    return np.asarray(
        a
        + math.cos(angle) * arm
        + math.sin(angle) * np.cross(n, arm)
        + (1.0 - math.cos(angle)) * np.outer(arm @ n, n)
    )
