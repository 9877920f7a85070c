"""The least skew-symmetric change with given row moments: the linear algebra of summation by parts.

Among skew ``A`` on a symmetric list of pairs, near to a skew ``A0``, with

    sum_b A_ab psi_i(a, b) = target_ai   exactly for i in {1, x, y, z}, in the mean for quadratics,

the minimiser of ``sum |A_ab - A0_ab|^2 / w_ab + sum_a |rest_a|^2 / (epsilon w)``, ``rest`` what is
left of the quadratic moments, is

    A_ab = A0_ab + w_ab [ psi(a, b) . l_a - psi(b, a) . l_b ],

with ten multipliers a particle and the ten monomials ``psi(a, b)`` of ``(X_b - X_a) / scale_a``.
They solve one symmetric system, the same for the three components of the gradient.  In the long run
of wave lengths it acts like a sixth-order operator, so it is solved by conjugate gradients with two
preconditioners added up: the inverses of the diagonal blocks, and a solution on a coarse
space of splines, which holds what the blocks do not see.

Its null space are the quadratics (``s, grad s / 2``).  The right-hand side is orthogonal to them
where the areas integrate quadratics exactly (``boundary_weights``).  On a cylinder they cannot: all
particles of the wall lie on one quadric, whose moment is zero with any areas and is not over the
facets.  That part of the right-hand side, 1e-5 of it, has no solution; left in, it would make the
iteration diverge.  It is taken out first and counted in what remains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sphsolid.cloud.skew_problem import SkewProblem
from sphsolid.cloud.splines.coarse_solution import CoarseSolution
from sphsolid.cloud.splines.spline_matrix import skew_matrix
from sphsolid.cloud.splines.spline_space import coarse_splines
from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]
#: The coarse grid is this many spacings wide: with three the iterations rise by a quarter, with two
#: the coarse solution takes what they save.
COARSE_SPACINGS = 2.5
#: Small beside the sixth power of the longest wave number times that width.
SHIFT = 1.0e-9
#: A residual that has grown this much says that there is no solution.
HOPELESS = 1.0e8


@dataclass(frozen=True)
class Multipliers:
    """Solution ``values (N, 10, 3)``, iterations, and what is left of the right-hand side.

    ``unsolvable`` is the share of the right-hand side in the null space, part of ``remainder``.
    """

    values: Array
    iterations: int
    remainder: float
    unsolvable: float


def solve(
    problem: SkewProblem, right: Array, *, tolerance: float, most_iterations: int
) -> Multipliers:
    """Conjugate gradients until the residual's largest entry is ``tolerance`` of the first.

    Totals are plain numpy sums over particles, whose order does not depend on the number of
    threads.  BLAS gets one thread: its bits would depend on their number, and between two
    solutions its threads spin where those of the kernels wait, which doubles the time.
    """
    scale = float(np.max(np.abs(right)))
    if scale == 0.0:
        return Multipliers(np.zeros_like(right), 0, 0.0, 0.0)
    with threadpool_limits(limits=1, user_api="blas"):
        null = problem.null_space()
        outside = (null @ (null.T @ right.reshape(len(null), 3))).reshape(right.shape)
        unsolvable = float(np.max(np.abs(outside))) / scale
        values, iterations, left = _solve(
            problem, right - outside, scale, tolerance, most_iterations
        )
    return Multipliers(values, iterations, left + unsolvable, unsolvable)


def _solve(
    problem: SkewProblem, residual: Array, scale: float, tolerance: float, most_iterations: int
) -> tuple[Array, int, float]:
    """Multipliers, iterations and the largest entry left of ``residual``, in ``scale``."""
    preconditioner = _Preconditioner(problem)
    values, applied, z = (np.zeros_like(residual) for _ in range(3))
    largest, products = np.empty(len(residual)), np.empty((len(residual), 3))
    preconditioner(residual, z)
    direction = z.copy()
    rz = _total(residual, z, products)
    left = 1.0
    for iteration in range(most_iterations):
        if left <= tolerance or not left <= HOPELESS:
            return values, iteration, left
        problem.apply(direction, applied)
        curvature = _total(direction, applied, products)
        step = np.divide(rz, curvature, out=np.zeros(3), where=curvature > 0.0)
        _advance(step, direction, applied, values, residual, largest)
        left = float(np.max(largest)) / scale
        preconditioner(residual, z)
        fresh = _total(residual, z, products)
        _turn(np.divide(fresh, rz, out=np.zeros(3), where=rz > 0.0), z, direction)
        rz = fresh
    return values, most_iterations, left


def _total(f: Array, g: Array, products: Array) -> Array:
    """``sum_ai f_aic g_aic (3,)``."""
    _products(f, g, products)
    return np.asarray(products.sum(axis=0))


class _Preconditioner:
    """Inverse diagonal blocks plus the coarse solution."""

    def __init__(self, problem: SkewProblem) -> None:
        blocks = problem.blocks()
        self._inverse = np.linalg.inv(blocks)
        splines = coarse_splines(problem.X, problem.scale, COARSE_SPACINGS)
        matrix = skew_matrix(problem, splines, blocks)
        self._coarse = CoarseSolution(
            splines, matrix, splines.quadratics(), shift=SHIFT, dtype=np.float32
        )

    def __call__(self, residual: Array, out: Array) -> None:
        """``out = M^-1 residual  (N, 10, 3)``."""
        _times_blocks(self._inverse, residual, out)
        self._coarse.add(residual, out)


@kernel
def _products(f, g, out):  # type: ignore[no-untyped-def]
    for a in prange(len(f)):
        for c in range(3):
            total = 0.0
            for i in range(10):
                total += f[a, i, c] * g[a, i, c]
            out[a, c] = total


@kernel
def _advance(step, direction, applied, values, residual, largest):  # type: ignore[no-untyped-def]
    for a in prange(len(values)):
        most = 0.0
        for i in range(10):
            for c in range(3):
                values[a, i, c] += step[c] * direction[a, i, c]
                rest = residual[a, i, c] - step[c] * applied[a, i, c]
                residual[a, i, c] = rest
                # A comparison that is false for what is not a number must not lose it.
                most = most if abs(rest) <= most else abs(rest)
        largest[a] = most


@kernel
def _turn(factor, z, direction):  # type: ignore[no-untyped-def]
    for a in prange(len(z)):
        for i in range(10):
            for c in range(3):
                direction[a, i, c] = z[a, i, c] + factor[c] * direction[a, i, c]


@kernel
def _times_blocks(inverse, z, out):  # type: ignore[no-untyped-def]
    for a in prange(len(z)):
        for i in range(10):
            t0 = 0.0
            t1 = 0.0
            t2 = 0.0
            for j in range(10):
                t0 += inverse[a, i, j] * z[a, j, 0]
                t1 += inverse[a, i, j] * z[a, j, 1]
                t2 += inverse[a, i, j] * z[a, j, 2]
            out[a, i, 0] = t0
            out[a, i, 1] = t1
            out[a, i, 2] = t2
