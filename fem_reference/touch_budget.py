"""Works and impulses of the finite volume method: where energy and momentum go.

The rate of ``sum V [rho0 |v|^2/2 + W(F)]`` follows from the rates by the chain rule; faces of the
boundary work with their ``v^C``, body forces and the projection with ``v_e``.  What is left is the
upwinding's, ``dissipation_p``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sphsolid.record.budget import WORKS

if TYPE_CHECKING:
    from fem_reference.constrained_touch import TouchCells, TouchRates

Array = NDArray[np.float64]


def _moments(impulse: Array, x: Array) -> Array:
    return np.stack([impulse.sum(axis=0), np.cross(x, impulse).sum(axis=0)])


@dataclass(frozen=True)
class NoTouchBudget:
    """Nobody asked where energy and momentum go."""

    def stage(
        self, cells: TouchCells, rates: TouchRates, v: Array, x: Array, arms: Array, t: float,
        dt: float,
    ) -> None:  # fmt: skip
        """Nothing."""


class TouchBudget:
    """Totals since it was opened: works [J], impulses ``(2, 3)``, ``reaction (n, 3)`` [N s]."""

    def __init__(self, cells: TouchCells) -> None:
        self.works = {name: np.zeros(()) for name in WORKS}
        self.impulses = {
            name: np.zeros((2, 3)) for name in ("traction", "body_force", "constraint")
        }
        self.reaction = np.zeros((len(cells.boundary.held), 3))

    @property
    def by_name(self) -> dict[str, float]:
        """Works [J] by name."""
        return {name: float(work) for name, work in self.works.items()}

    @property
    def traction_impulse(self) -> Array:
        """``(2, 3)`` that of the tractions alone."""
        return self.impulses["traction"]

    @property
    def impulse(self) -> Array:
        """``(2, 3)`` of everything from outside."""
        return np.asarray(sum(self.impulses.values()))

    def arrays(self) -> dict[str, Array]:
        """The running totals, for a checkpoint."""
        totals = {f"impulse_{name}": value for name, value in self.impulses.items()}
        works = {f"work_{name}": value for name, value in self.works.items()}
        return totals | works | {"reaction": self.reaction}

    def stage(
        self, cells: TouchCells, rates: TouchRates, v: Array, x: Array, arms: Array, t: float,
        dt: float,
    ) -> None:  # fmt: skip
        """Add ``dt`` [s] of a stage with velocities ``v``, nodes ``x`` and cells at ``arms``."""
        Q, V, rho = cells.boundary.Q, cells.maps.V[:, None], cells.material.density
        reaction = np.einsum("nij,nj->ni", Q, rates.force)
        given = rates.force - reaction
        body = V * rates.body
        power = {
            "traction": float(np.sum(given * rates.velocity)),
            "constraint": float(np.sum(reaction * rates.velocity)),
            "body_force": float(np.sum(body * v)),
            "projection": float(np.sum(rho * V * rates.change * v)),
        }
        P = cells.stress(*cells.strains(x))
        stored = float(np.sum(V[:, :, None] * P * cells.deformation(rates.x)))
        total = stored + float(np.sum(rho * V * rates.v * v))
        power["dissipation_p"] = total - sum(power.values())
        for name, value in power.items():
            self.works[name] += dt * value
        for name, force, at in (
            ("traction", given, rates.arms), ("constraint", reaction, rates.arms),
            ("body_force", body, arms),
        ):  # fmt: skip
            self.impulses[name] += _moments(dt * force, at)
        self.reaction += dt * reaction[cells.boundary.held]
