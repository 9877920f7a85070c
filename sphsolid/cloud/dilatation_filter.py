"""The filter of a cloud that keeps constants and is symmetric in the volumes."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.lattice.box import BoxLattice, box_of
from sphsolid.cloud.lattice.line_filter import LineFilter, axis_weights
from sphsolid.cloud.linear_pair_filter import LinearPairFilter
from sphsolid.cloud.pair_filter import PairFilter

Array = NDArray[np.float64]


class DilatationFilter(Protocol):
    """``S`` with ``V_a S_ab = V_b S_ba`` and ``S 1 = 1``."""

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)`` and three different arrays; ``work`` is overwritten."""
        ...

    @property
    def description(self) -> str:
        """Which filter it is."""
        ...


def dilatation_filter(
    cloud: Cloud, *, order: int, width: float
) -> DilatationFilter:
    """Along the lines of a box lattice, over pairs elsewhere.

    Of ``order`` 1 it keeps constants, of 2 linear functions.  ``width`` is the reach over pairs in
    spacings.  Lines need volumes that are products of the axes' weights.
    """
    box = box_of(cloud.mesh)
    if isinstance(box, BoxLattice):
        weights = axis_weights(cloud.V, box)
        if weights is not None:
            return LineFilter(box, weights, order=order)
    return (PairFilter if order == 1 else LinearPairFilter)(cloud, width=width)
