"""The corrected gradient of the corrected kernel, [Lee2017] eq. (30) after [Bonet1999].

At a point ``X`` with Shepard sum ``S = sum V_b W_b`` and ``gamma = sum V_b grad W_b / S``,

    grad W~_b = (grad W_b - W_b gamma) / S,
    L = [ sum V_b grad W~_b (x) X_b ]^-1,
    G_b(X) = V_b L grad W~_b,

so that ``sum G_b = 0`` (C0) and ``sum G_b (x) X_b = I`` (C1).

A second reading of "gradient of the corrected kernel" differentiates the linear-corrected kernel
``W_b alpha [1 + beta . (X - X_b)]`` itself; with ``m = sum V_b W_b q q^T``, ``q = (1, X_b - X)``,
its gradient is ``V_b`` times the derivative of ``e_1 . m^-1 q W_b``.  It satisfies C0 and C1 too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.cloud.smoothing import SmoothingFunction

Array = NDArray[np.float64]


def row_sum(pairs: PairList, values: Array) -> Array:
    """Sum of pair values ``(P, ...)`` over each row ``(R, ...)``; every row must have a pair."""
    return np.add.reduceat(values, pairs.indptr[:-1], axis=0)


def offsets(points: Array, particles: Array, pairs: PairList) -> Array:
    """``X_b - X`` of every pair ``(P, 3)`` [m]."""
    return particles[pairs.indices] - points[pairs.row_of_pair]


def corrected_gradient(
    points: Array,
    particles: Array,
    volumes: Array,
    pairs: PairList,
    smoothing: SmoothingFunction,
    h: float | Array,
) -> Array:
    """``G_b(X) (P, 3)`` [1/m] of every pair.

    ``points (R, 3)``, ``particles (N, 3)`` [m], ``volumes (N,)`` [m^3], ``h`` [m], one
    length or one a pair.  The caller
    has checked that every row spans three dimensions (see ``support``).
    """
    row = pairs.row_of_pair
    d = offsets(points, particles, pairs)
    r = np.linalg.norm(d, axis=1)
    V = volumes[pairs.indices]
    W = smoothing.value(r, h)
    slope = smoothing.slope(r, h)
    # grad W_b(X) points from b to X, hence the minus; at r = 0 the slope is zero.
    grad = -d * (slope / np.where(r > 0.0, r, 1.0))[:, None]
    S = row_sum(pairs, V * W)
    gamma = row_sum(pairs, V[:, None] * grad) / S[:, None]
    shepard = (grad - W[:, None] * gamma[row]) / S[row, None]
    # X_b may be replaced by X_b - X because sum V_b grad W~_b = 0; this keeps the digits.
    moment = row_sum(pairs, V[:, None, None] * shepard[:, :, None] * d[:, None, :])
    L = np.linalg.inv(moment)
    return V[:, None] * np.einsum("pij,pj->pi", L[row], shepard)


def kernel_gradient(
    points: Array,
    particles: Array,
    volumes: Array,
    pairs: PairList,
    smoothing: SmoothingFunction,
    h: float | Array,
) -> Array:
    """``G_b(X) (P, 3)`` [1/m]: the corrected gradient of the kernel itself, [Randles1996].

    ``sum_b f_b (x) G_b = sum_b V_b (f_b - f_a) (x) L_a grad W_b`` with ``L_a`` such that linear
    fields are exact: what is usual in total-Lagrangian SPH.  ``points`` are the ``particles``.
    """
    row = pairs.row_of_pair
    d = offsets(points, particles, pairs)
    r = np.linalg.norm(d, axis=1)
    # d points from a to b, where the kernel falls.
    slope = smoothing.slope(r, h) / np.where(r > 0.0, r, 1.0)
    weighted = -(volumes[pairs.indices] * slope)[:, None] * d
    L = np.linalg.inv(row_sum(pairs, weighted[:, :, None] * d[:, None, :]))
    G = np.einsum("pij,pj->pi", L[row], weighted)
    G[pairs.indices == row] = -row_sum(pairs, G)
    return np.asarray(G)


def linear_kernel_gradient(
    points: Array,
    particles: Array,
    volumes: Array,
    pairs: PairList,
    smoothing: SmoothingFunction,
    h: float | Array,
) -> Array:
    """``G_b(X) (P, 3)`` [1/m]: analytic gradient of the linear-corrected kernel."""
    row = pairs.row_of_pair
    d = offsets(points, particles, pairs)
    r = np.linalg.norm(d, axis=1)
    V = volumes[pairs.indices]
    W = smoothing.value(r, h)
    grad = -d * (smoothing.slope(r, h) / np.where(r > 0.0, r, 1.0))[:, None]
    q = np.concatenate([np.ones((len(d), 1)), d], axis=1)
    qq = q[:, :, None] * q[:, None, :]
    m = row_sum(pairs, (V * W)[:, None, None] * qq)
    inverse = np.linalg.inv(m)
    first = inverse[:, 0, :]
    G = np.empty_like(d)
    for k in range(3):
        # d(q)/dX_k = -e_{k+1}; the derivative of the moment follows by the product rule.
        dq = np.zeros_like(q)
        dq[:, k + 1] = -1.0
        dqq = dq[:, :, None] * q[:, None, :] + q[:, :, None] * dq[:, None, :]
        dm = row_sum(pairs, (V * grad[:, k])[:, None, None] * qq + (V * W)[:, None, None] * dqq)
        dfirst = -np.einsum("ri,rij,rjk->rk", first, dm, inverse)
        G[:, k] = (
            np.einsum("pi,pi->p", dfirst[row], q) * W
            + np.einsum("pi,pi->p", first[row], dq) * W
            + np.einsum("pi,pi->p", first[row], q) * grad[:, k]
        )
    return V[:, None] * G


def linear_interpolation(
    points: Array,
    particles: Array,
    volumes: Array,
    pairs: PairList,
    smoothing: SmoothingFunction,
    h: float | Array,
) -> Array:
    """Weights ``V_b W~_b(X) (P,)`` of the linear-corrected kernel.

    ``f(X) = sum_b V_b W~_b(X) f_b`` reproduces constants and linears exactly ([Bonet1999]).
    """
    row = pairs.row_of_pair
    d = offsets(points, particles, pairs)
    VW = volumes[pairs.indices] * smoothing.value(np.linalg.norm(d, axis=1), h)
    q = np.concatenate([np.ones((len(d), 1)), d / np.mean(h)], axis=1)
    m = row_sum(pairs, VW[:, None, None] * q[:, :, None] * q[:, None, :])
    first = np.linalg.inv(m)[:, 0, :]
    return VW * np.einsum("pi,pi->p", first[row], q)
