"""Works and impulses of a central-difference run: where energy and momentum go.

A load ``f`` does the work ``dt/2 (f_n + f_n+1) . v_half`` in a step, which is ``f`` averaged over
the step times the displacement ``dt v_half``; a constraint that changes nodal momenta by ``R`` the
work ``R . v_half`` with the velocity it prescribes there.  Linear and angular momentum then change
by exactly the impulses summed here; what energy misses is the oscillation of the integrator.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.essential import EssentialConditions
from fem_reference.loads import Load

Array = NDArray[np.float64]


def _moments(impulse: Array, x: Array) -> Array:
    return np.stack([impulse.sum(axis=0), np.cross(x, impulse).sum(axis=0)])


@dataclass(frozen=True)
class NoBudget:
    """Nobody asked where energy and momentum go."""

    def loads(self, x: Array, v_half: Array, half: float, t: float) -> None:
        """Nothing."""

    def impose(
        self, essential: EssentialConditions, x: Array, v: Array, t: float, *, at_half: bool
    ) -> None:
        """Impose the essential conditions, nothing else."""
        essential.apply(v, t)

    def mean_reaction(self, dt: float, before: Array) -> Array:
        """What it was ``before``: nobody asks."""
        return before


class StepBudget:
    """Totals since it was opened: works [J], impulses ``(2, 3)``, ``reaction (n, 3)`` [N s].

    ``mass (N, 1)`` [kg]; rows of impulses are linear [N s] and angular about the origin [N m s];
    ``reaction`` belongs to the constrained nodes, ``last_reaction`` to the last time they were
    imposed.
    """

    def __init__(
        self, loads: tuple[Load, ...], mass: Array, essential: EssentialConditions
    ) -> None:
        self._loads = loads
        self._mass = mass
        # Arrays without axes: totals that a checkpoint can write over.
        self.works = {name: np.zeros(()) for name in ("traction", "body_force", "constraint")}
        self.impulses = {name: np.zeros((2, 3)) for name in self.works}
        self.reaction = np.zeros((len(essential.nodes), 3))
        self.last_reaction = np.zeros_like(self.reaction)
        self._v_half = np.zeros_like(self.reaction)

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

    def loads(self, x: Array, v_half: Array, half: float, t: float) -> None:
        """Add the loads of time ``t`` over ``half`` [s] of a step, at positions ``x (N, 3)``."""
        for load in self._loads:
            name = "body_force" if load.what == "body force" else "traction"
            impulse = half * load.nodal_force(t)
            self.works[name] += float(np.sum(impulse * v_half))
            self.impulses[name] += _moments(impulse, x)

    def impose(
        self, essential: EssentialConditions, x: Array, v: Array, t: float, *, at_half: bool
    ) -> None:
        """Impose the essential conditions on ``v (N, 3)`` and keep the impulse that took.

        ``at_half``: ``v`` is the velocity in the middle of the step, with which nodes move.
        """
        nodes = essential.nodes
        before = v[nodes]
        essential.apply(v, t)
        self.last_reaction = self._mass[nodes] * (v[nodes] - before)
        if at_half:
            self._v_half = v[nodes]
        self.works["constraint"] += float(np.sum(self.last_reaction * self._v_half))
        self.impulses["constraint"] += _moments(self.last_reaction, x[nodes])
        self.reaction += self.last_reaction

    def mean_reaction(self, dt: float, before: Array) -> Array:
        """The mean force ``(n, 3)`` [N] of the constraints in the last half step."""
        return 2.0 / dt * self.last_reaction
