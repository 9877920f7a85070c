"""The restraint along the axes of a box lattice: what an affine motion leaves of each line.

``e`` is the fourth difference of the positions along an axis, the second where five points do not
stand in a row.  With the volume ``V`` of its middle particle, its potential and its dissipation
potential are

    V (c_4 mu |e|^4 / (4 dx^4) + c_e mu |e|^2 / (2 dx^2)),     V c_v rho0 c |d(F^T e)/dt|^2 / (2 dx)

with ``F`` at the middle.  They do not change in a rigid motion, so their forces have neither
resultant nor moment, and the second takes energy at any state.

Where the body is strongly stretched the second is less (``viscous_share``).

``R``, the derivatives by ``e``, is zero where there is no difference, and two planes or lines of
zeros are before the first and after the last: the transpose takes the ends like all others.
"""

from __future__ import annotations

from sphsolid.compiled import inlined
from sphsolid.scheme.lattice_sums import STRIDE, U, tensor_at, tensor_to
from sphsolid.scheme.viscous_share import viscous_share


@inlined
def _five(f, r, own, near, far, a, stride, wide):  # type: ignore[no-untyped-def]
    return (
        far * (f[r, a + wide] + f[r, a - wide])
        + near * (f[r, a + stride] + f[r, a - stride])
        + own * f[r, a]
    )


@inlined
def _difference(f, line, at, stride, count, S, q):  # type: ignore[no-untyped-def]
    """``D f`` of three rows at ``count`` particles from ``at`` on, to three scratch rows."""
    own, near, far = line.middle, line.near, line.far
    # A second difference has no second neighbours.
    wide = stride + stride if line.reach == U(2) else stride
    q1, q2, one, two = q + U(STRIDE), q + U(2 * STRIDE), U(1), U(2)
    for k in range(count):
        S[q + k] = _five(f, U(0), own, near, far, at + k, stride, wide)
        S[q1 + k] = _five(f, one, own, near, far, at + k, stride, wide)
        S[q2 + k] = _five(f, two, own, near, far, at + k, stride, wide)


@inlined
def _clear_ends(line, tile, S, q):  # type: ignore[no-untyped-def]
    """Zero in the three scratch rows at ``q`` where lines of the tile end."""
    for j in range(tile.end - tile.begin):
        for r in range(line.reach):
            first, last = r, line.n - U(1) - r
            for k in (first, last):
                if tile.k0 <= k and k < tile.k0 + tile.width:
                    lane = j * tile.width + k - tile.k0
                    for c in range(U(3)):
                        S[q + c * U(STRIDE) + lane] = 0.0


@inlined
def shares(parts, tile, S, F, share):  # type: ignore[no-untyped-def]
    """``viscous_share`` of the tile, of ``F`` in nine scratch rows, for all three axes."""
    for k in range(tile.count):
        S[share + k] = viscous_share(tensor_at(S, F + k), parts.most)


@inlined
def restrain(  # type: ignore[no-untyped-def]
    parts, grid, tables, axis, tile, per_mass, x, p, S, F, L, P, e, share
):
    """``R`` of one axis on a tile, and what its viscous part adds to ``P``.

    ``F``, ``L``, ``P`` and ``e`` are where scratch rows begin: nine of ``grad x``, of ``grad p``
    and of the stress, and room for six; ``share`` is that of :func:`shares`.  ``R`` is left in the
    last three of the room; handed out are the first particle that has one and their number.
    """
    low, count, weight = U(0), tile.count, 1.0
    if axis == 0:
        line, stride = grid.x, grid.y.n * grid.z.n
        weight = line.inverse[tile.i]
        if tile.i < line.reach or tile.i + line.reach >= line.n:
            count = U(0)
    elif axis == 1:
        line, stride = grid.y, grid.z.n
        begin, end = max(tile.begin, line.reach), min(tile.end, line.n - line.reach)
        low = (begin - tile.begin) * tile.width if begin < end else U(0)
        count = (end - begin) * tile.width if begin < end else U(0)
    else:
        line, stride = grid.z, U(1)
        begin = max(tile.k0, line.reach) - tile.k0
        past = line.n - line.reach
        cut = tile.k0 + tile.width - past if tile.k0 + tile.width > past else U(0)
        low = begin
        count = tile.count - begin - cut if begin + cut < tile.count else U(0)
    if line.reach == U(0) or count == U(0):
        return low, U(0)
    # All rows are read from the same lane on, or their distances would not be constant.
    F, L, P, e, lane = F + low, L + low, P + low, e + low, tile.lane + low
    at, v, share = tile.at + low, e + U(3 * STRIDE), share + low
    e1, e2 = e + U(STRIDE), e + U(2 * STRIDE)
    v1, v2 = v + U(STRIDE), v + U(2 * STRIDE)
    _difference(x, line, at, stride, count, S, e)
    if axis == 2:
        _clear_ends(line, tile, S, e - low)
    quartic = parts.quartic / (line.dx * line.dx * line.dx * line.dx)
    elastic = parts.elastic / (line.dx * line.dx)
    if parts.viscosity == 0.0:
        for k in range(count):
            d0, d1, d2 = S[e + k], S[e1 + k], S[e2 + k]
            spring = quartic * (d0 * d0 + d1 * d1 + d2 * d2) + elastic
            S[v + k], S[v1 + k], S[v2 + k] = spring * d0, spring * d1, spring * d2
        return low, count
    _difference(p, line, at, stride, count, S, v)
    if axis == 2:
        _clear_ends(line, tile, S, v - low)
    # A difference of momenta over the density is one of velocities.
    viscosity = parts.viscosity * per_mass / line.dx
    for k in range(count):
        d0, d1, d2 = S[e + k], S[e1 + k], S[e2 + k]
        g0, g1, g2 = S[v + k], S[v1 + k], S[v2 + k]
        A, B = tensor_at(S, F + k), tensor_at(S, L + k)
        c = viscosity * S[share + k]
        s0 = c * (A[0] * g0 + A[3] * g1 + A[6] * g2 + (B[0] * d0 + B[3] * d1 + B[6] * d2))
        s1 = c * (A[1] * g0 + A[4] * g1 + A[7] * g2 + (B[1] * d0 + B[4] * d1 + B[7] * d2))
        s2 = c * (A[2] * g0 + A[5] * g1 + A[8] * g2 + (B[2] * d0 + B[5] * d1 + B[8] * d2))
        spring = quartic * (d0 * d0 + d1 * d1 + d2 * d2) + elastic
        # To the scratch first: a loop that stores to rows of R, too, would not use registers well.
        S[v + k] = spring * d0 + (A[0] * s0 + A[1] * s1 + A[2] * s2)
        S[v1 + k] = spring * d1 + (A[3] * s0 + A[4] * s1 + A[5] * s2)
        S[v2 + k] = spring * d2 + (A[6] * s0 + A[7] * s1 + A[8] * s2)
        # The middle of the difference is a particle: the share of its own norm along the axis.
        w = weight * tables.inverse[axis, lane + k]
        d0, d1, d2 = w * d0, w * d1, w * d2
        T = tensor_at(S, P + k)
        added = (
            T[0] + d0 * s0, T[1] + d0 * s1, T[2] + d0 * s2,
            T[3] + d1 * s0, T[4] + d1 * s1, T[5] + d1 * s2,
            T[6] + d2 * s0, T[7] + d2 * s1, T[8] + d2 * s2,
        )  # fmt: skip
        tensor_to(added, S, P + k)
    return low, count


@inlined
def subtract_in_plane(R, y, z, grid, tables, tile, at, S, q):  # type: ignore[no-untyped-def]
    """Subtract ``H^-1 D^T R`` of both fast axes, their rows from ``y`` and ``z`` on."""
    nz = grid.z.n
    wide_y = nz + nz if grid.y.reach == U(2) else nz
    wide_z = U(2) if grid.z.reach == U(2) else U(1)
    y0, y1, y2 = grid.y.middle, grid.y.near, grid.y.far
    z0, z1, z2 = grid.z.middle, grid.z.near, grid.z.far
    for c in range(U(3)):
        to = q + c * U(STRIDE)
        for k in range(tile.count):
            S[to + k] -= tables.inverse[1, tile.lane + k] * _five(
                R, y + c, y0, y1, y2, at + k, nz, wide_y
            ) + tables.inverse[2, tile.lane + k] * _five(
                R, z + c, z0, z1, z2, at + k, U(1), wide_z
            )


@inlined
def subtract_across(R, grid, tile, at, S, q):  # type: ignore[no-untyped-def]
    """The same of the slow axis, of ``R (3, .)``."""
    line, plane = grid.x, grid.y.n * grid.z.n
    wide = plane + plane if line.reach == U(2) else plane
    own, near, far, share = line.middle, line.near, line.far, line.inverse[tile.i]
    for c in range(U(3)):
        to = q + c * U(STRIDE)
        for k in range(tile.count):
            S[to + k] -= share * _five(R, c, own, near, far, at + k, plane, wide)
