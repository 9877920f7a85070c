"""How fast waves travel: the exact acoustic tensor, and the rule that sets the time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sphsolid.compiled import register_jitable
from sphsolid.continuum.law import tangent_action
from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.tensor import Tensor, split

#: A fibre shorter than this share of its length is taken as a lost solution: the stable step
#: shrinks with it, so a run that has blown up would otherwise creep on for ever.
THINNEST = 5.0e-3


def reference_p_wave_speed(material: Any) -> float:
    """``c_p = sqrt((lambda + 2 mu) / rho0)`` [m/s] of the undeformed solid."""
    return math.sqrt(
        (first_lame(material.mu, material.kappa) + 2.0 * material.mu) / material.density
    )


def acoustic_tensor(material: Any, F: Any, N: Any) -> Any:
    """``Q_ij(N) = A_iIjJ N_I N_J`` [Pa], ``A = dP/dF``; shapes ``F (..., 3, 3)``, ``N (3,)``.

    Its eigenvalues are ``rho0 c^2`` of the plane waves along the material direction ``N``.
    """
    entries = split(np.asarray(F, dtype=float))
    N = np.asarray(N, dtype=float)
    shape = np.shape(entries[0])
    Q = np.empty((*shape, 3, 3))
    for j in range(3):
        dyad = np.zeros((3, 3))
        dyad[j] = N
        dF = tuple(np.full(shape, value) for value in dyad.ravel())
        dP = tangent_action(material, entries, dF)
        for i in range(3):
            Q[..., i, j] = sum(dP[3 * i + k] * N[k] for k in range(3))
    return Q


def wave_speeds(material: Any, F: Any, N: Any) -> Any:
    """Three plane-wave speeds ``(..., 3)`` [m/s] along ``N``, ascending.

    A state that lost ellipticity has a negative eigenvalue; its speed is returned as ``nan``.
    """
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.linalg.eigvalsh(acoustic_tensor(material, F, N)) / material.density)


@register_jitable
def smallest_stretch(F: Tensor) -> float:
    """Smallest principal stretch: the square root of the least eigenvalue of ``F^T F``.

    Closed trigonometric form for a symmetric 3x3 matrix; ``nan`` in gives ``nan`` out.
    """
    c00 = F[0] * F[0] + F[3] * F[3] + F[6] * F[6]
    c11 = F[1] * F[1] + F[4] * F[4] + F[7] * F[7]
    c22 = F[2] * F[2] + F[5] * F[5] + F[8] * F[8]
    c01 = F[0] * F[1] + F[3] * F[4] + F[6] * F[7]
    c02 = F[0] * F[2] + F[3] * F[5] + F[6] * F[8]
    c12 = F[1] * F[2] + F[4] * F[5] + F[7] * F[8]
    mean = (c00 + c11 + c22) / 3.0
    d0 = c00 - mean
    d1 = c11 - mean
    d2 = c22 - mean
    p2 = d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * (c01 * c01 + c02 * c02 + c12 * c12)
    p = math.sqrt(p2 / 6.0)
    if p <= 1.0e-14 * mean:
        return math.sqrt(mean)
    det = (
        d0 * (d1 * d2 - c12 * c12)
        - c01 * (c01 * d2 - c12 * c02)
        + c02 * (c01 * c12 - d1 * c02)
    )  # fmt: skip
    r = det / (2.0 * p * p * p)
    if r > 1.0:
        r = 1.0
    elif r < -1.0:
        r = -1.0
    angle = math.acos(r) / 3.0 + 2.0 * math.pi / 3.0
    least = mean + 2.0 * p * math.cos(angle)
    return math.sqrt(least) if least > 0.0 else 0.0 * least
