"""A filter along the lines of a box lattice that is symmetric in the volumes.

Along an axis with the norm ``H`` and the ``q``-th difference ``D_q``,

    order 1    S = I - H^-1 D_1^T D_1 / 4            keeps constants, 1/4, 1/2, 1/4 inside
    order 2    S = I - H^-1 D_3^T D_3 / 64           keeps quadratic functions

but that order 2 treats the four points at each end, and those between the ends, each on their own:
of the values at an end it keeps the quadratic function that is nearest in ``H``.  Rows of a
difference at a boundary are of lower order, so ``J`` is rough there, and a solid that is nearly
incompressible locks in bending if that is held.  Between the ends second differences would change
a quadratic function beside them, which costs a smooth pressure half an order and more.

Lines of less than eight points have no ends of their own, and second differences, which keep linear
functions.  Ends of three points that keep linear functions bend better still, but cost a smooth
pressure of large strain a digit.

``h_i S_ij = h_j S_ji``.  The shortest wave is filtered out.  No wave is turned round, but for a
small share at the ends with ``order=1`` and the norms of orders four and six.  The axes commute, so
their product is symmetric in the products of the norms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from sphsolid.cloud.lattice.box import BoxLattice

Array = NDArray[np.float64]
#: Largest relative deviation of volumes from a product of three weights.
_PRODUCT = 1.0e-12
#: Points of an end.
_END = 4


def rough_part(weight: Array, order: int) -> tuple[Array, Array]:
    """``T (n, m), D (m, n)``: what the filter of norm ``weight (n,)`` takes out is ``T D``.

    ``D`` are differences: nothing is left of a constant, to the last bit.
    """
    n = len(weight)
    if n <= order:
        return np.zeros((n, 0)), np.zeros((0, n))
    if order == 1 or n < 2 * _END:
        D = np.diff(np.eye(n), n=order, axis=0)
        return 0.25**order * D.T / weight[:, None], D
    third = np.diff(np.eye(n), n=3, axis=0)
    D = np.concatenate([third[[0, -1]], third[_END : n - _END - 3]])
    # One difference of four points: all but the nearest quadratic, if taken out whole.
    whole = 1.0 / np.sum(D[:2] ** 2 / weight, axis=1)
    share = np.concatenate([whole, np.full(len(D) - 2, 0.25**3)])
    return share * D.T / weight[:, None], D


def filter_matrix(weight: Array, order: int) -> Array:
    """``S (n, n)`` of a line; the identity where ``order`` is zero."""
    if order == 0:
        return np.eye(len(weight))
    T, D = rough_part(weight, order)
    return np.asarray(np.eye(len(weight)) - T @ D)


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
    """``S`` along all axes of one body; see the module.

    For any formulation; ``scheme.lattice_filter`` has it in kernels.
    """

    def __init__(
        self, box: BoxLattice, weights: tuple[Array, Array, Array], *, order: int
    ) -> None:
        self.order = order
        self._number = box.number
        self._axes = [
            (csr_array(T), csr_array(D))
            for T, D in (rough_part(weight, order) for weight in weights)
        ]

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)`` and three different arrays; ``work`` is overwritten."""
        grid = f[self._number]
        for axis, (T, D) in enumerate(self._axes):
            lines = np.moveaxis(grid, axis, 0)
            # Sums over one line in order, whatever the machine's matrix products do.
            rough = T @ (D @ lines.reshape(len(lines), -1))
            lines -= rough.reshape(lines.shape)
        out[self._number] = grid

    @property
    def description(self) -> str:
        """Which filter it is."""
        return f"lines of the lattice, order {self.order}"
