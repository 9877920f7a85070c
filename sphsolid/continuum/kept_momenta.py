"""What rates must gain so that a body moves nothing by itself: least squares over the volumes.

The a-posteriori projection of [Lee2016]: among all ``c`` with a given resultant and moment, the one
of least ``sum V |c|^2`` is

    c_a = R / V + lambda x y_a,    I lambda = T,

with ``V = sum V_a``, ``y`` the positions from their centroid and ``I = sum V (|y|^2 1 - y (x) y)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def moment_correction(V: Array, x: Array, moment: Array) -> Array:
    """``c (N, 3)`` [N/m^3] without a resultant, of ``moment (3,)`` [N m].

    ``V (N,)`` [m^3] and ``x (N, 3)`` [m].
    """
    y = x - (V @ x) / float(np.sum(V))
    second = (V[:, None] * y).T @ y
    inertia = np.trace(second) * np.eye(3) - second
    return np.asarray(np.cross(np.linalg.solve(inertia, moment), y))


def momentum_correction(V: Array, x: Array, rate: Array) -> Array:
    """``c (N, 3)`` [N/m^3], which takes resultant and moment out of ``rate (N, 3)`` [N/m^3].

    ``V (N,)`` [m^3] and ``x (N, 3)`` [m].  Exact for any ``rate``: what is left is round-off.
    """
    y = x - (V @ x) / float(np.sum(V))
    moment = np.cross(V[:, None] * y, rate).sum(axis=0)
    return moment_correction(V, x, -moment) - (V @ rate) / float(np.sum(V))
