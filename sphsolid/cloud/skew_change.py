"""The least skew-symmetric change with given row moments: the linear algebra of summation by parts.

Among skew ``A`` on a symmetric list of pairs, near to a skew ``A0``, with

    sum_b A_ab psi_i(a, b) = target_ai   exactly for i in {1, x, y, z}, in the mean for quadratics,

the minimiser of ``sum |A_ab - A0_ab|^2 / w_ab + sum_a |residual_a|^2 / (epsilon w)``, with the
residual of the quadratic moments, is

    A_ab = A0_ab + w_ab [ psi(a, b) . l_a - psi(b, a) . l_b ],

with ten multipliers a particle and the ten monomials ``psi(a, b)`` of ``(X_b - X_a) / scale_a``.
They solve one symmetric system, the same for the three components of the gradient.  Conjugate
gradients (``skew_preconditioner``) go as far as round-off lets them.  What an early stop would
leave differs with the unit of length, a mirror and the library.

Its null space are the quadratics (``s, grad s / 2``).  The right-hand side is orthogonal to them
where the areas integrate quadratics exactly (``boundary_weights``).  On a cylinder they cannot: all
particles of the wall lie on one quadric.  Its moment is zero with any areas, but over the facets it
is not.  That part of the right-hand side, 1e-5 of it, has no solution.  It would make the iteration
diverge, so it is taken out first and counted in what remains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sphsolid.cloud.skew_preconditioner import SkewPreconditioner
from sphsolid.cloud.skew_problem import SkewProblem, in_lanes
from sphsolid.cloud.slow_work import SlowWork
from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]
#: A residual that has grown this much says that there is no solution.
HOPELESS = 1.0e8
#: Iterations in which the residual must halve: ordinary clouds take 2 to 6 for that.
PATIENCE = 200


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
    problem: SkewProblem, right: Array, scale: float, tolerance: float, most_iterations: int
) -> tuple[Array, int, float]:
    """Multipliers, iterations and the largest entry left of ``right``, in ``scale``."""
    preconditioner = SkewPreconditioner(problem)
    residual = in_lanes(right)
    values, applied, z = (np.zeros_like(residual) for _ in range(3))
    largest, products = np.empty(len(residual)), np.empty((len(residual), 3))
    preconditioner(residual, z)
    direction = z.copy()
    rz = _total(residual, z, products)
    left = best = mark = 1.0
    marked = 0
    told = SlowWork("summation by parts")
    for iteration in range(most_iterations):
        if left < best:
            best = left
        if best <= 0.5 * mark:
            mark, marked = best, iteration
        # What does not go down any more will not, for the next thousands of iterations either.
        if left <= tolerance or not left <= HOPELESS or iteration - marked > PATIENCE:
            break
        told.at(f"iteration {iteration}, {left:.0e} of the rows left, to go on to {tolerance:.0e}")
        problem.apply(direction, applied)
        curvature = _total(direction, applied, products)
        step = np.divide(rz, curvature, out=np.zeros(3), where=curvature > 0.0)
        _advance(step, direction, applied, values, residual, largest)
        left = float(np.max(largest)) / scale
        preconditioner(residual, z)
        fresh = _total(residual, z, products)
        _turn(np.divide(fresh, rz, out=np.zeros(3), where=rz > 0.0), z, direction)
        rz = fresh
    else:
        iteration = most_iterations
    told.over()
    return values[:, :, :3], iteration, left


def _total(f: Array, g: Array, products: Array) -> Array:
    """``sum_ai f_aic g_aic (3,)``."""
    _products(f, g, products)
    return np.asarray(products.sum(axis=0))


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
