"""How fast waves travel: the exact acoustic tensor, and the rule that sets the time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sphsolid.compiled import inlined
from sphsolid.continuum.law import tangent_action, volumetric_stiffness
from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.tensor import IDENTITY, Tensor, right_cauchy_green, split

#: A fibre shorter than this share of its length is taken as a diverged solution: the stable step
#: shrinks with it, so a run that has blown up would otherwise creep on for ever.
THINNEST = 5.0e-3


#: So much may a volume grow before the step has to follow it.  The volumetric part of the acoustic
#: tensor is ``U'' |cof F N|^2``, so that the fastest wave is ``J / (smallest stretch)`` times that
#: of the undeformed solid.  The default CFL number, 0.7, leaves room for this much of it to the
#: 0.75 up to which the rhythm of the restraint's viscosity is proven, which spares all that is
#: nearly incompressible a shorter step.
GROWN = 1.07


@inlined
def step_share(stretch: Any, J: Any) -> Any:
    """``stretch / max(1, J / GROWN)``: the stable step of a particle over the undeformed one.

    ``stretch`` is its smallest, ``J`` its Jacobian, by which the paper's ``c_p / stretch`` lacks a
    factor where the volume grows.
    """
    slower = J * (1.0 / GROWN)
    return stretch / slower if slower > 1.0 else stretch


#: Axes and diagonals, along which an undeformed solid is asked for its fastest wave.
_DIRECTIONS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], dtype=float
)
#: The stated moduli stand where the law's stiffness is theirs to this share.
_ROUND_OFF = 1.0e-6


def moduli_at_rest(material: Any) -> tuple[float, float]:
    """``mu, kappa`` [Pa] of small strains, asked from the law.

    The stated ``mu`` and ``kappa`` where the law agrees with them, as ``check_law`` wants it to.
    """
    shear = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    mu = float(tangent_action(material, IDENTITY, shear)[1])
    kappa = float(volumetric_stiffness(material, 1.0))
    stated = material.mu, material.kappa
    close = _ROUND_OFF * (mu + kappa)
    if abs(mu - stated[0]) <= close and abs(kappa - stated[1]) <= close:
        return stated
    return mu, kappa


def reference_p_wave_speed(material: Any) -> float:
    """``c_p = sqrt((lambda + 2 mu) / rho0)`` [m/s] of the undeformed solid.

    Of a law whose stiffness is not that of its ``mu`` and ``kappa``, the fastest wave along the
    axes and diagonals.
    """
    stated = math.sqrt(
        (first_lame(material.mu, material.kappa) + 2.0 * material.mu) / material.density
    )
    unit = _DIRECTIONS / np.linalg.norm(_DIRECTIONS, axis=1)[:, None]
    asked = max(float(wave_speeds(material, np.eye(3), N)[-1]) for N in unit)
    return stated if abs(asked - stated) <= _ROUND_OFF * stated else asked


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


@inlined
def smallest_stretch(F: Tensor) -> float:
    """Smallest principal stretch: the square root of the least eigenvalue of ``F^T F``.

    The eigenvalues of ``C = m I + d B`` with ``tr B = 0``, ``B : B = 6`` are ``m + d x`` with ``x``
    a root of ``x^3 - 3 x = det B``.  Newton's method finds the least one, which lies in
    ``[-2, -1]``: no trigonometric function keeps a loop from working on several particles at once.
    ``nan`` in gives ``nan`` out.
    """
    c00, c11, c22, c01, c02, c12 = right_cauchy_green(F)
    mean = (c00 + c11 + c22) / 3.0
    d0 = c00 - mean
    d1 = c11 - mean
    d2 = c22 - mean
    p2 = d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * (c01 * c01 + c02 * c02 + c12 * c12)
    d = math.sqrt(p2 / 6.0)
    det = (
        d0 * (d1 * d2 - c12 * c12)
        - c01 * (c01 * d2 - c12 * c02)
        + c02 * (c01 * c12 - d1 * c02)
    )  # fmt: skip
    # Half of det B; a multiple of the identity has d = 0 and no B, and any root will do.
    r = det / (2.0 * d * d * d + 1.0e-300)
    r = 1.0 if r > 1.0 else r
    r = -1.0 if r < -1.0 else r
    # Exact at both ends, to 1 % between; the root is double at r = 1, hence the square root.
    half = math.sqrt(0.5 * (1.0 - r))
    x = -1.0 - 2.0 / math.sqrt(3.0) * half * (1.0 - (1.0 - 0.5 * math.sqrt(3.0)) * half)
    for _ in range(4):
        x = x - (x * x * x - 3.0 * x - 2.0 * r) / (3.0 * x * x - 3.0 + 1.0e-300)
    least = mean + d * x
    return math.sqrt(least) if least > 0.0 else 0.0 * least
