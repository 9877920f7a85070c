"""The two scenes: how each is stated, timed and judged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sphsolid.record import Snapshot
from sphsolid.scenes import amplitude_of_gradient, swinging_cube, twisting_column
from sphsolid.scenes.scene import Scene
from sphsolid.scenes.swinging_cube import Family
from studies.convergence.cases import INSTANTS, LARGEST_GRADIENT, period_errors_of
from studies.report.indicators import twist_of_top
from studies.twisting_column.cases import EVERY, unwrapped

CUBE, COLUMN = "cube", "column"
SCENES = (CUBE, COLUMN)
RATIOS = (0.3, 0.495)
FAMILY: Family = "A+B+C=0"
#: End of the column's run [s].
END = 0.1
#: Error measures of each scene; their columns of the table.
MEASURES = {CUBE: ("momentum", "stress"), COLUMN: ("twist_rms", "twist_end", "energy")}
#: Cells per metre in the full and in the short form.
LEVELS = {CUBE: (4, 8, 16), COLUMN: (3, 5, 10)}
FINEST_CUBE = 32
QUICK_LEVELS = {CUBE: (4, 6), COLUMN: (3, 5)}
Row = dict[str, Any]


def stated(scene: str, nu: float) -> Scene:
    """The problem that errors are taken of."""
    if scene == COLUMN:
        return twisting_column(poisson_ratio=nu)
    amplitude = amplitude_of_gradient(FAMILY, LARGEST_GRADIENT)
    return swinging_cube(
        family=FAMILY, amplitude=amplitude, manufactured=True, poisson_ratio=nu
    )


def timed(scene: str, nu: float) -> Scene:
    """The same body, material and constraints, small motion, no loads: what a step costs.

    The manufactured loads are numpy formulas of the study and cost more than the step of a method;
    they are the same for all methods and no part of them.  A step's work does not depend on the
    size of the motion.
    """
    if scene == COLUMN:
        return twisting_column(poisson_ratio=nu, angular_velocity=1.0)
    return swinging_cube(family=FAMILY, poisson_ratio=nu)


@dataclass(frozen=True)
class TwistAndEnergy:
    """Rotation of the top [rad, within half a turn] and the energies [J]."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Two columns."""
        return {
            "angle [rad]": twist_of_top(snapshot),
            "energy [J]": snapshot.kinetic_energy + snapshot.strain_energy,
        }


def cube_errors(sim: Any) -> Row:
    """Largest component error of momentum and of stress, as ``studies.convergence`` takes them."""
    errors = period_errors_of(sim)
    return {
        name: max(value for key, value in errors.items() if key[0] == letter)
        for name, letter in (("momentum", "p"), ("stress", "P"))
    }


def stress_size(problem: Scene, points: int = 12) -> float:
    """Size of the exact stress in units of the norm's scale: its largest component.

    Near incompressibility it is far above one, because the scale is the shear's.
    """
    exact = problem.known_solution()
    middle = (np.arange(points) + 0.5) / points
    X = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3)
    instants = [(k + 0.5) * exact.period / INSTANTS for k in range(INSTANTS)]
    mean = np.mean([np.mean(exact.first_piola(X, t) ** 2, axis=0) for t in instants], axis=0)
    return float(np.sqrt(mean.max()) / exact.stress_scale)


def column_history(sim: Any, until: float) -> list[Row]:
    """Rows ``time [s], twist [rad], energy [J]`` of a run; ``Diverged`` is the caller's."""
    history = sim.run(until=until, every=EVERY, record=[TwistAndEnergy()]).table
    return history_rows(history)


def history_rows(history: Any) -> list[Row]:
    """The same of the history of a run that was lost."""
    twist = unwrapped(history["angle [rad]"].to_numpy())
    return [
        {"time [s]": time, "twist [rad]": angle, "energy [J]": energy}
        for time, angle, energy in zip(
            history["time [s]"], twist, history["energy [J]"], strict=True
        )
    ]


