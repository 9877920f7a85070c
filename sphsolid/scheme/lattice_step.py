"""A drift and the kick after it on a box lattice, in one launch (see ``drift_kick``).

Of a body of some hundred particles, what Python does between two kernels takes as long as a kernel.
The operations are those of ``DriftKick.drift`` and ``DriftKick.kick``, in their order, so the bits
are the same.  Forces alone are a launch that moves nothing: one kernel is compiled, and none calls
another (a forked process, which links all anew, would have the threads of its parent in the inner
one).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.scheme.lattice_force import dilatation, force, pressure, stress
from sphsolid.scheme.lattice_sums import U

Array = NDArray[np.float64]
NO_LOAD = np.zeros((0, 3))
#: Of a launch that moves nothing: no middle, nobody held, no positions.
_NOTHING = np.zeros(3), NO_LOAD, np.zeros(0, np.int64), np.zeros((0, 3, 3))
_NO_PLACES = np.zeros((3, 0))


@inlined
def _left_free(n, held, free, f):  # type: ignore[no-untyped-def]
    """Leave of row ``n`` of those held what ``free`` does, in a field ``f (3, .)``."""
    a = held[n]
    f0, f1, f2 = f[0, a], f[1, a], f[2, a]
    for c in range(3):
        f[c, a] = free[n, c, 0] * f0 + free[n, c, 1] * f1 + free[n, c, 2] * f2


@kernel
def drift_and_kick(  # type: ignore[no-untyped-def]
    a, b, middle, load, held, free,
    lines, tables, material, rest, parts, x, arms, p, work, limit, rate,
):  # fmt: skip
    """``x += a p``, then ``p += b f`` with ``f (3, .)`` at those positions, which goes to ``rate``.

    ``arms (3, .)`` [m] are ``x - middle``; ``load (N, 3)`` [N/m^3], or ``(0, 3)`` for none, is
    added to the force of the body.  ``lines`` are those of the grid, packed.  ``free (n, 3, 3)``
    leaves of a vector at the particles ``held (n,)`` what no condition takes.  The smallest stretch
    of every particle goes to ``limit (.)``.
    """
    marker, whole, real, of_x, of_y, of_z = lines
    for i in prange(x.shape[1]):
        for c in range(3):
            x[c, i] += a * p[c, i]
            arms[c, i] = x[c, i] - middle[c]
    if tables.smoothing > U(0):
        for t in prange(work.workers):
            dilatation(U(t), marker, whole, real, of_x, of_y, of_z, tables, arms, work, limit)
        for t in prange(work.workers):
            pressure(U(t), marker, whole, real, of_x, of_y, of_z, tables, material, rest, work)
    for t in prange(work.workers):
        stress(
            U(t), marker, whole, real, of_x, of_y, of_z, tables, material, rest, parts, arms, p,
            work, limit, rate,
        )  # fmt: skip
    for t in prange(work.workers):
        force(U(t), marker, whole, real, of_x, of_y, of_z, work, rate)
    for i in prange(len(load)):
        for c in range(3):
            rate[c, i] += load[i, c]
    for n in prange(len(held)):
        _left_free(n, held, free, rate)
    for i in prange(x.shape[1]):
        for c in range(3):
            p[c, i] += b * rate[c, i]
    for n in prange(len(held)):
        _left_free(n, held, free, p)


def forces(
    lines: Any, tables: Any, material: Any, rest: float, parts: Any, arms: Array, p: Array,
    work: Any, limit: Array, rate: Array,
) -> None:  # fmt: skip
    """``rate = rho0 a  (3, .)`` [N/m^3] of the body itself, and the smallest stretches."""
    drift_and_kick(
        0.0, 0.0, *_NOTHING, lines, tables, material, rest, parts, _NO_PLACES, arms, p, work,
        limit, rate,
    )  # fmt: skip
