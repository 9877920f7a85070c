"""The filter of the dilatation on a box lattice: axis by axis, each symmetric in its norm.

Along a line it is ``f_i + sum_m s_m (f_(i+m) - f_i)`` with the weights of ``cloud.lattice.lines``:
a constant comes out as it went in, to the last bit.  In a plane all lines are taken in one loop,
with the weights of every particle in a table; those of neighbours that do not exist are zero, and
what stands in their place need only be a number.
"""

from __future__ import annotations

from sphsolid.compiled import inlined
from sphsolid.scheme.lattice_sums import U


@inlined
def _smooth(f, at, table, stride, count, smoothing, out, to):  # type: ignore[no-untyped-def]
    if smoothing == U(1):
        for k in range(count):
            here = f[at + k]
            out[to + k] = here + (
                table[2, k] * (f[at + k - stride] - here)
                + table[3, k] * (f[at + k + stride] - here)
            )
    else:
        two, three = U(2) * stride, U(3) * stride
        for k in range(count):
            here = f[at + k]
            near = table[2, k] * (f[at + k - stride] - here) + table[3, k] * (
                f[at + k + stride] - here
            )
            far = table[1, k] * (f[at + k - two] - here) + table[4, k] * (f[at + k + two] - here)
            end = table[0, k] * (f[at + k - three] - here) + table[5, k] * (
                f[at + k + three] - here
            )
            out[to + k] = here + (near + (far + end))


@inlined
def smooth_in_plane(S, one, two, nz, tables, out, at):  # type: ignore[no-untyped-def]
    """Filter the plane at ``one`` of the scratch along both fast axes, to ``out`` from ``at`` on.

    ``two`` is room for a plane.  Both have three lines of numbers before and after them.
    """
    count = U(tables.smooth_z.shape[1])
    _smooth(S, one, tables.smooth_z, U(1), count, tables.smoothing, S, two)
    _smooth(S, two, tables.smooth_y, nz, count, tables.smoothing, out, at)


@inlined
def smooth_across(f, line, i, at, stride, count, smoothing, S, q):  # type: ignore[no-untyped-def]
    """Filter ``f`` along the slow axis, at ``count`` particles of plane ``i`` from ``at`` on."""
    for k in range(count):
        S[q + k] = f[at + k]
    # Order one has one neighbour on each side, order two has three.
    for m in range(U(1), U(2) * smoothing):
        below, above = line.smooth[i, U(3) - m], line.smooth[i, U(2) + m]
        # Where there is no plane, its weight is zero.
        a = at - m * stride if i >= m else at
        b = at + m * stride if i + m < line.n else at
        for k in range(count):
            here = f[at + k]
            S[q + k] += below * (f[a + k] - here) + above * (f[b + k] - here)
