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
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

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
from sphsolid.fields import components, vector_field
from sphsolid.geometry.edges import edges_of
from sphsolid.geometry.mesh import Mesh
from sphsolid.scheme.restraint_term import Measured, RestraintParts, RestraintTerm
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.tile import tensor_of
from sphsolid.scheme.viscous_share import viscous_share

if TYPE_CHECKING:
    from sphsolid.scheme.restraint import Restraint

Array = NDArray[np.float64]
#: Width of the foot of a ramp, over the shear modulus.
FOOT = 0.01


class NearPairs(NamedTuple):
    """Row ``a`` has the pairs ``indptr[a] .. indptr[a + 1]`` with ``indices`` and ``volume`` [m^3].

    ``X (3, .)`` [m] are the particles, ``V (N,)`` [m^3] their volumes; ``per_square`` [1/m^2] is
    ``1 / |X|^2`` of a pair, since a division takes as long as twenty products.
    """

    indptr: NDArray[np.uint64]
    indices: NDArray[np.uint32]
    volume: Array
    per_square: Array
    X: Array
    V: Array


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
def _ramp(x: Any, width: Any) -> Any:
    """``(x)_+`` and its derivative."""
    # Chosen, not branched to: which of two signs comes next nobody can predict.
    rise = x if x > 0.0 else 0.0
    foot = rise if rise < width else width
    slope = foot / width
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
    pressure, pressed = _ramp(1.0 - J, FOOT * parts.sheared / parts.pressed)
    shear, sheared = _ramp(square / 3.0 - J, FOOT)
    pressed *= parts.pressed
    sheared *= parts.sheared
    return (
        parts.pressed * pressure + parts.sheared * shear,
        axpy(-(pressed + sheared), H, scale(2.0 / 3.0 * sheared, F)),
    )


@kernel
def restrain(near, parts, measured, direct, P):  # type: ignore[no-untyped-def]
    """``direct (3, .)`` [N/m^3] is written; the part through ``F`` is added to ``P`` [Pa]."""
    x, v, F, L = measured
    damped = L.size > 0
    for a in prange(len(near.V)):
        f0 = f1 = f2 = 0.0
        S = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        F_a = tensor_of(F, a)
        L_a = tensor_of(L, a) if damped else F_a
        for k in range(near.indptr[a], near.indptr[a + 1]):
            b = near.indices[k]
            X = apart(near.X, a, b)
            F_m = mean_with(F, F_a, b)
            e = unseen(F_m, X, apart(x, a, b))
            per_square = near.per_square[k]
            r2 = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) * per_square
            held, slope = compression(parts, F_m)
            c = near.volume[k] * per_square * (parts.quartic * r2 + parts.elastic + held)
            t0, t1, t2 = c * e[0], c * e[1], c * e[2]
            S = axpy(-0.5 * near.volume[k] * r2, slope, S)
            if damped:
                L_m = mean_with(L, L_a, b)
                s = rate(F_m, L_m, unseen(L_m, X, apart(v, a, b)), e)
                share = viscous_share(F_m, parts.most)
                c = near.volume[k] * math.sqrt(per_square) * parts.viscosity * share
                w0, w1, w2 = c * s[0], c * s[1], c * s[2]
                t0 += F_m[0] * w0 + F_m[1] * w1 + F_m[2] * w2
                t1 += F_m[3] * w0 + F_m[4] * w1 + F_m[5] * w2
                t2 += F_m[6] * w0 + F_m[7] * w1 + F_m[8] * w2
                S = axpy(-1.0, _dyad(e, (w0, w1, w2)), S)
            f0 += t0
            f1 += t1
            f2 += t2
            S = add(S, _dyad((t0, t1, t2), X))
        per_volume = 1.0 / near.V[a]
        direct[0, a], direct[1, a], direct[2, a] = (
            f0 * per_volume, f1 * per_volume, f2 * per_volume
        )  # fmt: skip
        S = scale(-0.5 * per_volume, S)
        if P.ndim == 2:
            for c in range(9):
                P[c, a] += S[c]
        else:
            store(add(load(P, a), S), P, a)


@kernel
def energies(near, parts, measured, given, out):  # type: ignore[no-untyped-def]
    """Columns of ``out (N, 2)``: half of what the pairs store [J], and of what they take [W].

    The second is ``-V c / |X| s . s'`` with the rates ``s`` of ``measured`` and ``s'`` of the
    velocities and gradients ``given = (v, L)``.
    """
    x, v, F, L = measured
    v_given, L_given = given
    damped = L.size > 0
    for a in prange(len(near.V)):
        stored = taken = 0.0
        F_a = tensor_of(F, a)
        for k in range(near.indptr[a], near.indptr[a + 1]):
            b = near.indices[k]
            X = apart(near.X, a, b)
            F_m = mean_with(F, F_a, b)
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
        out[a, 0] = 0.5 * stored
        out[a, 1] = 0.5 * taken


class PairRestraint(RestraintTerm):
    """The restraint on the edges of the cells of one body."""

    form = "of the edges of the cells"

    def __init__(self, options: Restraint, parts: RestraintParts, set_up: SetUp) -> None:
        super().__init__(options, parts, set_up)
        cloud = set_up.cloud
        self._near = near = near_pairs(cloud.mesh, cloud.X, cloud.V)
        share = options.stiffness.compressed
        if share > 0.0:
            self.form += f", with {share:g} of the stress that presses on them"
        self._direct = vector_field(cloud.size)
        self._energies = np.zeros((cloud.size, 2))
        first = near.indptr.astype(np.int64)
        row = np.repeat(np.arange(cloud.size), first[1:] - first[:-1])
        pull = parts.viscosity * near.volume * np.sqrt(near.per_square)
        pull = np.bincount(row, pull) / cloud.V
        # Twice the largest sum over the pairs of a particle, by Gershgorin; the motion of a pair
        # that its gradients see is taken out, which makes it less.
        self.rate = 2.0 * float(np.max(pull)) / set_up.material.density

    def add_stress(self, stage: Stage) -> None:
        """The part through ``F``; the other is kept for :meth:`add_rates`."""
        measured = self.measured(stage)
        restrain(
            self._near, self.acting, measured, components(self._direct), components(stage.P)
        )

    def add_rates(self, stage: Stage) -> None:
        """What acts between the two of a pair."""
        stage.rates.p += self._direct

    def _sums(self, measured: Measured, given: tuple[Array, Array]) -> tuple[float, float]:
        energies(self._near, self.acting, measured, given, self._energies)
        stored, taken = np.sum(self._energies, axis=0)
        return float(stored), float(taken)


def near_pairs(mesh: Mesh, X: Array, V: Array) -> NearPairs:
    """The edges of the cells, seen from both ends."""
    edges = edges_of(mesh)
    ends = np.concatenate([edges.a, edges.b]), np.concatenate([edges.b, edges.a])
    volume = np.concatenate([edges.volume, edges.volume])
    matrix = csr_array((volume, ends), shape=(len(X), len(X)))
    matrix.sort_indices()
    places = vector_field(len(X))
    places[:] = X
    row = np.repeat(np.arange(len(X)), np.diff(matrix.indptr))
    per_square = 1.0 / np.sum((X[matrix.indices] - X[row]) ** 2, axis=1)
    return NearPairs(
        matrix.indptr.astype(np.uint64), matrix.indices.astype(np.uint32), matrix.data,
        per_square, components(places), V,
    )  # fmt: skip
