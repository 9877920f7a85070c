"""What the loop over time and its files need of a method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from numpy.typing import NDArray

from sphsolid.record.placement import Placement
from sphsolid.record.positions import PositionWatch
from sphsolid.record.samples import Samples
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene


class Solver(Protocol):
    """A method that can be advanced, looked at, and put back where it was."""

    scene: Scene
    time: float
    step: int
    positions: PositionWatch

    @property
    def name(self) -> str:
        """Scene and method in a file-name friendly form."""
        ...

    def stable_time_step(self) -> float:
        """Largest step [s] allowed now; raises ``Diverged`` when the state is invalid."""
        ...

    def advance(self, dt: float) -> None:
        """One step of length ``dt`` [s].

        ``dt`` may be shorter than the stable step for a record's sake, so no coefficient of the
        method may depend on it: see ``scheme.intrinsic_time``.
        """
        ...

    def placement(self) -> Placement:
        """Where the body is now; cheaper than a snapshot."""
        ...

    def snapshot(self) -> Snapshot:
        """The state now."""
        ...

    def plan(self) -> str:
        """What is active, in words."""
        ...

    def identity(self) -> dict[str, str]:
        """What a checkpoint must agree on with the solver that takes it over."""
        ...

    def check_state(self) -> None:
        """Raise ``Diverged`` when the state now is no solution any more."""
        ...

    def samples(self, times: Sequence[float]) -> Samples:
        """What the problem's functions say at ``times`` [s]; see ``record.samples``."""
        ...

    def totals(self) -> dict[str, float]:
        """What the run has cost so far, for its summary."""
        ...

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        ...

    def track_budget(self) -> None:
        """Keep the budget of energy and momentum from now on."""
        ...

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays themselves, not copies, that hold all that the future depends on.

        With ``time`` and ``step`` they are complete: written over with those of an equal solver,
        and :meth:`state_changed` called, the next step gives the same bits.
        """
        ...

    def state_changed(self) -> None:
        """Bring up to date what is derived from :meth:`state_arrays`."""
        ...
