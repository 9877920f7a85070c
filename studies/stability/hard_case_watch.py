"""What a hard case is watched for: collapse of its step, range of J, noise, twist, a pattern."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import Diverged, FoldingWarning
from sphsolid.record import EnergyBudget, History, Positions, Snapshot, Solver, march
from sphsolid.record.recorders import Recorder
from sphsolid.scenes import Scene
from studies.report.indicators import pressure_noise, twist_of_top
from studies.stability.hard_case_methods import Simulation

Array = NDArray[np.float64]
#: Instants at which a run is looked at.
RECORDS = 50
#: A step this much below the first means that a particle is about to collapse.
COLLAPSED = 1.0 / 200.0


class Watched:
    """A solver that gives up, as :class:`Diverged`, when its stable step collapses.

    Without it a method whose particles fold, and never turn inside out, takes ever smaller steps.
    Everything else is the solver's own.
    """

    def __init__(self, solver: Simulation) -> None:
        object.__setattr__(self, "_solver", solver)
        object.__setattr__(self, "_least", COLLAPSED * solver.stable_time_step())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._solver, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._solver, name, value)

    def stable_time_step(self) -> float:
        """The solver's, or ``Diverged``."""
        dt = float(self._solver.stable_time_step())
        if dt < self._least:
            shot = self._solver.snapshot()
            stretch = np.linalg.svd(shot.F, compute_uv=False)[:, -1]
            a = int(np.argmin(stretch))
            x, y, z = (float(c) for c in shot.stress_X[a])
            raise Diverged(
                f"the stable step collapsed (stretch {stretch[a]:.2g})",
                shot.time, shot.step, a, (x, y, z), "more dissipation or a finer spacing",
            )  # fmt: skip
        return dt


@dataclass(frozen=True)
class Health:
    """Range of ``J`` and the pressure-noise indicator."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Three columns."""
        return {
            "J_min": float(np.min(snapshot.J)),
            "J_max": float(np.max(snapshot.J)),
            "noise": pressure_noise(snapshot),
        }


@dataclass(frozen=True)
class TopTwist:
    """Angle of the top [rad], whole turns left out."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """One column."""
        return {"angle": twist_of_top(snapshot)}


@dataclass(frozen=True)
class Share:
    """How much of a pattern ``(n,)`` is in ``v_x`` (or in ``J - 1``), by volume."""

    pattern: Array
    of: str = "v"

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """One column."""
        values = snapshot.velocity[:, 0] if self.of == "v" else snapshot.J - 1.0
        share = np.average(values * self.pattern, weights=snapshot.V)
        return {"share": float(share)}


@dataclass(frozen=True)
class Kept:
    """Keeps every snapshot; adds no column."""

    shots: list[Snapshot] = field(default_factory=list)

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        self.shots.append(snapshot)
        return {}


def run_to_end(solver: Simulation, *recorders: Recorder) -> tuple[History, dict[str, Any]]:
    """History to the end, or to where the solution was lost, and what became of it.

    That positions fold is in the history, and no warning.
    """
    solver.track_budget()
    until = solver.scene.end_time
    lost: dict[str, Any] = {"survived": True, "reason": ""}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FoldingWarning)
            history = march(
                cast(Solver, Watched(solver)), until=until, every=until / RECORDS,
                record=[EnergyBudget(), Health(), Positions(), *recorders],
            )  # fmt: skip
    except Diverged as end:
        history = end.history  # type: ignore[attr-defined]
        lost = {
            "survived": False, "reason": end.reason, "lost_time": end.time, "lost_step": end.step,
            "lost_particle": end.particle, "lost_X": end.position[0], "lost_Y": end.position[1],
            "lost_Z": end.position[2],
        }  # fmt: skip
    return history, lost | {"steps": solver.step, "end_time": until}
