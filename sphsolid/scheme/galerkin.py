"""Bubnov-Galerkin rates at the primary particles, [Lee2017] eqs. (31)-(32)."""

from __future__ import annotations

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import (
    axpy,
    cofactor,
    contract,
    cross,
    determinant,
    load,
    scale,
    store,
)
from sphsolid.scheme.projection import project


@kernel
def gradient(indptr, indices, G, f, factor, out):  # type: ignore[no-untyped-def]
    """``out_a = factor * sum_b f_b (x) G_b(X_a)  (N, 3, 3)`` for a vector field ``f (N, 3)``."""
    for a in prange(len(indptr) - 1):
        s00 = s01 = s02 = s10 = s11 = s12 = s20 = s21 = s22 = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            g0, g1, g2 = G[k, 0], G[k, 1], G[k, 2]
            f0, f1, f2 = f[b, 0], f[b, 1], f[b, 2]
            s00 += f0 * g0
            s01 += f0 * g1
            s02 += f0 * g2
            s10 += f1 * g0
            s11 += f1 * g1
            s12 += f1 * g2
            s20 += f2 * g0
            s21 += f2 * g1
            s22 += f2 * g2
        store(scale(factor, (s00, s01, s02, s10, s11, s12, s20, s21, s22)), out, a)


@kernel
def strain_rates(has_H, has_J, L, F, H, Hdot, Jdot):  # type: ignore[no-untyped-def]
    """Eqs. (31c) and (31d): ``dH/dt = F x grad v``, ``dJ/dt = H : grad v``; ``L = grad v``."""
    for a in prange(len(L)):
        F_a = load(F, a)
        L_a = load(L, a)
        if has_H:
            store(cross(F_a, L_a), Hdot, a)
        if has_J:
            H_a = load(H, a) if has_H else cofactor(F_a)
            Jdot[a] = contract(H_a, L_a)


@kernel
def stress(material, has_H, has_J, projects, F, H, J, F_x, P):  # type: ignore[no-untyped-def]
    """``P_a = P(F_a, H_a, J_a)`` (9), projected by (40) when ``projects``."""
    for a in prange(len(F)):
        F_a = load(F, a)
        H_a = load(H, a) if has_H else cofactor(F_a)
        J_a = J[a] if has_J else determinant(F_a)
        P_a = law.first_piola(material, F_a, H_a, J_a)
        if projects:
            P_a = project(P_a, load(F_x, a))
        store(P_a, P, a)


@kernel
def combine(c_rate, c_state, rate, state, out):  # type: ignore[no-untyped-def]
    """``out = c_rate * rate + c_state * state`` for tensor fields ``(N, 3, 3)``."""
    for a in prange(len(out)):
        store(axpy(c_rate, load(rate, a), scale(c_state, load(state, a))), out, a)


@kernel
def internal_force(indptr, indices, g, P, out):  # type: ignore[no-untyped-def]
    """``out_a = -sum_b P_b g_ab  (N, 3)``: minus the ``T_a`` of eq. (32) [N/m^3]."""
    for a in prange(len(indptr) - 1):
        s0 = s1 = s2 = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            b = indices[k]
            g0, g1, g2 = g[k, 0], g[k, 1], g[k, 2]
            s0 += P[b, 0, 0] * g0 + P[b, 0, 1] * g1 + P[b, 0, 2] * g2
            s1 += P[b, 1, 0] * g0 + P[b, 1, 1] * g1 + P[b, 1, 2] * g2
            s2 += P[b, 2, 0] * g0 + P[b, 2, 1] * g1 + P[b, 2, 2] * g2
        out[a, 0] = -s0
        out[a, 1] = -s1
        out[a, 2] = -s2
