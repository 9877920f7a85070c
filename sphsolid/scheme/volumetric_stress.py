"""Loops over particles for a stress in whose place another pressure acts.

Fields are component-major rows ``(components, .)`` or particle-major tensors (see ``fields``).
"""

from __future__ import annotations

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, contract, determinant, load, scale
from sphsolid.fields import LANES
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.projection import project
from sphsolid.scheme.tile import STRIDE, U, load_lane, store_lane

# Scratch rows.
_F, _H, _F_X, _P = 0, 9, 18, 27
_J, _E = 36, 37


@kernel
def jacobian(F, tiles, J, scratch):  # type: ignore[no-untyped-def]
    """``J = det F  (1, .)``."""
    workers = len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch_tensor(F, at, S, _F)
            for lane in range(U(LANES)):
                S[U(_J * STRIDE) + lane] = determinant(load_lane(S, _F, lane))
            on_tile.put(S, _J, 1, at, J)


@kernel
def conjugate(material, stiffness, J, smooth, out):  # type: ignore[no-untyped-def]
    """``U'(S J) - s (J - S J)  (N,)`` [Pa], what the filter makes ``p~ - s (J - S J)`` of."""
    for a in prange(len(out)):
        out[a] = law.volumetric_pressure(material, smooth[a]) - stiffness * (J[a] - smooth[a])


@kernel
def excess(material, stiffness, J, smooth, pressure):  # type: ignore[no-untyped-def]
    """``pressure + s (J - S J) - U'(J)  (N,)`` [Pa], in its place."""
    for a in prange(len(pressure)):
        own = law.volumetric_pressure(material, J[a])
        pressure[a] = (pressure[a] + stiffness * (J[a] - smooth[a])) - own


@kernel
def add(e, F, H, F_x, tiles, P, scratch):  # type: ignore[no-untyped-def]
    """``P += e H``, projected by (40) of [Lee2017] where ``F_x`` has a length.

    ``H`` is the evolved one or, where it has no length, ``cof F``.
    """
    workers = len(scratch)
    has_H, projects = H.size > 0, F_x.size > 0
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch(e, 1, at, S, _E)
            if has_H:
                on_tile.fetch_tensor(H, at, S, _H)
            else:
                on_tile.fetch_tensor(F, at, S, _F)
                for lane in range(U(LANES)):
                    store_lane(cofactor(load_lane(S, _F, lane)), S, _H, lane)
            on_tile.fetch_tensor(P, at, S, _P)
            if projects:
                on_tile.fetch_tensor(F_x, at, S, _F_X)
                for lane in range(U(LANES)):
                    own = scale(S[U(_E * STRIDE) + lane], load_lane(S, _H, lane))
                    own = project(own, load_lane(S, _F_X, lane))
                    store_lane(axpy(1.0, own, load_lane(S, _P, lane)), S, _P, lane)
            else:
                for lane in range(U(LANES)):
                    own = S[U(_E * STRIDE) + lane]
                    total = axpy(own, load_lane(S, _H, lane), load_lane(S, _P, lane))
                    store_lane(total, S, _P, lane)
            on_tile.put_tensor(S, _P, at, P)


@kernel
def powers_of_stress(V, e, F, H, F_x, L_k, L_f, out):  # type: ignore[no-untyped-def]
    """``V [Q : L_k - Q^C : L_f]  (N,)`` [W] of ``Q = e H`` and its projection ``Q^C``."""
    for a in prange(len(V)):
        Q = scale(e[a], load(H, a) if len(H) > 0 else cofactor(load(F, a)))
        Q_C = project(Q, load(F_x, a)) if len(F_x) > 0 else Q
        by_F = contract(Q, axpy(-1.0, load(L_f, a), load(L_k, a)))
        out[a] = V[a] * (by_F - contract(axpy(-1.0, Q, Q_C), load(L_f, a)))


@kernel
def powers_of_J(V, e, F, H, L, Jdot, out):  # type: ignore[no-untyped-def]
    """``V e [dJ/dt - H : L]  (N,)`` [W]: what something else than the motion does to ``J``."""
    for a in prange(len(V)):
        H_a = load(H, a) if len(H) > 0 else cofactor(load(F, a))
        out[a] = V[a] * e[a] * (Jdot[a] - contract(H_a, load(L, a)))
