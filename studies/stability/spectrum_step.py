"""The linear map of one step of any integrator, made from the linear rates.

A disturbance is an array ``Y (..., n, k)``, ``k`` disturbances side by side, with rows

    w   displacement that the strains follow, ``F = F_0 + sum w (x) G``
    v   velocity
    J   volume map, where it is not tied to ``w``
    x   positions that ``F_x`` is taken from, where they are not ``w``

and ``rate(S, x)`` gives the rates of ``S = (w, v, J)``.  TVD-RK2 moves ``x`` and ``w`` alike.
So does position Verlet, whose drift moves ``J`` by ``H : grad v`` alone: that part of the rates is
``coarse(S)``, the rates without any intrinsic time.
SSP-RK3 moves ``x`` by the weights that keep angular momentum, not by its own; the two differ by
``O(dt^4)`` a step.  So ``x`` has rows of its own if its disturbance is felt at all (``xi_F > 0``, a
stress, no projection), and formulations without ``F`` have ``w = x`` at every stage.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid import SSPRK3, TVDRK2, PositionVerlet
from sphsolid.defaults import Integrator
from sphsolid.errors import InputError

Block = NDArray[Any]
Rate = Callable[[Block, Block], Block]
CoarseRate = Callable[[Block], Block]


@dataclass(frozen=True)
class Layout:
    """``moves`` rows of ``w`` and of ``v``, ``size`` rows with ``J``; what ``x`` does."""

    moves: int
    size: int
    strains_follow_x: bool
    own_x: bool

    @property
    def rows(self) -> int:
        """Rows of a disturbance."""
        return self.size + (self.moves if self.own_x else 0)

    def velocity(self, S: Block) -> Block:
        """Rows ``v``."""
        return S[..., self.moves : 2 * self.moves, :]

    def position(self, Y: Block) -> Block:
        """Rows ``x``, or ``w`` in their place."""
        return Y[..., self.size :, :] if self.own_x else Y[..., : self.moves, :]


def step_map(
    integrator: Integrator, layout: Layout, rate: Rate, coarse: CoarseRate, Y: Block, cfl: float
) -> Block:
    """``Y`` after one step of ``cfl`` units of time."""
    if isinstance(integrator, TVDRK2):
        return _two_stages(layout, rate, Y, cfl)
    if isinstance(integrator, SSPRK3):
        return _three_stages(layout, rate, Y, cfl)
    if isinstance(integrator, PositionVerlet):
        return _drift_kick_drift(layout, rate, coarse, Y, cfl)
    raise InputError(
        f"integrator {integrator!r} has no linear map; use TVDRK2(), SSPRK3() or "
        "PositionVerlet()"
    )


def _two_stages(layout: Layout, rate: Rate, Y: Block, c: float) -> Block:
    x, v = layout.position(Y), layout.velocity(Y)
    star = Y + c * rate(Y, x)
    ahead = x + 0.5 * c * (v + layout.velocity(star))
    return 0.5 * (Y + star + c * rate(star, ahead))


def _drift_kick_drift(
    layout: Layout, rate: Rate, coarse: CoarseRate, Y: Block, c: float
) -> Block:
    m = layout.moves

    def by_velocity(S: Block) -> Block:
        alone = np.zeros_like(S)
        alone[..., m : 2 * m, :] = layout.velocity(S)
        moved = coarse(alone)
        # A velocity does work against no stress at rest, but it does change w and J.
        moved[..., m : 2 * m, :] = 0.0
        return moved

    half = Y + 0.5 * c * by_velocity(Y)
    kick = rate(half, layout.position(half)) - by_velocity(half)
    end = half + c * kick
    return end + 0.5 * c * by_velocity(end)


def _three_stages(layout: Layout, rate: Rate, Y: Block, c: float) -> Block:
    start, x = Y[..., : layout.size, :], layout.position(Y)
    v = layout.velocity(start)

    def tied(S: Block, y: Block) -> Block:
        if not layout.strains_follow_x:
            return S
        return np.concatenate([y, S[..., layout.moves :, :]], axis=-2)

    first = start + c * rate(start, x)
    v_first = layout.velocity(first)
    y = x + c / 6.0 * (5.0 * v + v_first)
    first = tied(first, y)
    second = 0.75 * start + 0.25 * (first + c * rate(first, y))
    y = x + c * (2.0 / 3.0 * v + v_first / 6.0 - layout.velocity(second) / 3.0)
    second = tied(second, y)
    end = start / 3.0 + 2.0 / 3.0 * (second + c * rate(second, y))
    y = y + 0.5 * c * layout.velocity(end)
    end = tied(end, y)
    return np.concatenate([end, y], axis=-2) if layout.own_x else end
