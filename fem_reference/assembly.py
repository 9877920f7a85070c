"""Sum of element contributions at the nodes, in gather form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.lanes import LANES
from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NodeIncidence:
    """Node ``a`` owns ``entries[start[a]:start[a + 1]]`` of the values of the elements.

    An entry is the place of the first component in ``(B, n C, LANES)``: row ``C c`` of a block for
    the element's node ``c`` with ``C`` components, which are ``LANES`` apart.  Every node sums its
    own entries in the order of the elements, so the bits do not depend on the number of threads.
    """

    start: NDArray[np.uint32]
    entries: NDArray[np.uint32]

    @classmethod
    def of(cls, cells: NDArray[np.uint32], nodes: int, components: int = 3) -> NodeIncidence:
        """Incidence of ``cells (E, n)`` on ``nodes`` nodes."""
        start = np.zeros(nodes + 1, dtype=np.uint32)
        np.cumsum(np.bincount(cells.ravel(), minlength=nodes), out=start[1:])
        element, corner = np.divmod(np.argsort(cells.ravel(), kind="stable"), cells.shape[1])
        block, lane = np.divmod(element, LANES)
        row = (block * cells.shape[1] + corner) * components
        return cls(start, (row * LANES + lane).astype(np.uint32))

    def gather(self, element_values: Array, nodal_values: Array) -> None:
        """``nodal_values (N, 3)`` = sums of the entries in ``element_values (B, 3 n, LANES)``."""
        _gather_vectors(self.start, self.entries, element_values.reshape(-1), nodal_values)

    def gather_scalars(self, element_values: Array, nodal_values: Array) -> None:
        """``nodal_values (N,)`` = sums of the entries in ``element_values (B, n, LANES)``."""
        _gather_scalars(self.start, self.entries, element_values.reshape(-1), nodal_values)


@kernel
def _gather_vectors(start, entries, element_values, nodal_values):  # type: ignore[no-untyped-def]
    for a in prange(nodal_values.shape[0]):
        x = 0.0
        y = 0.0
        z = 0.0
        for k in range(start[a], start[a + 1]):
            entry = np.uint64(entries[k])
            x += element_values[entry]
            y += element_values[entry + np.uint64(LANES)]
            z += element_values[entry + np.uint64(2 * LANES)]
        nodal_values[a, 0] = x
        nodal_values[a, 1] = y
        nodal_values[a, 2] = z


@kernel
def _gather_scalars(start, entries, element_values, nodal_values):  # type: ignore[no-untyped-def]
    for a in prange(nodal_values.shape[0]):
        total = 0.0
        for k in range(start[a], start[a + 1]):
            total += element_values[entries[k]]
        nodal_values[a] = total
