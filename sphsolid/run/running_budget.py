"""The budget of energy and momentum while a run goes on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.record.budget import NOT_TRACKED, Budget, MomentumBudget, NotTracked

Array = NDArray[np.float64]


class Works(Protocol):
    """What a time integrator adds up, stage by stage or step by step."""

    @property
    def by_name(self) -> dict[str, float]:
        """Works [J] of everything that acts on the body."""
        ...

    @property
    def impulse(self) -> Array:
        """``(2, 3)`` linear and angular impulse of everything from outside."""
        ...

    @property
    def traction_impulse(self) -> Array:
        """``(2, 3)`` that of the tractions alone."""
        ...

    @property
    def reaction(self) -> Array:
        """``(n, 3)`` [N s] impulse on each constrained point."""
        ...

    def arrays(self) -> dict[str, Array]:
        """The running totals, for a checkpoint."""
        ...


@dataclass(frozen=True)
class NotOpened:
    """Nobody asked where energy and momentum go."""

    is_open: bool = False

    def step(self, momentum: Callable[[], Array]) -> None:
        """Nothing."""

    def arrays(self) -> dict[str, Array]:
        """None."""
        return {}

    def now(self, reaction: Callable[[], Array]) -> NotTracked:
        """Nothing is known."""
        return NOT_TRACKED


class RunningBudget:
    """Works since the budget was opened, and the momentum they must explain step by step.

    ``by_face`` sums values of the constrained points ``(n, 3)`` over each constrained face.
    """

    is_open = True

    def __init__(
        self,
        works: Works,
        *,
        momentum: Array,
        energy: float,
        by_face: Callable[[Array], dict[str, Array]],
    ) -> None:
        self.works = works
        self._momentum = MomentumBudget(momentum)
        self._start_energy = np.array(energy)
        self._by_face = by_face

    def step(self, momentum: Callable[[], Array]) -> None:
        """Compare ``momentum() (2, 3)`` after a step with the impulses."""
        self._momentum.step(momentum(), self.works.impulse)

    def arrays(self) -> dict[str, Array]:
        """The running totals, for a checkpoint."""
        energy: dict[str, Any] = {"energy": self._start_energy}
        return self.works.arrays() | self._momentum.arrays() | energy

    def now(self, reaction: Callable[[], Array]) -> Budget:
        """The budget so far; ``reaction()`` are the forces [N] on constrained points."""
        return Budget(
            start_energy=float(self._start_energy),
            works=self.works.by_name,
            start_momentum=self._momentum.start,
            momentum=self._momentum.now,
            impulse=self.works.impulse,
            traction_impulse=self.works.traction_impulse.copy(),
            largest_step_drift=self._momentum.largest_step_drift,
            reaction_impulse=self._by_face(self.works.reaction),
            reaction_force=self._by_face(reaction()),
        )
