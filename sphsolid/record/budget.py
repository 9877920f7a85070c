"""The energy and the momentum budget of a run: where both went since it was opened."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import read_only

Array = NDArray[np.float64]
#: Works that a recorder always reports; those that a method does not have are zero.
WORKS = (
    "traction", "body_force", "constraint", "projection", "adjoint_defect",
    "dissipation_p", "dissipation_J",
)  # fmt: skip


@dataclass(frozen=True)
class NotTracked:
    """The run keeps no budget: no recorder asked for one."""


NOT_TRACKED = NotTracked()


@dataclass(frozen=True)
class Budget:
    """Totals since the budget was opened.

    ``start_energy`` [J] kinetic and strain energy then; ``works`` [J] by name (:data:`WORKS` and
    those of a user's own terms), what a term takes away being negative; ``start_momentum,
    momentum, impulse (2, 3)``: linear [kg m/s] and angular [kg m^2/s] about the origin, then, now,
    and what loads and constraints gave; ``traction_impulse (2, 3)`` the part of the tractions;
    ``largest_step_drift (2,)`` the largest norm by which one step missed its impulse;
    ``reaction_impulse`` [N s] and ``reaction_force`` [N] ``(3,)`` on the body by constrained face,
    the force at the last stage taken.
    """

    start_energy: float
    works: dict[str, float]
    start_momentum: Array
    momentum: Array
    impulse: Array
    traction_impulse: Array
    largest_step_drift: Array
    reaction_impulse: dict[str, Array]
    reaction_force: dict[str, Array]

    def __post_init__(self) -> None:
        """Copies that cannot be written to: recorders share them, and the budget goes on."""
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value.copy()))
            elif isinstance(value, dict):
                made = {
                    name: read_only(part.copy()) if isinstance(part, np.ndarray) else part
                    for name, part in value.items()
                }
                object.__setattr__(self, each.name, made)

    @property
    def drift(self) -> Array:
        """``(2, 3)``: momentum now, less that at the start, less the impulse."""
        return self.momentum - self.start_momentum - self.impulse


class MomentumBudget:
    """Compares, step by step, the change of momentum with the impulse that was applied."""

    def __init__(self, momentum: Array) -> None:
        self.start = momentum.copy()
        self.now = momentum.copy()
        self.impulse = np.zeros((2, 3))
        self.largest_step_drift = np.zeros(2)

    def step(self, momentum: Array, impulse: Array) -> None:
        """``momentum (2, 3)`` after a step, ``impulse (2, 3)`` since the start."""
        missed = (momentum - self.now) - (impulse - self.impulse)
        size = np.linalg.norm(missed, axis=1)
        self.largest_step_drift = np.maximum(self.largest_step_drift, size)
        self.now, self.impulse = momentum.copy(), impulse.copy()

    def arrays(self) -> dict[str, Array]:
        """The running totals, for a checkpoint."""
        return {
            "start": self.start, "now": self.now, "impulse": self.impulse,
            "largest_step_drift": self.largest_step_drift,
        }  # fmt: skip


def total_momentum(V: Array, density: float, x: Array, velocity: Array) -> Array:
    """``(2, 3)``: linear ``sum V p`` and angular ``sum V x cross p`` about the origin."""
    weighted = (density * V)[:, None] * velocity
    return np.stack([weighted.sum(axis=0), np.cross(x, weighted).sum(axis=0)])
