"""The continuous dilatation of the Taylor-Hood element, from its moments at the corners.

With ``N_a`` the trilinear shapes of the corners, ``r_a = integral N_a (J - 1) dV`` and a symmetric
positive matrix ``A`` the volumetric energy ``U = kappa/2 (J - 1)^2`` is ``kappa/2 r . A r``;
``theta - 1 = A r`` are the dilatations at the corners, and ``U'(theta)``, interpolated, is the
pressure that makes the force the exact gradient, whatever ``A`` is (``taylor_hood_hex`` has any
other ``U``):

* ``ConsistentMass``: ``A = M^-1``, the L2 projection of ``J`` onto continuous Q1.  On a box of
  equal bricks ``M`` is a product of three tridiagonal matrices and is solved line by line; on any
  other mesh it is factorised once, for two serial triangular solves a step;
* ``LumpedMass(sweeps=m)``: ``A = sum_k<=m (I - D^-1 M)^k D^-1``, with ``D`` the row sums of ``M``:
  ``m`` Jacobi sweeps towards the projection.  Local and cheap on every mesh, but the boundary rows
  of ``D`` are only first order, and it shows: see :class:`LumpedMass`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from fem_reference.grid_mass import Grid, NoGrid
from sphsolid.compiled import kernel, prange
from sphsolid.errors import require

Array = NDArray[np.float64]
#: ``r (Nc,)`` [m^3] -> ``theta - 1 (Nc,)``.
Solve = Callable[[Array], Array]


class Dilatation(Protocol):
    """How the moments of ``J - 1`` become a continuous field."""

    def solver(self, mass: csr_matrix, grid: Grid | NoGrid) -> Solve:
        """Ready to apply ``A``, from the mass matrix ``M (Nc, Nc)`` [m^3] of the corners."""
        ...


@dataclass(frozen=True)
class ConsistentMass:
    """``A = M^-1``: the L2 projection."""

    def solver(self, mass: csr_matrix, grid: Grid | NoGrid) -> Solve:
        """Line by line on a grid; otherwise factorised once."""
        if isinstance(grid, Grid):
            return grid.solve
        symmetric = {"SymmetricMode": True}
        factors = splu(csc_matrix(mass), permc_spec="MMD_AT_PLUS_A", options=symmetric)
        return lambda moments: np.asarray(factors.solve(moments))


@dataclass(frozen=True)
class LumpedMass:
    """``A = sum_k<=sweeps (I - D^-1 M)^k D^-1``; raises ``InputError`` for ``sweeps < 0``.

    Where the volume changes its errors are those of trilinear elements: on the pressure waves of
    the swinging cube (A=B=C, 17 nodes an edge) five times those of :class:`ConsistentMass` with
    one sweep.  The stable step is 1.4 times as long.
    """

    sweeps: int = 1

    def __post_init__(self) -> None:
        require(
            isinstance(self.sweeps, int) and self.sweeps >= 0,
            f"sweeps = {self.sweeps!r} must be a whole number, 0 or more; 1 is enough",
        )

    def solver(self, mass: csr_matrix, grid: Grid | NoGrid) -> Solve:
        """Gather loops over the rows of ``M``."""
        row_sums = np.asarray(mass.sum(axis=1)).ravel()
        start, columns = mass.indptr.astype(np.uint32), mass.indices.astype(np.uint32)

        def solve(moments: Array) -> Array:
            theta = moments / row_sums
            for _ in range(self.sweeps):
                better = np.empty_like(theta)
                _sweep(start, columns, mass.data, row_sums, moments, theta, better)
                theta = better
            return theta

        return solve


@kernel
def _sweep(start, columns, entries, row_sums, moments, theta, better):  # type: ignore[no-untyped-def]
    """``better = theta + D^-1 (moments - M theta)``."""
    for a in prange(theta.shape[0]):
        residual = moments[a]
        for k in range(start[a], start[a + 1]):
            residual -= entries[k] * theta[columns[k]]
        better[a] = theta[a] + residual / row_sums[a]
