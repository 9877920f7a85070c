"""The scheme of the paper in plain numpy: dense matrices, Levi-Civita sums, no compiled code.

Written from the equations, sharing nothing with ``sphsolid.scheme`` or ``sphsolid.continuum``.
Readable and slow on purpose: it judges the kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EPS = np.zeros((3, 3, 3))
EPS[0, 1, 2] = EPS[1, 2, 0] = EPS[2, 0, 1] = 1.0
EPS[0, 2, 1] = EPS[2, 1, 0] = EPS[1, 0, 2] = -1.0


def cross(A: Array, B: Array) -> Array:
    """``(A x B)_iI = eps_ijk eps_IJK A_jJ B_kK``."""
    return np.einsum("ijk,IJK,njJ,nkK->niI", EPS, EPS, A, B, optimize=True)


def cof(F: Array) -> Array:
    return 0.5 * cross(F, F)


def contract(A: Array, B: Array) -> Array:
    return np.einsum("niI,niI->n", A, B)


@dataclass(frozen=True)
class MooneyRivlin:
    """Eq. (7); ``mu`` serves only as the default ``alpha`` of (27)."""

    varsigma: float
    xi: float
    kappa: float
    mu: float

    def conjugate(self, F: Array, H: Array, J: Array) -> tuple[Array, Array, Array]:
        """Eq. (8), differentiated by hand from (7)."""
        I1, I2 = contract(F, F), contract(H, H)
        by_F = (2.0 * self.varsigma * J ** (-2 / 3))[:, None, None] * F
        by_H = (3.0 * self.xi * J**-2.0 * I2**0.5)[:, None, None] * H
        by_J = (
            -2 / 3 * self.varsigma * J ** (-5 / 3) * I1
            - 2.0 * self.xi * J**-3.0 * I2**1.5
            + self.kappa * (J - 1.0)
        )
        return by_F, by_H, by_J

    def first_piola(self, F: Array, H: Array, J: Array) -> Array:
        """Eq. (9)."""
        by_F, by_H, by_J = self.conjugate(F, H, J)
        return by_F + cross(by_H, F) + by_J[:, None, None] * H

    def hessian(
        self, F: Array, H: Array, J: Array, dF: Array, dH: Array, dJ: Array
    ) -> tuple[Array, Array, Array]:
        """Eqs. (10)-(12), as the complex-step derivative of (8)."""
        e = 1e-30j
        moved = self.conjugate(F + e * dF, H + e * dH, J + e * dJ)
        return tuple(np.imag(part) / 1e-30 for part in moved)


@dataclass(frozen=True)
class Body:
    """A discretised body.  ``G[b, a] = G_a(X_b)``; ``held`` marks prescribed components."""

    law: MooneyRivlin
    density: float
    V: Array
    G_kinematic: Array
    G_force: Array
    V_q: Array
    G_q: Array
    W_q: Array
    loads: Callable[[float], tuple[Array, Array]]  # E_a, f0_a
    held: NDArray[np.bool_]
    velocity: Callable[[float], Array]


@dataclass(frozen=True)
class Options:
    """``form``: none, simplified (27), hessian (22)-(23), strains (28); times in units of dt.

    ``gamma``, ``alpha`` [Pa] of (27), the bulk and shear modulus where none is given.
    """

    evolved: str
    form: str
    tau: tuple[float, float, float] = (1.0, 0.0, 0.0)
    xi: tuple[float, float, float] = (0.1, 0.0, 0.0)
    tau_p: float = 0.0
    projects: bool = True
    gamma: float | None = None
    alpha: float | None = None


@dataclass(frozen=True)
class Fields:
    p: Array
    x: Array
    F: Array
    H: Array
    J: Array


@dataclass(frozen=True)
class Rates:
    """``p`` is ``E - T + D_p`` without the held components, ``J`` holds ``D_J``."""

    p: Array
    F: Array
    H: Array
    J: Array
    T: Array
    P: Array
    D_p: Array
    D_J: Array
    P_fine: Array


def gradient(f: Array, G: Array) -> Array:
    """Eq. (30): ``sum_a f_a (x) G_a(X_b)``."""
    return np.einsum("ai,bak->bik", f, G)


def project(P: Array, F_x: Array) -> Array:
    """The nearest ``P^C`` with ``E : (P^C F_x^T) = 0``: orthogonal to the rows of one matrix."""
    C = np.einsum("mjk,nkI->nmjI", EPS, F_x).reshape(-1, 3, 9)
    flat = P.reshape(-1, 9, 1)
    normal = np.linalg.solve(C @ C.transpose(0, 2, 1), C @ flat)
    return (flat - C.transpose(0, 2, 1) @ normal).reshape(P.shape)


def dependent(body: Body, o: Options, F: Array, H: Array, J: Array) -> tuple[Array, Array]:
    """``H`` and ``J`` as evolved, or from ``F``."""
    return (H if "H" in o.evolved else cof(F)), (J if "J" in o.evolved else np.linalg.det(F))


def fine_stress(
    law: MooneyRivlin, o: Options, dt: float, L: Array, F_x: Array, at_q: Fields, rate_at_q: Fields
) -> Array:
    """``P_fine`` before projection from interpolated fields ``at_q`` and rates ``rate_at_q``."""
    F = at_q.F
    has_H, has_J = "H" in o.evolved, "J" in o.evolved
    H = at_q.H if has_H else cof(F)
    J = at_q.J if has_J else np.linalg.det(F)
    R_F, R_Fx = L - rate_at_q.F, F_x - F
    gamma = law.kappa if o.gamma is None else o.gamma
    alpha = law.mu if o.alpha is None else o.alpha
    if o.form == "simplified":
        return o.tau[0] * dt * gamma * R_F + o.xi[0] * alpha * R_Fx
    R_H = cross(F, L) - (rate_at_q.H if has_H else cross(F, rate_at_q.F))
    R_J = contract(H, L) - (rate_at_q.J if has_J else contract(H, rate_at_q.F))
    tau_F, tau_H, tau_J = (tau * dt for tau in o.tau)
    if o.form == "hessian":
        S_F, S_H, S_J = law.hessian(F, H, J, tau_F * R_F, tau_H * R_H, tau_J * R_J)
        fine = S_F + cross(S_H, F) + S_J[:, None, None] * H
        return fine + o.xi[0] * alpha * R_Fx
    F_st = F + tau_F * R_F + o.xi[0] * R_Fx
    H_st = H + tau_H * R_H + o.xi[1] * (cof(F_x) - H) if has_H else cof(F_st)
    J_st = J + tau_J * R_J + o.xi[2] * (np.linalg.det(F_x) - J) if has_J else np.linalg.det(F_st)
    return law.first_piola(F_st, H_st, J_st) - law.first_piola(F, H, J)


def rates(body: Body, o: Options, U: Fields, x: Array, dt: float, t: float) -> Rates:
    """Eqs. (31)-(36) at time ``t``; ``x`` are the positions that the projection uses."""
    v = U.p / body.density
    L = gradient(v, body.G_kinematic)
    H, J = dependent(body, o, U.F, U.H, U.J)
    Hdot, Jdot = cross(U.F, L), contract(H, L)
    P = body.law.first_piola(U.F, H, J)
    if o.projects:
        P = project(P, gradient(x, body.G_force))
    T = np.einsum("b,bij,baj->ai", body.V, P, body.G_force) / body.V[:, None]
    E, f0 = body.loads(t)
    pdot = np.where(body.held, 0.0, E - T)
    D_p, D_J, P_fine = np.zeros_like(U.p), np.zeros(len(U.p)), np.zeros((len(body.V_q), 3, 3))
    if o.form != "none":
        F_xq = gradient(x, body.G_q)
        interpolate = [np.tensordot(body.W_q, f, 1) for f in (U.F, H, J, L, Hdot, Jdot)]
        at_q = Fields(U.p, U.x, *interpolate[:3])
        rate_at_q = Fields(U.p, U.x, *interpolate[3:])
        P_fine = fine_stress(body.law, o, dt, gradient(v, body.G_q), F_xq, at_q, rate_at_q)
        if o.projects:
            P_fine = project(P_fine, F_xq)
        D_p = -np.einsum("q,qij,qaj->ai", body.V_q, P_fine, body.G_q) / body.V[:, None]
        # R_p = DIV P + f0 - dp/dt, the rate being the Galerkin one.
        R_p = np.einsum("aij,qaj->qi", P, body.G_q) + body.W_q @ (f0 - pdot)
        flux = np.einsum("qij,qi->qj", cof(F_xq), R_p) * o.tau_p * dt / body.density
        D_J = -np.einsum("q,qj,qaj->a", body.V_q, flux, body.G_q) / body.V
    return Rates(
        np.where(body.held, 0.0, E - T + D_p), L, Hdot, Jdot + D_J, T, P, D_p, D_J, P_fine
    )


def step(body: Body, o: Options, U: Fields, dt: float, t: float) -> Fields:
    """One TVD-RK2 step; ``x^{n+1} = x^n + dt (p^n + p*) / (2 rho0)`` is known before stage two."""

    def euler(U: Fields, r: Rates, t_end: float) -> Fields:
        p = np.where(body.held, body.density * body.velocity(t_end), U.p + dt * r.p)
        return Fields(p, U.x, U.F + dt * r.F, U.H + dt * r.H, U.J + dt * r.J)

    def fibre_map(U: Fields, x: Array) -> Fields:
        return U if "F" in o.evolved else replace(U, F=gradient(x, body.G_kinematic))

    U = fibre_map(U, U.x)
    star = euler(U, rates(body, o, U, U.x, dt, t), t + dt)
    x_new = U.x + dt / (2.0 * body.density) * (U.p + star.p)
    star = fibre_map(star, U.x + dt / body.density * U.p)
    end = euler(star, rates(body, o, star, x_new, dt, t + dt), t + dt)
    half = {name: 0.5 * (getattr(U, name) + getattr(end, name)) for name in ("p", "F", "H", "J")}
    half["p"] = np.where(body.held, body.density * body.velocity(t + dt), half["p"])
    return fibre_map(Fields(x=x_new, **half), x_new)
