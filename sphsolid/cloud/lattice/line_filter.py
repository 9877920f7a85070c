"""A filter along the lines of a box lattice that is symmetric in the volumes.

Along an axis whose volumes are ``dx h_i``, with ``D_q`` the ``q``-th difference,

    S = I - 4^-q H^-1 D_q^T D_q,        h_i S_ij = h_j S_ji,        S 1 = 1,

weights 1/4, 1/2, 1/4 inside for ``q = 1``.  That of ``q = 2`` leaves linear functions alone, the
boundary included.  The shortest wave is filtered out and no wave is turned round.  The three axes
commute, so their product is symmetric in the products of the norms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.box import BoxLattice
from sphsolid.compiled import inlined, kernel, prange, threads

Array = NDArray[np.float64]
U = np.uint64
#: Largest relative deviation of volumes from a product of three weights.
_PRODUCT = 1.0e-12


@inlined
def _curvature(f, at, stride):  # type: ignore[no-untyped-def]
    return (f[at + stride] - f[at]) - (f[at] - f[at - stride])


@inlined
def _rough(f, at, stride, i, n, order):  # type: ignore[no-untyped-def]
    """``(D_q^T D_q f)_i``; ``at`` is where point ``i`` of the line of ``n`` is."""
    total = 0.0
    if order == U(1):
        if i > U(0):
            total += f[at] - f[at - stride]
        if i + U(1) < n:
            total += f[at] - f[at + stride]
        return total
    if i > U(0) and i + U(1) < n:
        total -= 2.0 * _curvature(f, at, stride)
    if i > U(1):
        total += _curvature(f, at - stride, stride)
    if i + U(2) < n:
        total += _curvature(f, at + stride, stride)
    return total


@kernel
def _planes(number, share_y, share_z, order, counts, workers, f, out):  # type: ignore[no-untyped-def]
    """Particles to points, filtered along Z and Y."""
    nx, ny, nz = counts
    for t in prange(workers):
        plane, along = np.empty(ny * nz), np.empty(ny * nz)
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            first = i * ny * nz
            for at in range(ny * nz):
                plane[at] = f[number[first + at]]
            for j in range(ny):
                for k in range(nz):
                    at = j * nz + k
                    along[at] = plane[at] - share_z[k] * _rough(plane, at, U(1), k, nz, order)
            for j in range(ny):
                share = share_y[j]
                for k in range(nz):
                    at = j * nz + k
                    out[first + at] = along[at] - share * _rough(along, at, nz, j, ny, order)


@kernel
def _across(number, share_x, order, counts, workers, f, out):  # type: ignore[no-untyped-def]
    """Filtered along X, points to particles."""
    nx, ny, nz = counts
    for t in prange(workers):
        for i in range(U(t) * nx // U(workers), (U(t) + U(1)) * nx // U(workers)):
            first, share = i * ny * nz, share_x[i]
            for at in range(first, first + ny * nz):
                out[number[at]] = f[at] - share * _rough(f, at, ny * nz, i, nx, order)


def axis_weights(V: Array, box: BoxLattice) -> tuple[Array, Array, Array] | None:
    """``h_i`` of the three axes, ``sum h = n - 1``, or None where ``V (N,)`` is no product."""
    grid = V[box.number]
    total = float(np.sum(grid))
    hx, hy, hz = (
        (n - 1) / total * grid.sum(axis=tuple({0, 1, 2} - {axis}))
        for axis, n in enumerate(box.counts)
    )
    product = float(np.prod(box.dx)) * hx[:, None, None] * hy[:, None] * hz
    if np.max(np.abs(grid - product)) > _PRODUCT * np.max(grid):
        return None
    return hx, hy, hz


class LineFilter:
    """``S`` of ``order`` 1 or 2 along all axes, applied ``times`` times; see the module."""

    def __init__(
        self, box: BoxLattice, weights: tuple[Array, Array, Array], *, order: int, times: int
    ) -> None:
        self.order, self.times = order, times
        self._number = box.number.ravel().astype(np.uint64)
        self._counts = tuple(np.uint64(n) for n in box.counts)
        # A line that is too short for the difference stays as it is.
        self._shares = tuple(
            0.25**order / h if len(h) > order else np.zeros(len(h)) for h in weights
        )

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)``; ``work`` is overwritten, ``out`` may be ``f``."""
        x, y, z = self._shares
        order, workers = np.uint64(self.order), threads()
        for _ in range(self.times):
            _planes(self._number, y, z, order, self._counts, workers, f, work)
            _across(self._number, x, order, self._counts, workers, work, out)
            f = out

    @property
    def description(self) -> str:
        """Which filter it is."""
        times = {1: "once", 2: "twice"}.get(self.times, f"{self.times} times")
        return f"lines of the lattice, order {self.order}, {times}"
