"""Fine-scale stress and ``D(p)`` at the secondary particles, [Lee2017] eqs. (22)-(28), (33)-(34).

Residuals at ``q``, with ``W~`` the linear-corrected interpolation:

    R_F   = sum_a v_a (x) G_a - sum_a V_a W~_a Fdot_a,
    R_F^x = sum_a x_a (x) G_a - sum_a V_a W~_a F_a,

and likewise for ``H`` and ``J``.  ``sample (P, 4)`` holds ``G_a(X_q)`` and ``V_a W~_a(X_q)``.
"""

from __future__ import annotations

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
    store,
)
from sphsolid.scheme.projection import project


@kernel
def simplified(  # type: ignore[no-untyped-def]
    indptr, indices, sample, tau_gamma, xi_alpha, projects, v, x, S, P_fine, F_x
):
    """Eq. (27), ``P_fine = tau gamma R_F + xi alpha R_F^x``, projected when ``projects``.

    (27) is linear, so ``S = tau gamma Fdot + xi alpha F`` was formed at the particles before and
    one tensor is interpolated instead of two.  ``F_x (M, 3, 3)`` at ``q`` is an output too.
    """
    for q in prange(len(indptr) - 1):
        s00 = s01 = s02 = s10 = s11 = s12 = s20 = s21 = s22 = 0.0
        x00 = x01 = x02 = x10 = x11 = x12 = x20 = x21 = x22 = 0.0
        for k in range(indptr[q], indptr[q + 1]):
            a = indices[k]
            g0, g1, g2, w = sample[k, 0], sample[k, 1], sample[k, 2], sample[k, 3]
            x0, x1, x2 = x[a, 0], x[a, 1], x[a, 2]
            y0 = tau_gamma * v[a, 0] + xi_alpha * x0
            y1 = tau_gamma * v[a, 1] + xi_alpha * x1
            y2 = tau_gamma * v[a, 2] + xi_alpha * x2
            s00 += y0 * g0 - w * S[a, 0, 0]
            s01 += y0 * g1 - w * S[a, 0, 1]
            s02 += y0 * g2 - w * S[a, 0, 2]
            s10 += y1 * g0 - w * S[a, 1, 0]
            s11 += y1 * g1 - w * S[a, 1, 1]
            s12 += y1 * g2 - w * S[a, 1, 2]
            s20 += y2 * g0 - w * S[a, 2, 0]
            s21 += y2 * g1 - w * S[a, 2, 1]
            s22 += y2 * g2 - w * S[a, 2, 2]
            x00 += x0 * g0
            x01 += x0 * g1
            x02 += x0 * g2
            x10 += x1 * g0
            x11 += x1 * g1
            x12 += x1 * g2
            x20 += x2 * g0
            x21 += x2 * g1
            x22 += x2 * g2
        P_q = (s00, s01, s02, s10, s11, s12, s20, s21, s22)
        F_q = (x00, x01, x02, x10, x11, x12, x20, x21, x22)
        if projects:
            P_q = project(P_q, F_q)
        store(P_q, P_fine, q)
        store(F_q, F_x, q)


@kernel
def general(  # type: ignore[no-untyped-def]
    indptr, indices, sample, material, strains_form, tau, xi, alpha, projects, has_H, has_J,
    v, x, F, H, J, Fdot, Hdot, Jdot, P_fine, F_x,
):  # fmt: skip
    """Eqs. (22)-(23) or, when ``strains_form``, (28); slower, every field is interpolated.

    ``tau, xi (3,)`` for ``F, H, J`` [s], [-]; fields that are not evolved are taken from ``F``.
    """
    for q in prange(len(indptr) - 1):
        L = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        F_q = L
        Fi = L
        Fd = L
        Hi = L
        Hd = L
        Ji = 0.0
        Jd = 0.0
        for k in range(indptr[q], indptr[q + 1]):
            a = indices[k]
            g0, g1, g2, w = sample[k, 0], sample[k, 1], sample[k, 2], sample[k, 3]
            v0, v1, v2 = v[a, 0], v[a, 1], v[a, 2]
            x0, x1, x2 = x[a, 0], x[a, 1], x[a, 2]
            L = add(
                L, (v0 * g0, v0 * g1, v0 * g2, v1 * g0, v1 * g1, v1 * g2, v2 * g0, v2 * g1, v2 * g2)
            )
            F_q = add(
                F_q,
                (x0 * g0, x0 * g1, x0 * g2, x1 * g0, x1 * g1, x1 * g2, x2 * g0, x2 * g1, x2 * g2),
            )
            Fi = axpy(w, (F[a, 0, 0], F[a, 0, 1], F[a, 0, 2], F[a, 1, 0], F[a, 1, 1], F[a, 1, 2],
                          F[a, 2, 0], F[a, 2, 1], F[a, 2, 2]), Fi)  # fmt: skip
            Fd = axpy(w, (Fdot[a, 0, 0], Fdot[a, 0, 1], Fdot[a, 0, 2],
                          Fdot[a, 1, 0], Fdot[a, 1, 1], Fdot[a, 1, 2],
                          Fdot[a, 2, 0], Fdot[a, 2, 1], Fdot[a, 2, 2]), Fd)  # fmt: skip
            if has_H:
                Hi = axpy(w, (H[a, 0, 0], H[a, 0, 1], H[a, 0, 2],
                              H[a, 1, 0], H[a, 1, 1], H[a, 1, 2],
                              H[a, 2, 0], H[a, 2, 1], H[a, 2, 2]), Hi)  # fmt: skip
                Hd = axpy(w, (Hdot[a, 0, 0], Hdot[a, 0, 1], Hdot[a, 0, 2],
                              Hdot[a, 1, 0], Hdot[a, 1, 1], Hdot[a, 1, 2],
                              Hdot[a, 2, 0], Hdot[a, 2, 1], Hdot[a, 2, 2]), Hd)  # fmt: skip
            if has_J:
                Ji += w * J[a]
                Jd += w * Jdot[a]
        R_F = axpy(-1.0, Fd, L)
        R_Fx = axpy(-1.0, Fi, F_q)
        if not has_H:
            Hi = cofactor(Fi)
            Hd = cross(Fi, Fd)
        if not has_J:
            Ji = determinant(Fi)
            Jd = contract(Hi, Fd)
        R_H = axpy(-1.0, Hd, cross(Fi, L))
        R_J = contract(Hi, L) - Jd
        if strains_form:
            F_st = axpy(tau[0], R_F, axpy(xi[0], R_Fx, Fi))
            H_st = axpy(tau[1], R_H, axpy(xi[1], axpy(-1.0, Hi, cofactor(F_q)), Hi))
            J_st = Ji + tau[2] * R_J + xi[2] * (determinant(F_q) - Ji)
            if not has_H:
                H_st = cofactor(F_st)
            if not has_J:
                J_st = determinant(F_st)
            coarse = law.first_piola(material, Fi, Hi, Ji)
            P_q = axpy(-1.0, coarse, law.first_piola(material, F_st, H_st, J_st))
        else:
            S_F, S_H, S_J = law.hessian_action(
                material, Fi, Hi, Ji, scale(tau[0], R_F), scale(tau[1], R_H), tau[2] * R_J
            )
            P_q = add(axpy(xi[0] * alpha, R_Fx, S_F), axpy(S_J, Hi, cross(S_H, Fi)))
        if projects:
            P_q = project(P_q, F_q)
        store(P_q, P_fine, q)
        store(F_q, F_x, q)


@kernel
def momentum_dissipation(indptr, indices, spread, P_fine, rate):  # type: ignore[no-untyped-def]
    """Add ``D(p_a) = -sum_q (V_q / V_a) P_fine(X_q) G_a(X_q)`` (34) to ``rate (N, 3)``."""
    for a in prange(len(indptr) - 1):
        s0 = s1 = s2 = 0.0
        for k in range(indptr[a], indptr[a + 1]):
            q = indices[k]
            g0, g1, g2 = spread[k, 0], spread[k, 1], spread[k, 2]
            s0 += P_fine[q, 0, 0] * g0 + P_fine[q, 0, 1] * g1 + P_fine[q, 0, 2] * g2
            s1 += P_fine[q, 1, 0] * g0 + P_fine[q, 1, 1] * g1 + P_fine[q, 1, 2] * g2
            s2 += P_fine[q, 2, 0] * g0 + P_fine[q, 2, 1] * g1 + P_fine[q, 2, 2] * g2
        rate[a, 0] -= s0
        rate[a, 1] -= s1
        rate[a, 2] -= s2
