"""A drift and the kick after it on a box lattice, in one launch (see ``drift_kick``).

Of a body of some hundred particles, what Python does between two kernels takes as long as a kernel.
The operations are those of ``DriftKick.drift`` and ``DriftKick.kick``, in their order, so the bits
are the same.
"""

from __future__ import annotations

from sphsolid.compiled import kernel, prange
from sphsolid.scheme.boundary import keep_free
from sphsolid.scheme.lattice_arguments import unpacked
from sphsolid.scheme.lattice_force import forces


@kernel
def drift_and_kick(  # type: ignore[no-untyped-def]
    a, b, middle, load, held, free,
    lines, tables, material, rest, parts, x, arms, p, work, limit, rate,
):  # fmt: skip
    """``x += a p``, then ``p += b f`` with ``f (3, .)`` at those positions, which goes to ``rate``.

    ``arms (3, .)`` [m] are ``x - middle``; ``load (N, 3)`` [N/m^3], or ``(0, 3)`` for none, is
    added to the force of the body.  ``lines`` are those of the grid, packed.  ``free (n, 3, 3)``
    leaves of a vector at the particles ``held (n,)`` what no condition takes.
    """
    marker, whole, real, of_x, of_y, of_z = lines
    along_x = unpacked(marker, whole, real, of_x, 0)
    along_y = unpacked(marker, whole, real, of_y, 1)
    along_z = unpacked(marker, whole, real, of_z, 2)
    for i in prange(x.shape[1]):
        for c in range(3):
            x[c, i] += a * p[c, i]
    for i in prange(len(limit)):
        for c in range(3):
            arms[c, i] = x[c, i] - middle[c]
    forces(along_x, along_y, along_z, tables, material, rest, parts, arms, p, work, limit, rate)
    for i in prange(len(load)):
        for c in range(3):
            rate[c, i] += load[i, c]
    keep_free(held, free, rate.T)
    for i in prange(x.shape[1]):
        for c in range(3):
            p[c, i] += b * rate[c, i]
    keep_free(held, free, p.T)
