"""Explicit central differences, in the velocity-Verlet form.

    v_half = v_n + dt/2 a_n,    x_n+1 = x_n + dt v_half,    v_n+1 = v_half + dt/2 a_n+1

Second order; symplectic, so the energy of a free body oscillates but does not drift; with a
lumped mass and an internal force that has no resultant moment it conserves linear and angular
momentum to round-off, because a kick adds ``sum x_n x f_n = 0`` and a drift ``dt sum v x m v = 0``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fem_reference.account import Account, NoAccount
from fem_reference.essential import EssentialConditions
from fem_reference.updates import add_scaled

Array = NDArray[np.float64]


def central_difference_step(
    x: Array,
    velocity: Array,
    acceleration: Array,
    *,
    t: float,
    dt: float,
    accelerate: Callable[[Array, float, Array], None],
    essential: EssentialConditions,
    account: Account | NoAccount,
) -> None:
    """Advance ``x``, ``velocity``, ``acceleration`` ``(N, 3)`` in place from ``t`` to ``t + dt``.

    ``accelerate(x, t, a)`` writes ``a = (f_external(t) - f_internal(x)) / m``.  One call of it a
    step: the acceleration at the end of a step is the one at the start of the next.  Components
    that constraints prescribe are overwritten in the velocities, which is the same as projecting
    the acceleration.  ``account`` is told of every load and every reaction.
    """
    add_scaled(0.5 * dt, acceleration, velocity)
    account.impose(essential, x, velocity, t + 0.5 * dt, at_half=True)
    account.loads(x, velocity, 0.5 * dt, t)
    add_scaled(dt, velocity, x)
    account.loads(x, velocity, 0.5 * dt, t + dt)
    accelerate(x, t + dt, acceleration)
    add_scaled(0.5 * dt, acceleration, velocity)
    account.impose(essential, x, velocity, t + dt, at_half=False)
