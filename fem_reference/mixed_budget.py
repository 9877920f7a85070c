"""Works and impulses of the stages of a mixed method: where energy and momentum go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.essential import EssentialConditions
from fem_reference.loads import Load
from sphsolid.record.budget import WORKS

Array = NDArray[np.float64]


def _moments(impulse: Array, x: Array) -> Array:
    return np.stack([impulse.sum(axis=0), np.cross(x, impulse).sum(axis=0)])


@dataclass(frozen=True)
class NoStageBudget:
    """Nobody asked where energy and momentum go."""

    looks = False

    def stage(
        self, x: Array, v: Array, dt: float, t: float, reaction: Array, powers: dict[str, float]
    ) -> None:
        """Nothing."""

    def impose(
        self, essential: EssentialConditions, x: Array, v: Array, t: float, share: float
    ) -> None:
        """Impose the essential conditions, nothing else."""
        essential.apply(v, t)


class MixedBudget:
    """Totals since it was opened: works [J], impulses ``(2, 3)``, ``reaction (n, 3)`` [N s].

    ``mass (N, 1)`` [kg]; ``constrained (n,)`` nodes.  Rows of impulses are linear [N s] and angular
    about the origin [N m s].
    """

    looks = True

    def __init__(
        self, loads: tuple[Load, ...], mass: Array, constrained: NDArray[np.int64]
    ) -> None:
        self._loads, self._mass, self._nodes = loads, mass, constrained
        self.works = {name: np.zeros(()) for name in WORKS}
        self.impulses = {
            name: np.zeros((2, 3)) for name in ("traction", "body_force", "constraint")
        }
        self.reaction = np.zeros((len(constrained), 3))

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
        self, x: Array, v: Array, dt: float, t: float, reaction: Array, powers: dict[str, float]
    ) -> None:
        """Add ``dt`` [s] of a stage with velocities ``v``, taken at positions ``x (N, 3)``.

        ``reaction (n, 3)`` [N] is what took the constrained rates away.
        """
        for name, power in powers.items():
            self.works[name] += dt * power
        for load in self._loads:
            name = "body_force" if load.what == "body force" else "traction"
            impulse = dt * load.nodal_force(t)
            self.works[name] += float(np.sum(impulse * v))
            self.impulses[name] += _moments(impulse, x)
        self._react(dt * reaction, v[self._nodes], x[self._nodes])

    def impose(
        self, essential: EssentialConditions, x: Array, v: Array, t: float, share: float
    ) -> None:
        """Impose the essential conditions; ``share`` of the jump of ``v`` ends in the step."""
        before = v[self._nodes]
        essential.apply(v, t)
        after = v[self._nodes]
        jump = share * self._mass[self._nodes] * (after - before)
        self._react(jump, after, x[self._nodes])

    def _react(self, impulse: Array, v: Array, x: Array) -> None:
        self.works["constraint"] += float(np.sum(impulse * v))
        self.reaction += impulse
        self.impulses["constraint"] += _moments(impulse, x)
