"""Loads that make the standing wave an exact motion of the full nonlinear solid.

With ``F(X, t) = I + grad u`` the balance of momentum (1a) of [Lee2017] asks for

    f0 = rho0 d2u/dt2 - DIV P,    (DIV P)_i = sum_I [ (dP/dF) : dF/dX_I ]_iI,

so only the tangent action of the law and the second derivatives of ``u`` enter; nothing is
differentiated numerically.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.law import tangent_action
from sphsolid.continuum.tensor import cofactor, determinant, join, split

Array = NDArray[np.float64]


def nonlinear_first_piola(material: Any, F: Array) -> Array:
    """``P(F, cof F, det F) (n, 3, 3)`` [Pa]."""
    entries = split(F)
    return join(law.first_piola(material, entries, cofactor(entries), determinant(entries)))


def manufactured_body_force(
    material: Any,
    X: Array,
    amplitude_now: float,
    coefficients: tuple[float, float, float],
    frequency: float,
) -> Array:
    """``f0 (n, 3)`` [N/m^3] of the standing wave whose amplitude is ``U0 cos(w t)`` now [m]."""
    force = np.empty_like(X)
    # The kernel is compiled for arrays that could be written to; what a scene is given cannot.
    points = np.require(X, requirements=("C", "W"))
    _body_force(material, points, amplitude_now, coefficients, frequency, force)
    return force


@kernel
def _body_force(material, X, U, ABC, w, force):  # type: ignore[no-untyped-def]
    k = 0.5 * math.pi
    A, B, C = U * ABC[0], U * ABC[1], U * ABC[2]
    for a in prange(X.shape[0]):
        s1, c1 = math.sin(k * X[a, 0]), math.cos(k * X[a, 0])
        s2, c2 = math.sin(k * X[a, 1]), math.cos(k * X[a, 1])
        s3, c3 = math.sin(k * X[a, 2]), math.cos(k * X[a, 2])
        ccc, ssc, scs, css = c1 * c2 * c3, s1 * s2 * c3, s1 * c2 * s3, c1 * s2 * s3
        scc, csc, ccs, sss = s1 * c2 * c3, c1 * s2 * c3, c1 * c2 * s3, s1 * s2 * s3
        F = (
            1.0 + k * A * ccc, -k * A * ssc, -k * A * scs,
            -k * B * ssc, 1.0 + k * B * ccc, -k * B * css,
            -k * C * scs, -k * C * css, 1.0 + k * C * ccc,
        )  # fmt: skip
        k2 = k * k
        F_X = (
            -k2 * A * scc, -k2 * A * csc, -k2 * A * ccs,
            -k2 * B * csc, -k2 * B * scc, k2 * B * sss,
            -k2 * C * ccs, k2 * C * sss, -k2 * C * scc,
        )  # fmt: skip
        F_Y = (
            -k2 * A * csc, -k2 * A * scc, k2 * A * sss,
            -k2 * B * scc, -k2 * B * csc, -k2 * B * ccs,
            k2 * C * sss, -k2 * C * ccs, -k2 * C * csc,
        )  # fmt: skip
        F_Z = (
            -k2 * A * ccs, k2 * A * sss, -k2 * A * scc,
            k2 * B * sss, -k2 * B * ccs, -k2 * B * csc,
            -k2 * C * scc, -k2 * C * csc, -k2 * C * ccs,
        )  # fmt: skip
        P_X = tangent_action(material, F, F_X)
        P_Y = tangent_action(material, F, F_Y)
        P_Z = tangent_action(material, F, F_Z)
        inertia = -material.density * w * w
        force[a, 0] = inertia * A * scc - (P_X[0] + P_Y[1] + P_Z[2])
        force[a, 1] = inertia * B * csc - (P_X[3] + P_Y[4] + P_Z[5])
        force[a, 2] = inertia * C * ccs - (P_X[6] + P_Y[7] + P_Z[8])
