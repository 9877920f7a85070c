"""Explicit central differences, in the velocity-Verlet form.

    v_half = v_n + dt/2 a_n,    x_n+1 = x_n + dt v_half,    v_n+1 = v_half + dt/2 a_n+1

Second order; symplectic, so the energy of a free body oscillates but does not drift; with a
lumped mass and an internal force that has no resultant moment it conserves linear and angular
momentum to round-off, because a kick adds ``sum x_n x f_n = 0`` and a drift ``dt sum v x m v = 0``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.energy_budget import NoBudget, StepBudget
from fem_reference.essential import EssentialConditions
from fem_reference.updates import add_scaled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """Positions [m], velocities [m/s] and accelerations [m/s^2] of the nodes, ``(N, 3)`` each."""

    x: Array
    v: Array
    a: Array


def central_difference_step(
    motion: Motion,
    *,
    t: float,
    dt: float,
    accelerate: Callable[[Array, float, Array], None],
    essential: EssentialConditions,
    budget: StepBudget | NoBudget,
) -> None:
    """Advance ``motion`` in place from ``t`` to ``t + dt`` [s].

    ``accelerate(x, t, a)`` writes ``a = (f_external(t) - f_internal(x)) / m``.  One call of it a
    step: the acceleration at the end of a step is the one at the start of the next.  Components
    that constraints prescribe are overwritten in the velocities, which is the same as projecting
    the acceleration.  ``budget`` is told of every load and every reaction.
    """
    x, v, a = motion.x, motion.v, motion.a
    add_scaled(0.5 * dt, a, v)
    budget.impose(essential, x, v, t + 0.5 * dt, at_half=True)
    budget.loads(x, v, 0.5 * dt, t)
    add_scaled(dt, v, x)
    budget.loads(x, v, 0.5 * dt, t + dt)
    accelerate(x, t + dt, a)
    add_scaled(0.5 * dt, a, v)
    budget.impose(essential, x, v, t + dt, at_half=False)
