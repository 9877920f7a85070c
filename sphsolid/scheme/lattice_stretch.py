"""The smallest stretch of every particle of a tile, cheap enough to be asked for at every step."""

from __future__ import annotations

import math

from sphsolid.compiled import inlined
from sphsolid.continuum.tensor import determinant, right_cauchy_green
from sphsolid.continuum.wave_speed import step_share
from sphsolid.scheme.lattice_sums import tensor_at

#: ``2 cos(2/3 arccos h)`` for ``0 <= h <= 1`` to 2e-10, interpolated at Chebyshev points.
_ROOT = (
    1.0000000001621616, 1.154700499000072, -0.22222061950088498, 0.1068908857319874,
    -0.06562606259560058, 0.044639818977218096, -0.03055997630706935, 0.01875626144556009,
    -0.008970589160691654, 0.00280497478987937, -0.00041519263124262744,
)  # fmt: skip


@inlined
def least_stretch(F):  # type: ignore[no-untyped-def]
    """``continuum.wave_speed.smallest_stretch`` to nine digits, without its divisions.

    The least root of ``x^3 - 3 x = 2 r`` is ``-2 cos(2/3 arccos h)``, ``h = sqrt((1 - r) / 2)``,
    and that is a smooth function of ``h``.
    """
    c00, c11, c22, c01, c02, c12 = right_cauchy_green(F)
    mean = (c00 + c11 + c22) * (1.0 / 3.0)
    d0, d1, d2 = c00 - mean, c11 - mean, c22 - mean
    u, v, w = c01 * c01, c02 * c02, c12 * c12
    d = math.sqrt((d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * (u + v + w)) * (1.0 / 6.0))
    det = d0 * (d1 * d2 - w) - d1 * v - d2 * u + 2.0 * (c01 * c02 * c12)
    # A multiple of the identity has d = 0, and any root will do.
    r = det / (2.0 * d * d * d + 1.0e-300)
    r = 1.0 if r > 1.0 else r
    r = -1.0 if r < -1.0 else r
    h = math.sqrt(0.5 * (1.0 - r))
    a, h2 = _ROOT, h * h
    h4 = h2 * h2
    low = (a[0] + a[1] * h) + (a[2] + a[3] * h) * h2
    middle = (a[4] + a[5] * h) + (a[6] + a[7] * h) * h2
    high = (a[8] + a[9] * h) + a[10] * h2
    least = mean - d * (low + (middle + high * h4) * h4)
    return math.sqrt(least) if least > 0.0 else 0.0 * least


@inlined
def mark(S, q, tile, limit):  # type: ignore[no-untyped-def]
    """``step_share`` of nine scratch rows of ``F``; -1 where ``det F <= 0``, -2 where no number."""
    for k in range(tile.count):
        F = tensor_at(S, q + k)
        J = determinant(F)
        stretch = least_stretch(F)
        total = stretch + J
        valid = step_share(stretch, J) if J > 0.0 else -1.0
        limit[tile.at + k] = valid if total - total == 0.0 else -2.0
