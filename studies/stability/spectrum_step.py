"""The linear map of one step of any integrator, made from the linear rates.

A disturbance is an array ``Y (..., n, k)``, ``k`` disturbances side by side, with rows

    w   displacement that the strains follow, ``F = F_0 + sum w (x) G``
    v   velocity
    J   volume map, where it is not tied to ``w``
    x   positions that ``F_x`` is taken from, where they are not ``w``

and ``A S + B x`` are the rates of ``S = (w, v, J)``.  TVD-RK2 moves ``x`` and ``w`` alike.
So does position Verlet, whose drift moves ``w`` and ``J`` by ``grad v`` alone: that part of the
rates is in ``coarse``, the rates without any intrinsic time.
SSP-RK3 moves ``x`` by the weights that keep angular momentum, not by its own; the two differ by
``O(dt^4)`` a step.  So ``x`` has rows of its own if its disturbance is felt at all (``xi_F > 0``, a
stress, no projection), and formulations without ``F`` have ``w = x`` at every stage.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid import SSPRK3, SUPG, TVDRK2, OfStep, PositionVerlet, SymplecticRKN4
from sphsolid.defaults import Integrator
from sphsolid.errors import InputError
from sphsolid.scheme.stabilisation import Stabilisation
from sphsolid.scheme.symplectic_rkn4 import DRIFTS, KICKS

Block = NDArray[Any]


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


@dataclass(frozen=True)
class Rates:
    """``A (..., n, n)`` by the state, ``B (..., n, m)`` by the geometry; ``coarse`` as ``A``."""

    A: Block
    B: Block
    coarse: Block

    def of(self, S: Block, x: Block) -> Block:
        """``A S + B x``."""
        return self.A @ S + self.B @ x


def step_matrix(integrator: Integrator, layout: Layout, rates: Rates, cfl: float) -> Block:
    """The map ``(..., rows, rows)`` of one step of ``cfl`` units of time."""
    unit = np.broadcast_to(np.eye(layout.rows), (*rates.A.shape[:-2], layout.rows, layout.rows))
    if isinstance(integrator, TVDRK2):
        return _two_stages(layout, rates, unit, cfl)
    if isinstance(integrator, SSPRK3):
        return _three_stages(layout, rates, unit, cfl)
    if isinstance(integrator, PositionVerlet):
        return _composed(layout, rates, unit, cfl, (0.5, 0.5), (1.0,))
    if isinstance(integrator, SymplecticRKN4):
        return _composed(layout, rates, unit, cfl, DRIFTS, KICKS)
    raise InputError(
        f"integrator {integrator!r} has no linear map; use PositionVerlet(), SymplecticRKN4(), "
        "SSPRK3() or TVDRK2()"
    )


def _two_stages(layout: Layout, rates: Rates, Y: Block, c: float) -> Block:
    x, v = layout.position(Y), layout.velocity(Y)
    star = Y + c * rates.of(Y, x)
    ahead = x + 0.5 * c * (v + layout.velocity(star))
    return 0.5 * (Y + star + c * rates.of(star, ahead))


def _composed(
    layout: Layout,
    rates: Rates,
    Y: Block,
    c: float,
    drifts: tuple[float, ...],
    kicks: tuple[float, ...],
) -> Block:
    m = layout.moves
    # A velocity does work against no stress at rest, but it does change w and J.
    drift = np.zeros_like(rates.coarse)
    drift[..., :, m : 2 * m] = rates.coarse[..., :, m : 2 * m]
    drift[..., m : 2 * m, :] = 0.0
    for a, b in zip(drifts[:-1], kicks, strict=True):
        Y = Y + a * c * (drift @ Y)
        Y = Y + b * c * (rates.of(Y, layout.position(Y)) - drift @ Y)
    return Y + drifts[-1] * c * (drift @ Y)


def _three_stages(layout: Layout, rates: Rates, Y: Block, c: float) -> Block:
    start, x = Y[..., : layout.size, :], layout.position(Y)
    v = layout.velocity(start)

    def tied(S: Block, y: Block) -> Block:
        if not layout.strains_follow_x:
            return S
        return np.concatenate([y, S[..., layout.moves :, :]], axis=-2)

    first = start + c * rates.of(start, x)
    y = x + c / 6.0 * (5.0 * v + layout.velocity(first))
    v_first = layout.velocity(first)
    first = tied(first, y)
    second = 0.75 * start + 0.25 * (first + c * rates.of(first, y))
    y = x + c * (2.0 / 3.0 * v + v_first / 6.0 - layout.velocity(second) / 3.0)
    second = tied(second, y)
    end = start / 3.0 + 2.0 / 3.0 * (second + c * rates.of(second, y))
    y = y + 0.5 * c * layout.velocity(end)
    end = tied(end, y)
    return np.concatenate([end, y], axis=-2) if layout.own_x else end


# --- how the rates depend on the length of the step ---------------------------------------------


def nodes(stabilisation: Stabilisation) -> tuple[float, ...]:
    """CFL numbers at which the rates are taken: as many as their polynomial in it needs.

    They depend on it through intrinsic times of the step alone: ``D(p)`` is linear in its time,
    ``D(J)`` in its own and, in the self-adjoint form, in both.
    """
    if not isinstance(stabilisation, SUPG):
        return (1.0,)
    grow = {
        name: isinstance(time, OfStep) and time.c > 0.0
        for name, time in stabilisation.intrinsic_times.items()
    }
    degree = int(grow.pop("tau_p")) + int(any(grow.values()))
    if not stabilisation.is_self_adjoint:
        degree = min(degree, 1)
    return ((1.0,), (0.5, 1.0), (0.25, 0.5, 1.0))[degree]


def interpolated(at_nodes: NDArray[Any], places: tuple[float, ...], cfl: float) -> NDArray[Any]:
    """The polynomial through ``at_nodes (n, ...)`` at the CFL numbers ``places (n,)``."""
    weights = [
        np.prod([(cfl - other) / (node - other) for other in places if other != node])
        for node in places
    ]
    return np.asarray(np.tensordot(np.array(weights), at_nodes, axes=1))
