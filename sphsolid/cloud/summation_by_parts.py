"""A gradient that sums by parts with its own negative transpose, on any cloud.

With ``C^d_ab = V_a G^d_b(X_a)`` a pair sums by parts when

    C + C^T = B = diag(A_a N_a),      C 1 = 0,      C^d X_e = delta_de V,

a discrete integration by parts with exact constants and linears.  It makes the force exact for
uniform *and* linear stress, while force and gradient stay each other's adjoint.  Second order on
disordered clouds needs this discrete form of the divergence theorem.  So ``C = A + B / 2`` with
``A`` skew, and ``A`` is the nearest one to the skew part of ``V G`` (``skew_change``).  Two things
decide how accurate the result is:

* ``B`` is lumped, with areas that integrate quadratics exactly (``boundary_weights``).  The
  consistent boundary mass, which comes to mind first, doubles the errors.
* ``A`` is the one of many that nearly reproduces quadratics, as far as ``epsilon`` lets it depart
  from ``V G`` for that.  Otherwise the gradient of a disordered cloud has an error ``O(dx)`` at
  every particle, and so has the stress.

The solver stops at a tolerance, small enough for one operator in every unit, mirror and library.
What it leaves of the rows is then removed row by row, and what that leaves of D0 by the least
change of ``consistent``.  So C0, C1 and D0 hold to round-off whatever the tolerance, and with them
conservation of momentum and the patch test.  ``C + C^T = B`` holds to the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.consistent import least_change
from sphsolid.cloud.gradient import offsets, row_sum
from sphsolid.cloud.pairs.neighbours import PairList, transposed
from sphsolid.cloud.pairs.parts import parts_of
from sphsolid.cloud.skew_change import Multipliers, solve
from sphsolid.cloud.skew_problem import SkewProblem
from sphsolid.errors import InputError

Array = NDArray[np.float64]
#: Least weight of a pair at the edge of the support, so that every pair can take part.
LEAST_SHARE = 1.0e-3
#: What the solver may leave of the row conditions, relative to what they were, before the pair is
#: refused.
MOST_LEFT = 1.0e-3
#: What may lie where there is no solution.  A cylinder's walls leave 1.5e-5 (``boundary_weights``),
#: volumes without the body's first moments 5e-3 and more.
MOST_UNSOLVABLE = 1.0e-3
_MOST_ITERATIONS = 3000


@dataclass(frozen=True)
class SkewGradient:
    """``G (P, 3)`` [1/m], iterations of the solver, remainder of its right-hand side."""

    G: Array
    iterations: int
    remainder: float


def skew_gradient(
    G: Array,
    pairs: PairList,
    X: Array,
    V: Array,
    areas: Array,
    scale: Array,
    share: Array,
    *,
    weight_exponent: float,
    epsilon: float,
    tolerance: float,
) -> SkewGradient:
    """The gradient nearest to ``G (P, 3)`` [1/m] that sums by parts with ``diag(areas)``.

    ``pairs`` symmetric, each particle its own neighbour; ``scale (N,)`` [m] local spacing;
    ``share (P,)`` the smoothing function of every pair over its peak.  Raises ``InputError`` where
    no such gradient exists: where the body is too thin for its support, and where volumes and areas
    do not have the moments of one body.

    Parts that share no pair are bodies by themselves: each has its own quadratics, which no
    condition determines, and is solved alone.
    """
    part = parts_of(pairs)
    options = {"weight_exponent": weight_exponent, "epsilon": epsilon, "tolerance": tolerance}
    made, iterations, remainder = np.empty_like(G), 0, 0.0
    for number in range(int(part.max()) + 1):
        mine = np.flatnonzero(part == number)
        own, place = _own_pairs(pairs, mine)
        found = _of_one_part(
            G[place], own, X[mine], V[mine], areas[mine], scale[mine], share[place], **options
        )
        made[place] = found.G
        iterations = max(iterations, found.iterations)
        remainder = max(remainder, found.remainder)
    return SkewGradient(made, iterations, remainder)


def _own_pairs(pairs: PairList, mine: NDArray[np.int64]) -> tuple[PairList, NDArray[np.int64]]:
    """The pairs of the particles ``mine``, renumbered, and where they stand in the list."""
    number = np.full(pairs.rows, -1, dtype=np.int64)
    number[mine] = np.arange(len(mine))
    place = np.flatnonzero(number[pairs.row_of_pair] >= 0)
    indptr = np.concatenate([[0], np.cumsum(np.diff(pairs.indptr)[mine])])
    return PairList(indptr, number[pairs.indices[place]].astype(np.uint32)), place


def _of_one_part(
    G: Array,
    pairs: PairList,
    X: Array,
    V: Array,
    areas: Array,
    scale: Array,
    share: Array,
    *,
    weight_exponent: float,
    epsilon: float,
    tolerance: float,
) -> SkewGradient:
    row = pairs.row_of_pair
    _, other = transposed(pairs, pairs.rows)
    C = V[row, None] * G
    half_B = np.zeros_like(C)
    half_B[pairs.indices == row] = 0.5 * areas
    skew = 0.5 * (C - C[other])
    spacing = float(np.mean(scale))
    unit = scale / spacing
    # Entries of A are areas: the change is small relative to them where spacings differ.
    size = (unit[row] * unit[pairs.indices]) ** 2
    weights = np.maximum(share, LEAST_SHARE) ** weight_exponent * size
    middle = 0.5 * (X.min(axis=0) + X.max(axis=0))
    problem = SkewProblem(pairs, (X - middle) / spacing, weights, epsilon * unit**8)
    target = np.zeros((pairs.rows, 10, 3))
    for d in range(3):
        target[:, 1 + d, d] = V / spacing
    right = target - problem.row_moments(skew + half_B)
    found = _solution(problem, right, tolerance)
    G = _gradient(problem, found, skew + half_B, target, X, V, areas, weights / size)
    return SkewGradient(G, found.iterations, found.remainder)


def _solution(problem: SkewProblem, right: Array, tolerance: float) -> Multipliers:
    found = solve(problem, right, tolerance=tolerance, most_iterations=_MOST_ITERATIONS)
    if not found.unsolvable <= MOST_UNSOLVABLE:
        raise InputError(
            "no gradient that sums by parts exists for these volumes and boundary areas: "
            "sum V grad s and sum A N s, equal for every quadratic s in a closed body, differ by "
            f"{found.unsolvable:.2g} of the row conditions, at most {MOST_UNSOLVABLE:.0e} is "
            "allowed; check that the boundary is closed and that volumes have the body's first "
            "moments, refine a curved boundary, or use operator = Consistent()"
        )
    if not found.remainder <= max(tolerance, MOST_LEFT):
        raise InputError(
            "no gradient that sums by parts was found: the row conditions are violated by "
            f"{found.remainder:.2g} of what they were after {found.iterations} iterations; the "
            "body is too thin for its support, or the support too small: raise h_over_dx, refine "
            "the spacing, or use operator = Consistent()"
        )
    return found


def _gradient(
    problem: SkewProblem,
    found: Multipliers,
    start: Array,
    target: Array,
    X: Array,
    V: Array,
    areas: Array,
    weights: Array,
) -> Array:
    """``G (P, 3)`` with exact rows and D0; raises ``InputError`` where D0 cannot be met."""
    pairs = problem.pairs
    C = start + problem.change(found.values)
    left = target[:, :4] - problem.row_moments(C)[:, :4]
    C += _row_correction(pairs, problem.X, problem.weights, left)
    G = C / V[pairs.row_of_pair, None]
    # What is left of D0 is as small as the tolerance: the least change takes it to round-off.
    G += least_change(G, pairs, X, V, areas, weights, coarse=True).D
    return np.asarray(G)


def _row_correction(pairs: PairList, X: Array, weights: Array, left: Array) -> Array:
    """``D_ab = w_ab psi . c_a`` with row moments ``left (N, 4, 3)``: local, and not skew."""
    row = pairs.row_of_pair
    d = offsets(X, X, pairs)
    psi = np.concatenate([np.ones((len(d), 1)), d], axis=1)
    moment = row_sum(pairs, weights[:, None, None] * psi[:, :, None] * psi[:, None, :])
    coefficient = np.linalg.solve(moment, left)
    return np.asarray(weights[:, None] * np.einsum("pi,pic->pc", psi, coefficient[row]))


def skewness_defect(G: Array, pairs: PairList, V: Array, areas: Array) -> float:
    """Largest entry of ``C + C^T - B`` over the largest area."""
    row = pairs.row_of_pair
    _, other = transposed(pairs, pairs.rows)
    C = V[row, None] * G
    defect = C + C[other]
    defect[pairs.indices == row] -= areas
    return float(np.max(np.abs(defect)) / np.max(np.linalg.norm(areas, axis=1)))
