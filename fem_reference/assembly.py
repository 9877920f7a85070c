"""Sum of element contributions at the nodes, in gather form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NodeIncidence:
    """For node ``a`` the rows ``entries[start[a]:start[a + 1]]`` of an ``(E * 8, 3)`` array.

    Row ``8 e + c`` is corner ``c`` of element ``e``.  Every node sums its own rows in a fixed
    order, so the bits do not depend on the number of threads.
    """

    start: NDArray[np.uint32]
    entries: NDArray[np.uint32]

    @classmethod
    def of(cls, cells: NDArray[np.uint32], nodes: int) -> NodeIncidence:
        """Incidence of ``cells (E, 8)`` on ``nodes`` nodes."""
        corners = cells.ravel()
        start = np.zeros(nodes + 1, dtype=np.uint32)
        np.cumsum(np.bincount(corners, minlength=nodes), out=start[1:])
        return cls(start, np.argsort(corners, kind="stable").astype(np.uint32))

    def gather(self, element_values: Array, nodal_values: Array) -> None:
        """``nodal_values (N, 3)`` = sum of the rows of ``element_values (E, 8, 3)`` at a node."""
        _gather(self.start, self.entries, element_values.reshape(-1, 3), nodal_values)


@kernel
def _gather(start, entries, element_values, nodal_values):  # type: ignore[no-untyped-def]
    for a in prange(nodal_values.shape[0]):
        x = 0.0
        y = 0.0
        z = 0.0
        for k in range(start[a], start[a + 1]):
            row = entries[k]
            x += element_values[row, 0]
            y += element_values[row, 1]
            z += element_values[row, 2]
        nodal_values[a, 0] = x
        nodal_values[a, 1] = y
        nodal_values[a, 2] = z
