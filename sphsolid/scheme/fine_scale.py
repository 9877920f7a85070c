"""Fine-scale stress and ``D(p)`` at the secondary particles, [Lee2017] eqs. (22)-(28), (33)-(34).

Residuals at ``q``, with ``W~`` the linear-corrected interpolation:

    R_F   = sum_a v_a (x) G_a - sum_a V_a W~_a Fdot_a,
    R_F^x = sum_a x_a (x) G_a - sum_a V_a W~_a F_a,

and likewise for ``H`` and ``J``.  The operator ``sample`` holds ``G_a(X_q)`` in its columns 0 to 2
and ``V_a W~_a(X_q)`` in column 3, ``spread`` is its adjoint; how fields lie in memory is said in
``fields``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import (
    add,
    axpy,
    cofactor,
    contract,
    cross,
    determinant,
    scale,
)
from sphsolid.fields import LANES
from sphsolid.scheme import tile as on_tile
from sphsolid.scheme.projection import project
from sphsolid.scheme.tile import STRIDE, U, load_lane, store_lane

#: Column of ``sample`` that interpolates.
WEIGHT = 3
Rows = NDArray[Any]


class Simplified(NamedTuple):
    """Of eq. (27): ``rho0``, ``tau_F gamma``, ``xi_F alpha``, and whether ``F_x`` is wanted."""

    density: float
    tau_gamma: float
    xi_alpha: float
    keeps_F_x: bool


class Matched(NamedTuple):
    """What eq. (27) compares with one another."""

    p: Rows
    x: Rows
    F: Rows
    Fdot: Rows


class Forms(NamedTuple):
    """Of the general forms: the strains (28) or the Hessian (22)-(23), projected or not."""

    strains: bool
    projects: bool


class Coefficients(NamedTuple):
    """``tau`` [s] and ``xi`` [-] of ``F, H, J``; ``alpha`` [Pa]."""

    tau_F: float
    tau_H: float
    tau_J: float
    xi_F: float
    xi_H: float
    xi_J: float
    alpha: float


class Evolved(NamedTuple):
    """Fields at the particles; ``H`` and ``J`` zero-length where they follow from ``F``."""

    p: Rows
    x: Rows
    F: Rows
    H: Rows
    J: Rows


class Rates(NamedTuple):
    """Their rates, and what is found at ``q``: ``P_fine`` and ``F_x``."""

    F: Rows
    H: Rows
    J: Rows
    P_fine: Rows
    F_x: Rows


# Scratch rows; R_F becomes P_fine in place.  The gradient of the positions follows that of the
# velocities.
_R, _F_X, _FD, _FI, _HI, _HD, _JI, _JD = 0, 9, 18, 27, 36, 45, 54, 55


@kernel
def simplified(  # type: ignore[no-untyped-def]
    sample, coefficients, projects, matched, P_fine, F_x, scratch
):
    """Eq. (27), ``P_fine = tau gamma R_F + xi alpha R_F^x``, projected when ``projects``.

    ``F_x (9, .)`` at ``q`` is written when ``keeps_F_x``; ``F`` is not read when ``xi = 0``.
    """
    density, tau_gamma, xi_alpha, keeps_F_x = coefficients
    p, x, F, Fdot = matched
    tiles, workers = len(sample.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            if projects or keeps_F_x or xi_alpha != 0.0:
                on_tile.two_gradients(sample, tile, p, 1.0 / density, x, S, _R)
            else:
                on_tile.gradient(sample, tile, at, p, 1.0 / density, S, _R)
            on_tile.interpolate_tensor(sample, WEIGHT, tile, at, Fdot, S, _FD)
            for lane in range(U(LANES)):
                residual = axpy(-1.0, load_lane(S, _FD, lane), load_lane(S, _R, lane))
                store_lane(scale(tau_gamma, residual), S, _R, lane)
            if xi_alpha != 0.0:
                on_tile.interpolate_tensor(sample, WEIGHT, tile, at, F, S, _FI)
                for lane in range(U(LANES)):
                    residual = axpy(-1.0, load_lane(S, _FI, lane), load_lane(S, _F_X, lane))
                    store_lane(axpy(xi_alpha, residual, load_lane(S, _R, lane)), S, _R, lane)
            if projects:
                for lane in range(U(LANES)):
                    stress = project(load_lane(S, _R, lane), load_lane(S, _F_X, lane))
                    store_lane(stress, S, _R, lane)
            on_tile.put_tensor(S, _R, at, P_fine)
            if keeps_F_x:
                on_tile.put_tensor(S, _F_X, at, F_x)


@kernel
def general(  # type: ignore[no-untyped-def]
    sample, material, forms, coefficients, fields, rates, scratch
):
    """Eqs. (22)-(23) or, when ``strains``, (28); slower, every field is interpolated.

    Fields that are not evolved are taken from ``F``.
    """
    strains, projects = forms
    tau_F, tau_H, tau_J, xi_F, xi_H, xi_J, alpha = coefficients
    p, x, F, H, J = fields
    Fdot, Hdot, Jdot, P_fine, F_x = rates
    has_H, has_J = H.size > 0, J.size > 0
    tiles, workers = len(sample.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.two_gradients(sample, tile, p, 1.0 / material.density, x, S, _R)
            on_tile.interpolate_tensor(sample, WEIGHT, tile, at, F, S, _FI)
            on_tile.interpolate_tensor(sample, WEIGHT, tile, at, Fdot, S, _FD)
            if has_H:
                on_tile.interpolate_tensor(sample, WEIGHT, tile, at, H, S, _HI)
                on_tile.interpolate_tensor(sample, WEIGHT, tile, at, Hdot, S, _HD)
            if has_J:
                on_tile.interpolate_scalar(sample, WEIGHT, tile, at, J, S, _JI)
                on_tile.interpolate_scalar(sample, WEIGHT, tile, at, Jdot, S, _JD)
            for lane in range(U(LANES)):
                L = load_lane(S, _R, lane)
                F_q = load_lane(S, _F_X, lane)
                Fi = load_lane(S, _FI, lane)
                Fd = load_lane(S, _FD, lane)
                Hi = load_lane(S, _HI, lane) if has_H else cofactor(Fi)
                Hd = load_lane(S, _HD, lane) if has_H else cross(Fi, Fd)
                Ji = S[U(_JI * STRIDE) + lane] if has_J else determinant(Fi)
                Jd = S[U(_JD * STRIDE) + lane] if has_J else contract(Hi, Fd)
                R_F = axpy(-1.0, Fd, L)
                R_Fx = axpy(-1.0, Fi, F_q)
                R_H = axpy(-1.0, Hd, cross(Fi, L))
                R_J = contract(Hi, L) - Jd
                if strains:
                    F_st = axpy(tau_F, R_F, axpy(xi_F, R_Fx, Fi))
                    H_st = axpy(tau_H, R_H, axpy(xi_H, axpy(-1.0, Hi, cofactor(F_q)), Hi))
                    J_st = Ji + tau_J * R_J + xi_J * (determinant(F_q) - Ji)
                    if not has_H:
                        H_st = cofactor(F_st)
                    if not has_J:
                        J_st = determinant(F_st)
                    coarse = law.first_piola(material, Fi, Hi, Ji)
                    P_q = axpy(-1.0, coarse, law.first_piola(material, F_st, H_st, J_st))
                else:
                    S_F, S_H, S_J = law.hessian_action(
                        material, Fi, Hi, Ji, scale(tau_F, R_F), scale(tau_H, R_H), tau_J * R_J
                    )
                    P_q = add(axpy(xi_F * alpha, R_Fx, S_F), axpy(S_J, Hi, cross(S_H, Fi)))
                if projects:
                    P_q = project(P_q, F_q)
                store_lane(P_q, S, _R, lane)
            on_tile.put_tensor(S, _R, at, P_fine)
            on_tile.put_tensor(S, _F_X, at, F_x)


@kernel
def subtract_back(  # type: ignore[no-untyped-def]
    spread, G_f, projects, x, P_fine, P, scratch
):
    """``P_a -= B_a``, ``B_a = sum_q (V_q / V_a) V_a W~_a(X_q) P_fine(X_q)``, projected by (40).

    The adjoint of the interpolation to ``q``: see ``stabilisation.SelfAdjoint``.
    """
    tiles, workers = len(spread.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.interpolate_tensor(spread, WEIGHT, tile, at, P_fine, S, _R)
            if projects:
                on_tile.gradient(G_f, tile, at, x, 1.0, S, _F_X)
                for lane in range(U(LANES)):
                    back = project(load_lane(S, _R, lane), load_lane(S, _F_X, lane))
                    store_lane(back, S, _R, lane)
            on_tile.fetch_tensor(P, at, S, _FD)
            for lane in range(U(LANES)):
                left = axpy(-1.0, load_lane(S, _R, lane), load_lane(S, _FD, lane))
                store_lane(left, S, _FD, lane)
            on_tile.put_tensor(S, _FD, at, P)


@kernel
def momentum_dissipation(spread, P_fine, rate, scratch):  # type: ignore[no-untyped-def]
    """Add ``D(p_a) = -sum_q (V_q / V_a) P_fine(X_q) G_a(X_q)`` (34) to ``rate (3, .)``."""
    tiles, workers = len(spread.runs) - 1, len(scratch)
    for t in prange(workers):
        S = scratch[t]
        begin, end = on_tile.share(t, workers, tiles)
        for tile in range(begin, end):
            at = tile * U(LANES)
            on_tile.divergence(spread, tile, at, P_fine, S, 0)
            on_tile.subtract(S, 0, 3, at, rate)
