"""Bubnov-Galerkin rates at the primary particles, [Lee2017] eqs. (31)-(32).

Fields are component-major rows ``(components, .)`` (see ``fields``), operators ``PairOperator``.
Arguments that belong together come in a flat ``NamedTuple``.  Two operators are two arguments:
numba 0.68 does not lower a tuple that holds both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import Tensor, cofactor, contract, cross, determinant
from sphsolid.fields import LANES
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.projection import project
from sphsolid.scheme.tile import STRIDE, U, load_lane, store_lane

Rows = NDArray[Any]


class Passes(NamedTuple):
    """What :func:`coarse` does: see there."""

    adjoint: bool
    needs_rates: bool
    knows_L: bool
    projects: bool


class Given(NamedTuple):
    """What :func:`coarse` reads: positions and fields, zero-length where they are not evolved."""

    x: Rows
    p: Rows
    F: Rows
    H: Rows
    J: Rows


class Found(NamedTuple):
    """What :func:`coarse` writes: stress and rates, ``F_C`` the projected rate where wanted."""

    P: Rows
    F: Rows
    H: Rows
    J: Rows
    F_C: Rows


# Scratch rows of ``coarse``; the gradient of the positions follows that of the velocities.
_L, _F_X, _F, _P, _H, _H_DOT, _J, _J_DOT = 0, 9, 18, 27, 36, 45, 54, 55


@kernel
def gradient(G, f, factor, out, scratch):  # type: ignore[no-untyped-def]
    """``out_a = factor * sum_b f_b (x) G_b(X_a)  (9, .)`` for a vector field ``f (3, .)``."""
    tiles, workers = len(G.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.gradient(G, tile, at, f, factor, S, _L)
            on_tile.put_tensor(S, _L, at, out)


@inlined
def _cofactor(S: Any, lane: Any, has_H: Any) -> Tensor:
    """``H``, the evolved one or that of ``F``."""
    return load_lane(S, _H, lane) if has_H else cofactor(load_lane(S, _F, lane))


@kernel
def coarse(material, G_k, G_f, passes, given, found, scratch):  # type: ignore[no-untyped-def]
    """Eqs. (31b)-(31d) and the stress (9), projected by (40) when ``projects``.

    ``dF/dt = sum_b (p_b / rho0) (x) G_b``, ``dH/dt = F x grad v``, ``dJ/dt = H : grad v`` with the
    kinematic gradient ``G_k`` (when ``needs_rates``); ``F_x = sum_b x_b (x) G_b`` with the one
    whose adjoint makes the force, ``G_f``, the same one when ``adjoint``.  It is used at once and
    never stored.  ``found.F_C`` is the projected rate, where it has a length.  ``found.F`` is read,
    not written, when it is known already (``knows_L``).
    """
    adjoint, needs_rates, knows_L, projects = passes
    x, p, F, H, J = given
    P, Fdot, Hdot, Jdot, Fdot_C = found
    has_H, has_J, projects_rate = H.size > 0, J.size > 0, Fdot_C.size > 0
    tiles, workers = len(G_k.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.fetch_tensor(F, at, S, _F)
            if has_H:
                on_tile.fetch_tensor(H, at, S, _H)
            if has_J:
                on_tile.fetch(J, 1, at, S, _J)
            both = needs_rates and not knows_L and projects and adjoint
            if both:
                on_tile.two_gradients(G_k, tile, p, 1.0 / material.density, x, S, _L)
            elif projects:
                on_tile.gradient(G_f, tile, at, x, 1.0, S, _F_X)
            if needs_rates:
                if knows_L:
                    on_tile.fetch_tensor(Fdot, at, S, _L)
                else:
                    if not both:
                        on_tile.gradient(G_k, tile, at, p, 1.0 / material.density, S, _L)
                    on_tile.put_tensor(S, _L, at, Fdot)
                if projects_rate:
                    for lane in range(U(LANES)):
                        rate = project(load_lane(S, _L, lane), load_lane(S, _F_X, lane))
                        store_lane(rate, S, _P, lane)
                    on_tile.put_tensor(S, _P, at, Fdot_C)
                if has_H:
                    for lane in range(U(LANES)):
                        rate = cross(load_lane(S, _F, lane), load_lane(S, _L, lane))
                        store_lane(rate, S, _H_DOT, lane)
                    on_tile.put_tensor(S, _H_DOT, at, Hdot)
                if has_J:
                    for lane in range(U(LANES)):
                        H_a = _cofactor(S, lane, has_H)
                        S[U(_J_DOT * STRIDE) + lane] = contract(H_a, load_lane(S, _L, lane))
                    on_tile.put(S, _J_DOT, 1, at, Jdot)
            for lane in range(U(LANES)):
                F_a = load_lane(S, _F, lane)
                J_a = S[U(_J * STRIDE) + lane] if has_J else determinant(F_a)
                P_a = law.first_piola(material, F_a, _cofactor(S, lane, has_H), J_a)
                if projects:
                    P_a = project(P_a, load_lane(S, _F_X, lane))
                store_lane(P_a, S, _P, lane)
            on_tile.put_tensor(S, _P, at, P)


@kernel
def internal_force(g, P, out, scratch):  # type: ignore[no-untyped-def]
    """``out_a = -sum_b P_b g_ab  (3, .)``: minus the ``T_a`` of eq. (32) [N/m^3]."""
    tiles, workers = len(g.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.divergence(g, tile, at, P, S, 0)
            on_tile.put_negative(S, 0, 3, at, out)
