"""The operator of a box lattice: differences along its lines, anything else by sums over pairs.

The tables of pairs are made when they are asked for (``cloud.pair_tables``).  The displacement form
never asks: its forces, its deformation gradients and its energy budget are all taken along lines.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.lattice.box import BoxLattice, box_of
from sphsolid.cloud.lattice.lines import Grid, grid_of
from sphsolid.cloud.lattice_difference import LatticeDifference, has_lines
from sphsolid.compiled import inlined, kernel, prange
from sphsolid.fields import as_field, components
from sphsolid.scheme.lattice_sums import (
    STRIDE,
    U,
    divergence_across,
    divergence_in_plane,
    extent,
    gradient,
    make_tile,
    share,
)
from sphsolid.scheme.operator import Operator
from sphsolid.scheme.pair_sums import PairSums

Array = NDArray[np.float64]


#: Scratch rows: a tensor, or both parts of a divergence.
_ROWS, _ACROSS = 9, 3 * STRIDE


@inlined
def _gradient_in(t, along_x, along_y, along_z, f, factor, out, scratch):  # type: ignore[no-untyped-def]
    grid, S = Grid(along_x, along_y, along_z), scratch[t]
    first, last = share(t, len(scratch), grid.x.n)
    lines, width = extent(grid)
    for i in range(first, last):
        for j in range(U(0), grid.y.n, lines):
            for k0 in range(U(0), grid.z.n, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                gradient(f, grid, tile, S, U(0))
                for c in range(U(9)):
                    for k in range(tile.count):
                        out[c, tile.at + k] = factor * S[c * U(STRIDE) + k]


@kernel
def _gradient(along_x, along_y, along_z, f, factor, out, scratch):  # type: ignore[no-untyped-def]
    """``out = factor grad f  (9, .)`` of a vector field ``f (3, .)``."""
    for t in prange(len(scratch)):
        _gradient_in(U(t), along_x, along_y, along_z, f, factor, out, scratch)


@inlined
def _divergence_in(t, along_x, along_y, along_z, P, out, scratch):  # type: ignore[no-untyped-def]
    grid, S, step = Grid(along_x, along_y, along_z), scratch[t], U(3)
    first, last = share(t, len(scratch), grid.x.n)
    lines, width = extent(grid)
    for i in range(first, last):
        for j in range(U(0), grid.y.n, lines):
            for k0 in range(U(0), grid.z.n, width):
                tile = make_tile(grid, i, j, k0, lines, width)
                y, z = grid.y.column, grid.z.column
                divergence_in_plane(P, y, z, step, grid, tile, tile.at, S, U(0))
                divergence_across(P, grid.x.column, step, grid, tile, S, U(_ACROSS))
                for c in range(U(3)):
                    for k in range(tile.count):
                        q = c * U(STRIDE) + k
                        out[c, tile.at + k] = S[q] + S[U(_ACROSS) + q]


@kernel
def _divergence(along_x, along_y, along_z, P, out, scratch):  # type: ignore[no-untyped-def]
    """``DIV P  (3, .)`` with the free boundary, of a tensor field ``P (9, .)``."""
    for t in prange(len(scratch)):
        _divergence_in(U(t), along_x, along_y, along_z, P, out, scratch)


class LatticeSums(PairSums):
    """Keeps the protocol ``scheme.operator.Operator`` on the lines of ``box``."""

    def __init__(self, cloud: Cloud, kind: LatticeDifference, box: BoxLattice) -> None:
        super().__init__(cloud)
        self._grid = grid_of(kind.order, box, smoothing=0)
        self._rows = np.ones((numba.config.NUMBA_NUM_THREADS, _ROWS * STRIDE))

    def gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor (grad f)_a``; neither array need be a field."""
        if len(out) != self.size:
            # A kernel does not ask how long an array is.
            raise ValueError(f"room for {len(out)} particles where {self.size} are written")
        result = as_field(out)
        _gradient(
            *self._grid, self._read(as_field(f)), factor, components(result), self._rows
        )
        if result is not out:
            out[:] = result

    def force_gradient(self, f: Array, factor: float, out: Array) -> None:
        """The same: force and gradient are adjoint."""
        self.gradient(f, factor, out)

    def internal_force(self, P: Array, out: Array) -> None:
        """``out_a = (DIV P)_a`` [N/m^3] with the free boundary: minus the adjoint."""
        _divergence(*self._grid, self._read(P), components(out), self._rows)

    def _read(self, field: Array) -> Array:
        # What stands beside the last line is multiplied by zero, so it must be a number.
        rows = components(field)
        rows[:, self.size :] = 0.0
        return rows


def operator_on(cloud: Cloud) -> Operator:
    """The door to the sums on ``cloud``; a kind of operator may bring one of its own."""
    kind: Any = cloud.kind
    if hasattr(kind, "applied"):
        own: Operator = kind.applied(cloud)
        return own
    if has_lines(kind):
        box = box_of(cloud.mesh)
        if isinstance(box, BoxLattice) and box.is_ordered:
            return LatticeSums(cloud, kind, box)
    return PairSums(cloud)
