"""Places in a file by the numbers that the file itself gives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


class Numbering:
    """Numbers ``ids (n,)``, sorted once, so that each question costs a search and no more."""

    def __init__(self, ids: Indices, first: int = 0) -> None:
        """``first``: the place of the first of them."""
        self.ids = ids
        self.first = first
        self._order = np.argsort(ids, kind="stable")
        self._sorted = ids[self._order]

    def __len__(self) -> int:
        """How many numbers there are."""
        return len(self.ids)

    def twice(self) -> Indices:
        """Rows of the numbers that have been given before ``(k,)``, in their order."""
        again = self._sorted[1:] == self._sorted[:-1]
        return np.sort(self._order[1:][again])

    def find(self, wanted: Indices) -> Indices:
        """The place of each number, in the shape of ``wanted``; -1 where there is none."""
        if len(self.ids) == 0:
            return np.full(wanted.shape, -1)
        at = np.minimum(np.searchsorted(self._sorted, wanted), len(self.ids) - 1)
        return np.where(self._sorted[at] == wanted, self.first + self._order[at], -1)

    def between(self, low: int, high: int, step: int) -> Indices:
        """Places of those of ``low, low + step, ..., high`` that there are."""
        begin = np.searchsorted(self._sorted, low)
        end = np.searchsorted(self._sorted, high, side="right")
        chosen = (self._sorted[begin:end] - low) % step == 0
        return self.first + self._order[begin:end][chosen]
