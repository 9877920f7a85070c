"""What makes the system of ``skew_change`` easy: smoothing by blocks around a coarse solution.

At long wave lengths the system acts like a sixth-order operator.  One application is a step of two
grids.  A few steps of Chebyshev's iteration with the inverse diagonal blocks take out what varies
from particle to particle.  A solution on a coarse space of splines takes out what is smooth.  The
same steps once more take out what that has roughened.

It is symmetric and positive, as conjugate gradients want it, for two reasons.  The last steps are
the first ones in reverse.  No eigenvalue of the blocks' inverse times the matrix is above 2,
because

    sum_ab w [psi(a, b) . l_a - psi(b, a) . l_b]^2  <=  2 sum_ab w [psi(a, b) . l_a]^2 + ...,

the right side being twice the blocks' own form.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lanes import WIDTH, lanes_of, no_lanes, set_lanes
from sphsolid.cloud.skew_problem import TERMS, SkewProblem
from sphsolid.cloud.splines.coarse_solution import CoarseSolution
from sphsolid.cloud.splines.spline_matrix import skew_matrix
from sphsolid.cloud.splines.spline_space import coarse_splines
from sphsolid.compiled import kernel, prange

Array = NDArray[np.float64]
#: The coarse grid is this many spacings wide.  Finer takes fewer iterations, but the factor grows
#: with the fifth power of its functions along an axis: 125 MB on 33^3 particles.
COARSE_SPACINGS = 1.7
#: Small beside the sixth power of the longest wave number times that width.
SHIFT = 1.0e-9
#: Steps of the smoothing, and the part of the spectrum [2 / BAND, 2] that it takes out.
STEPS, BAND = 3, 60.0


class SkewPreconditioner:
    """``residual -> M residual``, both ``(N, 10, 4)``."""

    def __init__(self, problem: SkewProblem) -> None:
        blocks = problem.blocks()
        self._problem = problem
        self._inverse = np.linalg.inv(blocks)
        splines = coarse_splines(problem.X, COARSE_SPACINGS)
        matrix = skew_matrix(problem, splines, blocks)
        self._coarse = CoarseSolution(
            splines, matrix, splines.quadratics(), shift=SHIFT, dtype=np.float32
        )
        shape = (len(problem.X), TERMS, WIDTH)
        self._left, self._step = np.empty(shape), np.empty(shape)
        self._factors = chebyshev_factors(STEPS, BAND)

    def __call__(self, residual: Array, out: Array) -> None:
        """``out = M residual``."""
        left = self._left
        left[:] = residual
        out[:] = 0.0
        self._smooth(left, out)
        self._problem.reduce(self._step, left)
        correction = self._step
        correction[:] = 0.0
        self._coarse.add(left, correction)
        out += correction
        self._problem.reduce(correction, left)
        self._smooth(left, out)

    def _smooth(self, left: Array, values: Array) -> None:
        """Chebyshev's iteration for what is ``left``, added to ``values``.

        ``left`` follows, but for the last step, which stands in ``_step``.
        """
        for i, (keep, gain) in enumerate(self._factors):
            if i > 0:
                self._problem.reduce(self._step, left)
            _take_step(self._inverse, left, keep, gain, self._step, values)


def chebyshev_factors(steps: int, band: float) -> list[tuple[float, float]]:
    """``(keep, gain)`` of every step: ``step <- keep step + gain B^-1 left``.

    The polynomial of the eigenvalues in ``[2 / band, 2]`` that is smallest in the maximum norm.
    """
    middle, half = 1.0 + 1.0 / band, 1.0 - 1.0 / band
    ratio = middle / half
    rho = 1.0 / ratio
    factors = [(0.0, 1.0 / middle)]
    for _ in range(steps - 1):
        fresh = 1.0 / (2.0 * ratio - rho)
        factors.append((fresh * rho, 2.0 * fresh / half))
        rho = fresh
    return factors


@kernel
def _take_step(inverse, left, keep, gain, step, values):  # type: ignore[no-untyped-def]
    for a in prange(len(left)):
        for i in range(10):
            s = no_lanes()
            for j in range(10):
                s = s + inverse[a, i, j] * lanes_of(left, a, j)
            # In the first step there is nothing to keep, whatever stands there.
            s = gain * s
            if keep != 0.0:
                s = s + keep * lanes_of(step, a, i)
            set_lanes(step, a, i, s)
            set_lanes(values, a, i, lanes_of(values, a, i) + s)
