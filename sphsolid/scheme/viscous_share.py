"""What the viscosity of a restraint is multiplied by where the body is strongly stretched.

The dissipation potential is one of ``d(F^T e)/dt``, so that it does not see a rigid rotation.  The
rate at which it damps an ``e`` grows with the squares of stretches, and a step allows only so much
damping.  Where ``|F|^2`` is beyond :data:`SQUARE` the potential is divided by what it is beyond.
It stays invariant and stays a square: both momenta are exact and energy is taken at any state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import inlined

#: ``|F|^2`` of a solid that keeps its volume and is stretched to twice its length.
SQUARE = 5.0


@inlined
def viscous_share(F: Any) -> float:
    """``min(1, SQUARE / |F|^2)`` of nine numbers."""
    square = (
        F[0] * F[0] + F[1] * F[1] + F[2] * F[2]
        + F[3] * F[3] + F[4] * F[4] + F[5] * F[5]
        + F[6] * F[6] + F[7] * F[7] + F[8] * F[8]
    )  # fmt: skip
    return SQUARE / max(square, SQUARE)


def viscous_shares(F: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same of tensors ``(..., 3, 3)``: ``(...)``."""
    return np.asarray(SQUARE / np.maximum(np.sum(F * F, axis=(-2, -1)), SQUARE))
