"""One simulation as its user sees it, whatever the method: run, save, restore, copy, budget."""

from __future__ import annotations

import copy
import time as clock
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import Diverged, InputError
from sphsolid.geometry.mesh import Mesh, protected
from sphsolid.record.budget import total_momentum
from sphsolid.record.checkpoint import BUDGET, checkpoint_of, common_identity, rebuilt, restore
from sphsolid.record.history import History
from sphsolid.record.march import march
from sphsolid.record.output import NO_OUTPUT, Output
from sphsolid.record.placement import Placement
from sphsolid.record.plain import plain
from sphsolid.record.positions import PositionWatch
from sphsolid.record.progress import Progress
from sphsolid.record.recorders import Recorder
from sphsolid.record.samples import Sampler, Samples
from sphsolid.record.snapshot import Snapshot
from sphsolid.record.vtu import write_vtu
from sphsolid.run.held_bytes import held_bytes
from sphsolid.run.running_budget import NotOpened, RunningBudget, Works
from sphsolid.run.team import Team
from sphsolid.scenes.hidden_memory import refuse_hidden_memory
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]


class BaseSimulation(ABC):
    """What the two methods share; a method says how a step is taken and what its state is.

    ``arguments`` are the keywords that build an equal simulation of ``scene``; ``material`` is the
    law and its parameters as they are now: what is done to its text later is not seen.  Positions
    are looked at every ``look_every`` steps.
    """

    def __init__(
        self, scene: Scene, material: Any, arguments: dict[str, Any], *, look_every: int
    ) -> None:
        self.scene = scene
        self.material = material
        self._arguments = arguments
        #: What was seen of the positions: see ``record.positions``.
        self.positions = PositionWatch(every=look_every)
        self.time = 0.0
        self.step = 0
        #: Of the last ``run``; without rows before the first.
        self.history = History.of([])
        self._budget: RunningBudget | NotOpened = NotOpened()
        self._seconds_before = 0.0
        self._running_since: float | None = None

    def _take_points(self, mesh: Mesh, V: Array) -> None:
        """``mesh`` whose vertices are the points of the method, with volumes ``V (N,)`` [m^3]."""
        refuse_hidden_memory(self.scene, mesh)
        self._points, self._volumes = mesh, V
        #: The threads that take the steps.
        self.team = Team(len(mesh.vertices))
        self._sampler = Sampler(self.scene, mesh)
        # One object for all snapshots, so that what is made for it can be kept.
        self._shown_mesh = protected(mesh)

    # ------------------------------------------------------------------ what a method says
    @property
    @abstractmethod
    def name(self) -> str:
        """Scene and method in a file-name friendly form."""

    @abstractmethod
    def stable_time_step(self) -> float:
        """Largest step allowed now [s]; raises ``Diverged`` when the state is invalid."""

    def check_state(self) -> None:
        """Raise ``Diverged`` when the state now is no solution any more."""
        self.stable_time_step()

    @abstractmethod
    def advance(self, dt: float) -> None:
        """One step of ``dt`` [s]."""

    @abstractmethod
    def snapshot(self) -> Snapshot:
        """The state now."""

    @abstractmethod
    def placement(self) -> Placement:
        """Where the points are now."""

    @abstractmethod
    def plan(self) -> str:
        """What is active and why, before anything runs."""

    def memory_bytes(self) -> int:
        """Bytes of all arrays that live during a run."""
        return held_bytes(self)

    @abstractmethod
    def summary(self) -> str:
        """How far the run is and what it cost."""

    @abstractmethod
    def state_changed(self) -> None:
        """Bring up to date what is derived from the state."""

    @abstractmethod
    def _fields(self) -> dict[str, Array]:
        """The arrays that hold the state, by name."""

    @abstractmethod
    def _motion(self) -> tuple[Array, Array]:
        """Positions [m] and velocities [m/s] ``(N, 3)``."""

    @abstractmethod
    def _open_works(self) -> tuple[Works, Callable[[Array], dict[str, Array]]]:
        """Works that are added up from now on, and the sum over constrained faces."""

    @abstractmethod
    def _reaction(self) -> Array:
        """What the last stage's constraints did ``(n, 3)``, as the method keeps it."""

    @abstractmethod
    def _reaction_force(self) -> Array:
        """The same as forces [N]."""

    @abstractmethod
    def _options(self) -> dict[str, Any]:
        """What tells this method from others, and its options."""

    # ------------------------------------------------------------------ the run
    def run(
        self,
        *,
        until: float | None = None,
        every: float | None = None,
        record: Sequence[Recorder] = (),
        progress: Callable[[Progress], None] | None = None,
        output: Output = NO_OUTPUT,
    ) -> History:
        """Advance to ``until`` [s] and record every ``every`` [s]; see ``record.march``."""
        self._running_since = clock.perf_counter()
        try:
            self.history = march(
                self, until=until, every=every, record=record, progress=progress, output=output
            )
            return self.history
        except (Diverged, InputError, KeyboardInterrupt) as stopped:
            self.history = getattr(stopped, "history", self.history)
            raise
        finally:
            self._seconds_before = self.run_seconds
            self._running_since = None

    @property
    def run_seconds(self) -> float:
        """Seconds spent in ``run``, those before a restart included."""
        since = self._running_since
        return self._seconds_before + (0.0 if since is None else clock.perf_counter() - since)

    def save(self, path: str | Path) -> None:
        """Write the state now as a ``.vtu`` file; see ``record.write_vtu``."""
        write_vtu(self.snapshot(), path)

    def restore(self, path: str | Path) -> None:
        """Take over, bit for bit, a checkpoint that an equal simulation wrote."""
        restore(self, path)

    # ------------------------------------------------------------------ the budget
    def track_budget(self) -> None:
        """Keep the budget of energy and momentum from now on; a step takes longer then."""
        if self._budget.is_open:
            return
        start = self.snapshot()
        works, by_face = self._open_works()
        self._budget = RunningBudget(
            works,
            momentum=self._momentum(),
            energy=start.kinetic_energy + start.strain_energy,
            by_face=by_face,
        )

    def _momentum(self) -> Array:
        return total_momentum(self._volumes, self.material.density, *self._motion())

    # ------------------------------------------------------------------ checkpoints and copies
    def identity(self) -> dict[str, str]:
        """What a checkpoint must agree on with the simulation that takes it over."""
        common = common_identity(self.scene, self.material, self._points, self._volumes)
        return common | {
            name: value if name == "method" else plain(value)
            for name, value in self._options().items()
        }

    def samples(self, times: Sequence[float]) -> Samples:
        """What the scene's functions say at ``times`` [s], by which a checkpoint knows them."""
        return self._sampler.at(times)

    def totals(self) -> dict[str, float]:
        """What the run has cost so far."""
        return {"run_seconds": self.run_seconds}

    def go_on_from(self, totals: dict[str, float]) -> None:
        """Count on from ``totals``: what the run had cost up to the state that was put back."""
        self._seconds_before = totals["run_seconds"]

    def state_arrays(self) -> dict[str, Array]:
        """The arrays that hold the state, and the budget where one is kept."""
        arrays = dict(self._fields())
        if self._budget.is_open:
            kept = self._budget.arrays() | {"reaction_now": self._reaction()}
            arrays |= {f"{BUDGET}{name}": value for name, value in kept.items()}
        return arrays

    def __copy__(self) -> Any:
        """As a deep copy: two simulations of one state would each move the other's."""
        return copy.deepcopy(self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Set up again where it is unpickled, and put into the state of now, bit for bit."""
        return rebuilt, (type(self), self.scene, self._arguments, checkpoint_of(self))
