"""From where a body is looked at when nobody says."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sphsolid.look.view import View, angled_view, flat_view

#: A body is thin where its least extent is less than this share of the next.
_THIN = 0.3
#: It is a column along Y where that is so many times its other extents.
_TALL = 1.5


def side_of(X: ArrayLike, *, up: str = "") -> View:
    """A view of a body with reference positions ``X (n, 3)`` [m]; ``up`` names an axis, x y z.

    Without ``up`` a thin body is seen along its least extent, and any other from the side and
    above, with Y pointing up where it is a column along Y, else Z.
    """
    if up:
        return angled_view(up=up)
    extent = np.ptp(np.asarray(X, dtype=float), axis=0)
    thin = int(np.argmin(extent))
    if extent[thin] < _THIN * np.sort(extent)[1]:
        right, upward = [("y", "z"), ("x", "z"), ("x", "y")][thin]
        return flat_view(right=right, up=upward)
    tall = extent[1] > _TALL * max(extent[0], extent[2])
    return angled_view(up="y" if tall else "z")
