"""Points in compact parts: halves of halves across the longest side.

Where numbers run along an axis, as on the lines of a grid, the parts are longer that way: what
belongs to points that follow one another is read from memory at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: How much longer.
_LONGER = 8.0


def compact_parts(points: Array, count: int) -> list[Indices]:
    """Numbers of ``points (N, 3)`` in ``count`` parts, as equal as can be, rising in each."""
    parts: list[Indices] = []
    scaled = points / _weights(points)

    def split(members: Indices, count: int) -> None:
        if count == 1:
            parts.append(np.sort(members))
            return
        own = scaled[members]
        axis = int(np.argmax(np.ptp(own, axis=0)))
        # Stable: equal coordinates are in the order of their numbers on every machine.
        order = np.argsort(own[:, axis], kind="stable")
        left = count // 2
        cut = len(members) * left // count
        split(members[order[:cut]], left)
        split(members[order[cut:]], count - left)

    split(np.arange(len(points)), min(count, len(points)))
    return parts


def _weights(points: Array) -> Array:
    """:data:`_LONGER` for the axis along which most numbers run, 1 for the others."""
    weights = np.ones(3)
    if len(points) > 1:
        step = np.median(np.abs(np.diff(points, axis=0)), axis=0)
        axis = int(np.argmax(step))
        if step[axis] > 2.0 * np.max(np.delete(step, axis)):
            weights[axis] = _LONGER
    return weights
