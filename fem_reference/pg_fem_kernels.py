"""Compiled cell loops of the Petrov-Galerkin method; formulas in ``pg_fem``.

A node's strains are a row ``S[a] = (F, H, J)`` of nineteen numbers.  Cells write what they give to
each of their corners, ``out (E, n, c)``, and :func:`gather` sums it at the nodes in the order of
the cells, so the bits do not depend on the number of threads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined, kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import (
    axpy,
    cofactor,
    contract,
    cross,
    determinant,
)
from sphsolid.continuum.wave_speed import smallest_stretch

#: Numbers of a node's strains: ``F``, ``H``, ``J``.
STRAINS = 19
#: Cells that share the scratch memory of one turn of the loop.
_BLOCK = 64


class Coefficients(NamedTuple):
    """Of eq. (28): ``tau`` [s] and ``xi`` [-] of ``F, H, J``."""

    tau_F: float
    tau_H: float
    tau_J: float
    xi_F: float
    xi_H: float
    xi_J: float


class Fields(NamedTuple):
    """Nodal ``x`` [m], ``v`` [m/s] ``(N, 3)``; strains and their rates ``(N, 19)``."""

    x: NDArray[Any]
    v: NDArray[Any]
    S: NDArray[Any]
    S_dot: NDArray[Any]


@inlined
def _gradient(nodes, G, f):  # type: ignore[no-untyped-def]
    """``sum_n f_n (x) G_n`` of nodal ``f (N, 3)`` at a point with ``G (n, 3)``."""
    a = b = c = d = e = g = h = i = j = 0.0
    for n in range(len(nodes)):
        u, v, w = f[nodes[n], 0], f[nodes[n], 1], f[nodes[n], 2]
        p, q, r = G[n, 0], G[n, 1], G[n, 2]
        a, b, c = a + u * p, b + u * q, c + u * r
        d, e, g = d + v * p, e + v * q, g + v * r
        h, i, j = h + w * p, i + w * q, j + w * r
    return a, b, c, d, e, g, h, i, j


@inlined
def _interpolate(nodes, N, field, out):  # type: ignore[no-untyped-def]
    """``out (c,) = sum_n N_n field_n`` of nodal ``field (N, c)``."""
    for k in range(len(out)):
        out[k] = 0.0
    for n in range(len(nodes)):
        row = nodes[n]
        for k in range(len(out)):
            out[k] += N[n] * field[row, k]


@inlined
def _tensor(s, k):  # type: ignore[no-untyped-def]
    """Nine entries of ``s`` from ``k`` on."""
    return (
        s[k], s[k + 1], s[k + 2], s[k + 3], s[k + 4], s[k + 5], s[k + 6], s[k + 7], s[k + 8],
    )  # fmt: skip


@inlined
def _strain_rates(L, s):  # type: ignore[no-untyped-def]
    """``F x L`` and ``H : L`` of the strains ``s``."""
    return cross(_tensor(s, 0), L), contract(_tensor(s, 9), L)


@kernel
def strain_rates(cells, v, S, out):  # type: ignore[no-untyped-def]
    """``out (E, n, 19)``: ``sum_q w_q N_n (L, F x L, H : L)`` with ``L = grad v``."""
    nodes, N, G, w = cells
    count = nodes.shape[0]
    for b in prange(-(-count // _BLOCK)):
        s, r = np.empty(STRAINS), np.empty(STRAINS)
        for e in range(b * _BLOCK, min(count, (b + 1) * _BLOCK)):
            shape = e if len(w) > 1 else 0
            out[e] = 0.0
            for q in range(len(N)):
                _interpolate(nodes[e], N[q], S, s)
                L = _gradient(nodes[e], G[shape, q], v)
                H_dot, J_dot = _strain_rates(L, s)
                for k in range(9):
                    r[k], r[9 + k] = L[k], H_dot[k]
                r[18] = J_dot
                for n in range(nodes.shape[1]):
                    share = w[shape, q] * N[q, n]
                    for k in range(STRAINS):
                        out[e, n, k] += share * r[k]


@inlined
def _stabilised(c, s, r, L, F_x):  # type: ignore[no-untyped-def]
    """``F_st, H_st, J_st`` of eq. (28) from strains ``s`` and their rates ``r`` at a point."""
    F, H, J = _tensor(s, 0), _tensor(s, 9), s[18]
    H_dot, J_dot = _strain_rates(L, s)
    F_st = axpy(c.tau_F, axpy(-1.0, _tensor(r, 0), L), F)
    H_st = axpy(c.tau_H, axpy(-1.0, _tensor(r, 9), H_dot), H)
    J_st = J + c.tau_J * (J_dot - r[18])
    F_st = axpy(c.xi_F, axpy(-1.0, F, F_x), F_st)
    H_st = axpy(c.xi_H, axpy(-1.0, H, cofactor(F_x)), H_st)
    return F_st, H_st, J_st + c.xi_J * (determinant(F_x) - J)


@kernel
def stress_forces(cells, material, c, fields, out):  # type: ignore[no-untyped-def]
    """``out (E, n, 3)`` [N]: ``sum_q w_q P_q dN_n/dX``, ``P`` of the strains (28)."""
    nodes, N, G, w = cells
    count = nodes.shape[0]
    for b in prange(-(-count // _BLOCK)):
        s, r = np.empty(STRAINS), np.empty(STRAINS)
        for e in range(b * _BLOCK, min(count, (b + 1) * _BLOCK)):
            shape = e if len(w) > 1 else 0
            out[e] = 0.0
            for q in range(len(N)):
                _interpolate(nodes[e], N[q], fields.S, s)
                _interpolate(nodes[e], N[q], fields.S_dot, r)
                L = _gradient(nodes[e], G[shape, q], fields.v)
                F_x = _gradient(nodes[e], G[shape, q], fields.x)
                F_st, H_st, J_st = _stabilised(c, s, r, L, F_x)
                P = law.first_piola(material, F_st, H_st, J_st)
                for n in range(nodes.shape[1]):
                    g0 = w[shape, q] * G[shape, q, n, 0]
                    g1 = w[shape, q] * G[shape, q, n, 1]
                    g2 = w[shape, q] * G[shape, q, n, 2]
                    out[e, n, 0] += P[0] * g0 + P[1] * g1 + P[2] * g2
                    out[e, n, 1] += P[3] * g0 + P[4] * g1 + P[5] * g2
                    out[e, n, 2] += P[6] * g0 + P[7] * g1 + P[8] * g2


@kernel
def nodal_stress(material, S, P, smallest):  # type: ignore[no-untyped-def]
    """``P (N, 9)`` [Pa] of the nodes' own strains; ``smallest (N,)`` stretch, -1 where invalid."""
    for a in prange(len(S)):
        F, H, J = _tensor(S[a], 0), _tensor(S[a], 9), S[a, 18]
        stress = law.first_piola(material, F, H, J)
        for k in range(9):
            P[a, k] = stress[k]
        stretch = smallest_stretch(F)
        smallest[a] = stretch if min(determinant(F), J) > 0.0 else -1.0


@kernel
def volume_residuals(cells, factor, S, P, inertia, out):  # type: ignore[no-untyped-def]
    """``out (E, n, 1)``: ``-factor sum_q w_q dN_n/dX . H^T R_p``, ``R_p = DIV P - inertia``.

    ``factor = tau_p / rho0`` [m^3 s/kg]; ``inertia (N, 3)`` [N/m^3] is ``dp/dt - f0``.
    """
    nodes, N, G, w = cells
    count = nodes.shape[0]
    for b in prange(-(-count // _BLOCK)):
        s, i = np.empty(STRAINS), np.empty(3)
        for e in range(b * _BLOCK, min(count, (b + 1) * _BLOCK)):
            shape = e if len(w) > 1 else 0
            out[e] = 0.0
            for q in range(len(N)):
                _interpolate(nodes[e], N[q], S, s)
                _interpolate(nodes[e], N[q], inertia, i)
                r0, r1, r2 = -i[0], -i[1], -i[2]
                for n in range(nodes.shape[1]):
                    g = G[shape, q, n]
                    T = P[nodes[e, n]]
                    r0 += T[0] * g[0] + T[1] * g[1] + T[2] * g[2]
                    r1 += T[3] * g[0] + T[4] * g[1] + T[5] * g[2]
                    r2 += T[6] * g[0] + T[7] * g[1] + T[8] * g[2]
                share = -factor * w[shape, q]
                f0 = share * (s[9] * r0 + s[12] * r1 + s[15] * r2)
                f1 = share * (s[10] * r0 + s[13] * r1 + s[16] * r2)
                f2 = share * (s[11] * r0 + s[14] * r1 + s[17] * r2)
                for n in range(nodes.shape[1]):
                    g = G[shape, q, n]
                    out[e, n, 0] += f0 * g[0] + f1 * g[1] + f2 * g[2]


@kernel
def powers(cells, material, c, fields, out):  # type: ignore[no-untyped-def]
    """``out (E, 2)`` [W]: ``sum_q w_q (P, P_st - P) : grad v``."""
    nodes, N, G, w = cells
    count = nodes.shape[0]
    for b in prange(-(-count // _BLOCK)):
        s, r = np.empty(STRAINS), np.empty(STRAINS)
        for e in range(b * _BLOCK, min(count, (b + 1) * _BLOCK)):
            shape = e if len(w) > 1 else 0
            out[e] = 0.0
            for q in range(len(N)):
                _interpolate(nodes[e], N[q], fields.S, s)
                _interpolate(nodes[e], N[q], fields.S_dot, r)
                L = _gradient(nodes[e], G[shape, q], fields.v)
                F_x = _gradient(nodes[e], G[shape, q], fields.x)
                F_st, H_st, J_st = _stabilised(c, s, r, L, F_x)
                P = law.first_piola(material, F_st, H_st, J_st)
                coarse = contract(
                    law.first_piola(material, _tensor(s, 0), _tensor(s, 9), s[18]), L
                )
                out[e, 0] += w[shape, q] * coarse
                out[e, 1] += w[shape, q] * (contract(P, L) - coarse)


@kernel
def gather(start, entries, V, values, rate):  # type: ignore[no-untyped-def]
    """``rate (N, c) = 1/V_a`` times the sums of the rows of ``values (E n, c)``."""
    for a in prange(len(V)):
        rate[a] = 0.0
        for k in range(start[a], start[a + 1]):
            row = entries[k]
            for c in range(rate.shape[1]):
                rate[a, c] += values[row, c]
        for c in range(rate.shape[1]):
            rate[a, c] /= V[a]


@kernel
def first_stage(dt, rate, saved, U):  # type: ignore[no-untyped-def]
    """``saved = U``, ``U += dt R`` for arrays ``(N, c)``."""
    for a in prange(len(U)):
        for k in range(U.shape[1]):
            saved[a, k] = U[a, k]
            U[a, k] += dt * rate[a, k]


@kernel
def second_stage(dt, rate, saved, U):  # type: ignore[no-untyped-def]
    """``U = U^n + 1/2 ((U - U^n) + dt R)``: exactly ``U^n`` where nothing changes."""
    for a in prange(len(U)):
        for k in range(U.shape[1]):
            U[a, k] = saved[a, k] + 0.5 * ((U[a, k] - saved[a, k]) + dt * rate[a, k])
