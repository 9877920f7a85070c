"""A filter along the lines of a box lattice that is symmetric in the volumes.

Along an axis with the norm ``H``, ``D`` the first difference and ``R = H^-1 D^T D / 4``, without
which 1/4, 1/2, 1/4 are left inside,

    order 1    S = I - R
    order 2    S = I - R^2, or I - H^-1 D_2^T D_2 / 16 with second differences ``D_2``

The two of order two are the same inside.  The second keeps linear functions at the ends too; the
first lets the ends of a line vary more freely, as bending wants.  ``h_i S_ij = h_j S_ji`` and
``S 1 = 1``.  The shortest wave is filtered out and no wave is turned round.  The axes commute, so
their product is symmetric in the products of the norms.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array, kron

from sphsolid.cloud.lattice.box import BoxLattice

Array = NDArray[np.float64]
#: Largest relative deviation of volumes from a product of three weights.
_PRODUCT = 1.0e-12


def rough_part(weight: Array, *, order: int, keeps_linear: bool) -> list[tuple[Array, Array]]:
    """``I - S`` of a line with norm ``weight (n,)`` as factors ``T D``, the last one first.

    None where the line has too few points.
    """
    n = len(weight)
    q = 2 if order == 2 and keeps_linear else 1
    if n <= max(order, q):
        return []
    D = np.diff(np.eye(n), n=q, axis=0)
    factor = 0.25**q * D.T / weight[:, None], D
    return [factor] if q == order else [factor] * order


def filter_matrix(weight: Array, *, order: int, keeps_linear: bool) -> Array:
    """``S (n, n)`` of a line; the identity where ``order`` is zero."""
    rough = np.eye(len(weight))
    factors = rough_part(weight, order=order, keeps_linear=keeps_linear) if order else []
    for T, D in factors:
        rough = T @ (D @ rough)
    return np.asarray(np.eye(len(weight)) - rough) if factors else rough


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
        self,
        box: BoxLattice,
        weights: tuple[Array, Array, Array],
        *,
        order: int,
        keeps_linear: bool,
    ) -> None:
        self.order, self.keeps_linear = order, keeps_linear
        line = box.number.ravel()
        place = csr_array((np.ones(line.size), (np.arange(line.size), line)))
        self._axes = [
            [
                _of_all_lines(factor, axis, box.counts, place)
                for factor in rough_part(weight, order=order, keeps_linear=keeps_linear)
            ]
            for axis, weight in enumerate(weights)
        ]

    def apply(self, f: Array, work: Array, out: Array) -> None:
        """``out = S f``, all ``(N,)`` and three different arrays; ``work`` is overwritten."""
        out[:] = f
        for factors in self._axes:
            if factors:
                work[:] = out
                for T, D in factors:
                    # Differences first: of a constant nothing is left, to the last bit.
                    work[:] = T @ (D @ work)
                out -= work

    @property
    def description(self) -> str:
        """Which filter it is."""
        kept = ", linear functions kept" if self.keeps_linear else ""
        return f"lines of the lattice, order {self.order}{kept}"


def _of_all_lines(
    factor: tuple[Array, Array], axis: int, counts: tuple[int, int, int], place: csr_array
) -> tuple[Any, Any]:
    """``T`` and ``D`` for the particles in their own numbering."""
    ones = [eye_array(n) for n in counts]

    def spread(matrix: Array) -> Any:
        parts: list[Any] = list(ones)
        parts[axis] = csr_array(matrix)
        return kron(kron(parts[0], parts[1]), parts[2])

    T, D = factor
    return csr_array(place.T @ spread(T)), csr_array(spread(D) @ place)
