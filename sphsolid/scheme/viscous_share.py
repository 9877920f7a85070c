"""What the viscosity of a restraint is multiplied by where the body is strongly stretched.

The dissipation potential is one of ``d(F^T e)/dt``, so that it does not see a rigid rotation.  The
rate at which it damps an ``e`` grows with the square of the largest stretch, and a step allows
only so much damping.  With ``C = F^T F`` and ``c = (tr C^4)^(1/4)`` the potential is multiplied by
``most / c`` where ``c`` is above what the step allows, ``most``.  That ``c`` is never below the
square of the largest stretch, and above it by less than a third.  The potential stays invariant
and stays a square: both momenta are exact and energy is taken at any state.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined
from sphsolid.continuum.tensor import right_cauchy_green


@inlined
def viscous_share(F: Any, most: float) -> float:
    """``min(1, most / c)`` of nine numbers; ``most`` may be infinite."""
    c00, c11, c22, c01, c02, c12 = right_cauchy_green(F)
    # C C, and the sum of its squares.
    d00 = c00 * c00 + c01 * c01 + c02 * c02
    d11 = c01 * c01 + c11 * c11 + c12 * c12
    d22 = c02 * c02 + c12 * c12 + c22 * c22
    d01 = c00 * c01 + c01 * c11 + c02 * c12
    d02 = c00 * c02 + c01 * c12 + c02 * c22
    d12 = c01 * c02 + c11 * c12 + c12 * c22
    fourth = d00 * d00 + d11 * d11 + d22 * d22 + 2.0 * (d01 * d01 + d02 * d02 + d12 * d12)
    c = math.sqrt(math.sqrt(fourth))
    return 1.0 if c <= most else most / c


def viscous_shares(F: NDArray[np.float64], most: float) -> NDArray[np.float64]:
    """The same of tensors ``(..., 3, 3)``: ``(...)``."""
    C = np.swapaxes(F, -1, -2) @ F
    C2 = C @ C
    c = np.sum(C2 * C2, axis=(-2, -1)) ** 0.25
    return np.where(c <= most, 1.0, most / c)
