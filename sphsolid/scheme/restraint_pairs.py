"""The restraint of near pairs on any cloud (see ``restraint`` for what it is).

With ``F = (F_a + F_b) / 2``, ``L`` the mean of ``grad v`` and

    s_ab = d(F^T e)/dt = F^T (v_b - v_a - L X_ab) + L^T e,
    t_ab = V_ab / |X|^2 (c_4 mu r^2 + c_2 mu + g(F)) e  +  V_ab / |X| c_v rho0 c_p F s,
    w_ab = V_ab / |X| c_v rho0 c_p s,      g(F) = c_c [kappa (1 - J)_+ + mu (|F|^2 / 3 - J)_+],

    (x)_+ = 0 for x <= 0,  x^2 / (2 w) up to w,  x - w/2 from there; w is 0.01 mu of stress,

the virtual work is ``sum t . d(x_b - x_a - F X) + (e (x) w) : dF + 1/2 V_ab r^2 dg``.  So
``sum_b t_ab / V_a`` is added to the force of ``a``, and to its stress
``-1/(2 V_a) sum_b (t (x) X - e (x) w - 1/2 V_ab r^2 dg/dF)``.

``g`` is what presses on the pair.  The sum of Jacobians over particles depends on more than the
boundary: it sees the rotations of a fine motion and may miss its strains.  Under pressure a
rotation alone gains energy, which ``g`` outweighs.  On the lines of a box differences commute, and
it is not needed.  The ramp has no kink: a motion that keeps volumes stands at its foot, and
round-off would choose the force.

Pairs are those of a tile of particles (``near_pairs``), ``LANES`` of them at a time: their
particles are fetched to scratch rows, and then the same is done in all lanes at once.  What is
found is the same from both ends, but for the sign of ``t``.  It stays in twelve rows of the scratch
until the particles of the tile add it up.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum.tensor import (
    Tensor,
    Vector,
    add,
    axpy,
    cofactor,
    determinant,
    load,
    scale,
    store,
)
from sphsolid.fields import GRAIN, LANES, components, vector_field
from sphsolid.geometry.edges import edges_of
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.near_pairs import NearPairs, near_pairs
from sphsolid.scheme.restraint_term import Measured, RestraintParts, RestraintTerm
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.tile import STRIDE, U, load_lane, store_lane, tensor_of
from sphsolid.scheme.viscous_share import viscous_share

if TYPE_CHECKING:
    from sphsolid.scheme.restraint import Restraint

Array = NDArray[np.float64]
#: Width of the foot of a ramp, over the shear modulus.
FOOT = 0.01

# Scratch rows of a lane: sums over the two ends, differences of them, numbers of the pair.
_F, _L, _X, _E, _V_AB, _VOLUME, _PER_SQUARE = 0, 9, 18, 21, 24, 27, 28
# And what is found, one row after another: the part in the stress and the force.
_S, _T = 29, 38
_ROWS = 41
#: Numbers of a pair that a tile keeps until they are added up.
_FOUND = 12


@inlined
def unseen(F: Tensor, X: Vector, x: Vector) -> Vector:
    """``x - F X``."""
    return (
        x[0] - (F[0] * X[0] + F[1] * X[1] + F[2] * X[2]),
        x[1] - (F[3] * X[0] + F[4] * X[1] + F[5] * X[2]),
        x[2] - (F[6] * X[0] + F[7] * X[1] + F[8] * X[2]),
    )


@inlined
def rate(F: Tensor, L: Tensor, v: Vector, e: Vector) -> Vector:
    """``d(F^T e)/dt = F^T v + L^T e``, ``v`` the rate of ``e``."""
    return (
        F[0] * v[0] + F[3] * v[1] + F[6] * v[2] + (L[0] * e[0] + L[3] * e[1] + L[6] * e[2]),
        F[1] * v[0] + F[4] * v[1] + F[7] * v[2] + (L[1] * e[0] + L[4] * e[1] + L[7] * e[2]),
        F[2] * v[0] + F[5] * v[1] + F[8] * v[2] + (L[2] * e[0] + L[5] * e[1] + L[8] * e[2]),
    )


@inlined
def _dyad(u: Vector, v: Vector) -> Tensor:
    """``u (x) v``."""
    return (
        u[0] * v[0], u[0] * v[1], u[0] * v[2],
        u[1] * v[0], u[1] * v[1], u[1] * v[2],
        u[2] * v[0], u[2] * v[1], u[2] * v[2],
    )  # fmt: skip


@inlined
def apart(f: Any, a: Any, b: Any) -> Vector:
    """``f_b - f_a`` of a vector field."""
    return (f[0, b] - f[0, a], f[1, b] - f[1, a], f[2, b] - f[2, a])


@inlined
def mean_with(f: Any, A: Tensor, b: Any) -> Tensor:
    """``(A + f_b) / 2``, ``A = f_a``."""
    return scale(0.5, add(A, tensor_of(f, b)))


@inlined
def _ramp(x: Any, width: Any, per_width: Any) -> Any:
    """``(x)_+`` and its derivative."""
    # Chosen, not branched to: which of two signs comes next nobody can predict.
    rise = x if x > 0.0 else 0.0
    foot = rise if rise < width else width
    slope = foot * per_width
    return 0.5 * foot * slope + (rise - foot), slope


@inlined
def compression(parts: RestraintParts, F: Tensor) -> Any:
    """``pressed (1 - J)_+ + sheared (|F|^2 / 3 - J)_+`` [Pa], and its derivative by ``F``."""
    if not parts.pressed > 0.0:
        return 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    J, H = determinant(F), cofactor(F)
    square = (
        F[0] * F[0] + F[1] * F[1] + F[2] * F[2]
        + F[3] * F[3] + F[4] * F[4] + F[5] * F[5]
        + F[6] * F[6] + F[7] * F[7] + F[8] * F[8]
    )  # fmt: skip
    foot = FOOT * parts.sheared / parts.pressed
    pressure, pressed = _ramp(1.0 - J, foot, 1.0 / foot)
    shear, sheared = _ramp((1.0 / 3.0) * square - J, FOOT, 1.0 / FOOT)
    pressed *= parts.pressed
    sheared *= parts.sheared
    return (
        parts.pressed * pressure + parts.sheared * shear,
        axpy(-(pressed + sheared), H, scale(2.0 / 3.0 * sheared, F)),
    )


@inlined
def _vector(S: Any, row: int, lane: Any) -> Vector:
    q = U(row * STRIDE) + lane
    return (S[q], S[q + U(STRIDE)], S[q + U(2 * STRIDE)])


@inlined
def _store_vector(u: Vector, S: Any, row: int, lane: Any) -> None:
    q = U(row * STRIDE) + lane
    S[q], S[q + U(STRIDE)], S[q + U(2 * STRIDE)] = u[0], u[1], u[2]


@inlined
def _fetch(f, u, near, k, count, S, row, row_u):  # type: ignore[no-untyped-def]
    """``f_a + f_b`` and ``u_b - u_a`` of ``count`` pairs from ``k`` on, to nine rows and three."""
    a = U(near.a[k])
    A, u0, u1, u2 = tensor_of(f, a), u[0, a], u[1, a], u[2, a]
    for lane in range(count):
        # Pairs with one ``a`` are mostly neighbours.
        if U(near.a[k + lane]) != a:
            a = U(near.a[k + lane])
            A, u0, u1, u2 = tensor_of(f, a), u[0, a], u[1, a], u[2, a]
        b = U(near.b[k + lane])
        store_lane(add(A, tensor_of(f, b)), S, row, lane)
        _store_vector((u[0, b] - u0, u[1, b] - u1, u[2, b] - u2), S, row_u, lane)


@inlined
def _fetch_pair(near, k, count, S):  # type: ignore[no-untyped-def]
    """What the pairs are in the undeformed body."""
    for lane in range(count):
        X = apart(near.X, U(near.a[k + lane]), U(near.b[k + lane]))
        _store_vector(X, S, _X, lane)
    for lane in range(count):
        S[U(_VOLUME * STRIDE) + lane] = near.volume[k + lane]
        S[U(_PER_SQUARE * STRIDE) + lane] = near.per_square[k + lane]


@inlined
def _hold(parts, count, S):  # type: ignore[no-untyped-def]
    """What the stiffness does, of ``count`` lanes; ``e`` takes the place of the difference."""
    for lane in range(count):
        F, X = scale(0.5, load_lane(S, _F, lane)), _vector(S, _X, lane)
        e = unseen(F, X, _vector(S, _E, lane))
        volume, per_square = S[U(_VOLUME * STRIDE) + lane], S[U(_PER_SQUARE * STRIDE) + lane]
        r2 = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) * per_square
        held, slope = compression(parts, F)
        c = volume * per_square * (parts.quartic * r2 + parts.elastic + held)
        t = (c * e[0], c * e[1], c * e[2])
        store_lane(axpy(-0.5 * volume * r2, slope, _dyad(t, X)), S, _S, lane)
        _store_vector(t, S, _T, lane)
        _store_vector(e, S, _E, lane)


@inlined
def _damp(parts, count, S):  # type: ignore[no-untyped-def]
    """What the viscosity does, added."""
    for lane in range(count):
        F, L = scale(0.5, load_lane(S, _F, lane)), scale(0.5, load_lane(S, _L, lane))
        X, e, t = _vector(S, _X, lane), _vector(S, _E, lane), _vector(S, _T, lane)
        s = rate(F, L, unseen(L, X, _vector(S, _V_AB, lane)), e)
        per_length = math.sqrt(S[U(_PER_SQUARE * STRIDE) + lane])
        share = viscous_share(F, parts.most)
        c = S[U(_VOLUME * STRIDE) + lane] * per_length * parts.viscosity * share
        w = (c * s[0], c * s[1], c * s[2])
        u = (
            F[0] * w[0] + F[1] * w[1] + F[2] * w[2],
            F[3] * w[0] + F[4] * w[1] + F[5] * w[2],
            F[6] * w[0] + F[7] * w[1] + F[8] * w[2],
        )
        total = axpy(-1.0, _dyad(e, w), add(load_lane(S, _S, lane), _dyad(u, X)))
        store_lane(total, S, _S, lane)
        _store_vector((t[0] + u[0], t[1] + u[1], t[2] + u[2]), S, _T, lane)


@inlined
def _of_slot(S, q, length):  # type: ignore[no-untyped-def]
    """Stress and force from twelve rows of ``length``, the first at ``q``."""
    r, two, three = q + U(3) * length, length + length, U(3) * length
    p, n = r + three, r + three + three
    stress = (
        S[q], S[q + length], S[q + two],
        S[r], S[r + length], S[r + two],
        S[p], S[p + length], S[p + two],
    )  # fmt: skip
    return stress, (S[n], S[n + length], S[n + two])


@kernel
def restrain(near, parts, measured, direct, P, scratch):  # type: ignore[no-untyped-def]
    """``direct (3, .)`` [N/m^3] is written; the part through ``F`` is added to ``P`` [Pa]."""
    x, v, F, L = measured
    damped = L.size > 0
    workers, tiles = len(scratch), len(near.tile) - 1
    kept, length = U(_ROWS * STRIDE), (U(scratch.shape[1]) - U(_ROWS * STRIDE)) // U(_FOUND)
    for worker in prange(workers):
        S = scratch[worker]
        begin, end = on_tile.share(worker, workers, tiles)
        for tile in range(begin, end):
            first, last = near.row[tile], near.row[tile + U(1)]
            for k in range(first, last, U(LANES)):
                count = min(U(LANES), last - k)
                _fetch(F, x, near, k, count, S, _F, _E)
                _fetch_pair(near, k, count, S)
                # Some lanes more than there are pairs, so that only whole registers are used.
                lanes = (count + U(GRAIN - 1)) // U(GRAIN) * U(GRAIN)
                _hold(parts, lanes, S)
                if damped:
                    _fetch(L, v, near, k, count, S, _L, _V_AB)
                    _damp(parts, lanes, S)
                for c in range(U(_FOUND)):
                    source, target = (U(_S) + c) * U(STRIDE), kept + c * length + (k - first)
                    for lane in range(lanes):
                        S[target + lane] = S[source + lane]
            for i in range(near.tile[tile], near.tile[tile + U(1)]):
                f0 = f1 = f2 = 0.0
                total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
                lowest, middle = U(near.begin[U(2) * i]), U(near.begin[U(2) * i + U(1)])
                for j in range(lowest, middle):
                    stress, t = _of_slot(S, kept + U(near.slot[j]), length)
                    total = add(total, stress)
                    f0, f1, f2 = f0 - t[0], f1 - t[1], f2 - t[2]
                for j in range(middle, U(near.begin[U(2) * i + U(2)])):
                    stress, t = _of_slot(S, kept + U(near.slot[j]), length)
                    total = add(total, stress)
                    f0, f1, f2 = f0 + t[0], f1 + t[1], f2 + t[2]
                a = U(near.particle[i])
                per_volume = 1.0 / near.V[a]
                direct[0, a], direct[1, a], direct[2, a] = (
                    f0 * per_volume, f1 * per_volume, f2 * per_volume
                )  # fmt: skip
                total = scale(-0.5 * per_volume, total)
                if P.ndim == 2:
                    for c in range(9):
                        P[c, a] += total[c]
                else:
                    store(add(load(P, a), total), P, a)


@kernel
def energies(near, parts, measured, given, out):  # type: ignore[no-untyped-def]
    """Columns of ``out (N, 2)``: half of what the pairs store [J], and of what they take [W].

    The second is ``-V c / |X| s . s'`` with the rates ``s`` of ``measured`` and ``s'`` of the
    velocities and gradients ``given = (v, L)``.
    """
    x, v, F, L = measured
    v_given, L_given = given
    damped = L.size > 0
    for tile in prange(len(near.tile) - 1):
        first = near.row[tile]
        for i in range(near.tile[tile], near.tile[tile + 1]):
            stored = taken = 0.0
            for j in range(near.begin[2 * i], near.begin[2 * i + 2]):
                k = first + U(near.slot[j])
                a, b = U(near.a[k]), U(near.b[k])
                X = apart(near.X, a, b)
                F_m = mean_with(F, tensor_of(F, a), b)
                e = unseen(F_m, X, apart(x, a, b))
                per_square = near.per_square[k]
                r2 = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) * per_square
                held, _ = compression(parts, F_m)
                half = 0.25 * parts.quartic * r2 + 0.5 * (parts.elastic + held)
                stored += near.volume[k] * half * r2
                if damped:
                    L_m = mean_with(L, tensor_of(L, a), b)
                    s = rate(F_m, L_m, unseen(L_m, X, apart(v, a, b)), e)
                    L_m = mean_with(L_given, tensor_of(L_given, a), b)
                    other = rate(F_m, L_m, unseen(L_m, X, apart(v_given, a, b)), e)
                    share = viscous_share(F_m, parts.most)
                    c = near.volume[k] * math.sqrt(per_square) * parts.viscosity * share
                    taken -= c * (s[0] * other[0] + s[1] * other[1] + s[2] * other[2])
            out[near.particle[i], 0] = 0.5 * stored
            out[near.particle[i], 1] = 0.5 * taken


class PairRestraint(RestraintTerm):
    """The restraint on the edges of the cells of one body."""

    form = "of the edges of the cells"

    def __init__(self, options: Restraint, parts: RestraintParts, set_up: SetUp) -> None:
        super().__init__(options, parts, set_up)
        cloud = set_up.cloud
        edges = edges_of(cloud.mesh)
        self._near = near_pairs(edges, cloud.X, cloud.V)
        share = options.stiffness.compressed
        if share > 0.0:
            self.form += f", with {share:g} of the stress that presses on them"
        self._direct = vector_field(cloud.size)
        self._energies = np.zeros((cloud.size, 2))
        self._scratch = make_scratch(self._near)
        pull = parts.viscosity * edges.volume / edges.lengths(cloud.X)
        ends = np.concatenate([edges.b, edges.a])
        pull = np.bincount(ends, np.concatenate([pull, pull])) / cloud.V
        # Twice the largest sum over the pairs of a particle, by Gershgorin; the motion of a pair
        # that its gradients see is taken out, which makes it less.
        self.rate = 2.0 * float(np.max(pull)) / set_up.material.density

    def add_stress(self, stage: Stage) -> None:
        """The part through ``F``; the other is kept for :meth:`add_rates`."""
        measured = self.measured(stage)
        restrain(
            self._near, self.acting, measured, components(self._direct), components(stage.P),
            self._scratch,
        )  # fmt: skip

    def add_rates(self, stage: Stage) -> None:
        """What acts between the two of a pair."""
        stage.rates.p += self._direct

    def _sums(self, measured: Measured, given: tuple[Array, Array]) -> tuple[float, float]:
        energies(self._near, self.acting, measured, given, self._energies)
        stored, taken = np.sum(self._energies, axis=0)
        return float(stored), float(taken)


def make_scratch(near: NearPairs) -> Array:
    """Scratch ``(workers, .)`` of :func:`restrain`, for as many threads as have a tile."""
    workers = min(numba.config.NUMBA_NUM_THREADS, len(near.tile) - 1)
    # Ones, so that lanes nobody has written to hold nothing slow or invalid.
    return np.ones((workers, _ROWS * STRIDE + _FOUND * (near.most_rows + GRAIN)))
