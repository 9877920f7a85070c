"""Cells much longer than wide: a round support that serves their long edges holds far too many.

A support reaches second neighbours along every axis (see ``lengths``).  With edges ``a a r a`` it
then holds about ``40 r^2`` neighbours (``r = 1`` for a cube) and smooths over ``r`` cells sideways.
The gradient then has to change much before it sums by parts.
"""

from __future__ import annotations

import numpy as np

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.lengths import LONG, elongation

#: Change of the gradient, over the printed one, above which it is doubtful: one or two are common
#: on coarse disordered clouds, three on the flat cells around a hole.
LARGE_CHANGE = 5.0


def doubts(cloud: Cloud) -> list[str]:
    """What makes the operators of a cloud doubtful, one sentence each with the way out."""
    found = []
    ratio = elongation(cloud.mesh)
    if ratio > LONG:
        found.append(
            f"the longest edge of a cell is {ratio:.2g} times its shortest in the mean, and the "
            f"round support holds {cloud.mean_neighbours:.0f} neighbours: expect smeared "
            "results; mesh with edges within a factor of 2 of each other"
        )
    if not np.isfinite(cloud.change) or cloud.change > LARGE_CHANGE:
        found.append(
            f"the gradient differs from the printed one by {cloud.change:.2g} of it, up to "
            f"{LARGE_CHANGE:g} is usual where particles are disordered: expect poor stresses; mesh "
            "with cells of more even edges, or use operator = Consistent()"
        )
    return found
