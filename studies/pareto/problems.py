"""What is solved, by name: the scene, the same scene as it is timed, and the errors of a run.

A new problem is an entry in :data:`PROBLEMS`.  ``stated`` is what errors are taken of, ``timed``
the same body, material and constraints without loads: what a step costs.  ``errors`` runs a solver
and gives columns of its row, and rows of instants; ``cost`` guesses the time of a run [s].
``measures`` are the columns of errors at which costs are compared, ``levels`` cells per metre of
the full form, ``quick`` of the short one; ``finest`` is for few methods.  A problem that is for
``everyone`` is run with every method, any other with those of the front.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sphsolid.geometry import TetBox
from sphsolid.record import Snapshot, instant_errors, period_errors
from sphsolid.scenes import Scene, amplitude_of_gradient, swinging_cube, twisting_column
from sphsolid.scenes.swinging_cube import Family, Start
from studies.engine.case import Row
from studies.measures.indicators import twist_of_top, whole_turns
from studies.measures.run import run
from studies.measures.swinging_cube import INSTANTS, LARGEST_GRADIENT, LINEAR_AMPLITUDE
from studies.stability.waves import pulse_in_a_bar, pulse_of, vibrating_block, vibration_of

CUBE, COLUMN, FAIR = "cube", "column", "cube, moving start"
LINEAR, LINEAR_FAIR = "linear cube", "linear cube, moving start"
JITTERED, TETRAHEDRA, VIBRATION, PULSE = "jittered cube", "tetrahedra", "vibration", "pulse"
FAMILY: Family = "A+B+C=0"
#: Time [s] between two records of the column, and the end of its run.
EVERY, END = 2.0e-3, 0.1
#: Spacings a metre in which the pulse is three wide, whatever the spacing of a run.
PULSE_CELLS = 10


@dataclass(frozen=True)
class Cube:
    """The swinging cube, manufactured at large strain or in the ``linear`` limit."""

    title: str
    start: Start = "displaced"
    linear: bool = False
    jitter: float = 0.0
    tetrahedra: bool = False
    everyone: bool = False
    nus: tuple[float, ...] = (0.3, 0.495)
    measures: tuple[str, ...] = ("momentum", "stress")
    levels: tuple[int, ...] = (4, 8, 16)
    finest: int = 32
    quick: tuple[int, ...] = (4, 6)

    @property
    def on_lattice(self) -> bool:
        """Neither jittered nor tetrahedra."""
        return not (self.jitter or self.tetrahedra)

    def stated(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """Elements are hexahedra, on as many nodes where the particles are of tetrahedra."""
        large = amplitude_of_gradient(FAMILY, LARGEST_GRADIENT)
        amplitude = LINEAR_AMPLITUDE if self.linear else large
        return self._scene(nu, elements, start=self.start, amplitude=amplitude)

    def timed(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """The manufactured loads are numpy formulas of the study and cost more than a step.

        They are the same for all methods.  A step's work does not depend on the size of the motion.
        """
        return self._scene(nu, elements, loads=False)

    def _scene(self, nu: float, elements: bool, *, loads: bool = True, **options: Any) -> Scene:
        scene = swinging_cube(
            family=FAMILY, manufactured=loads and not self.linear, poisson_ratio=nu,
            jitter=self.jitter, **options,
        )  # fmt: skip
        return replace(scene, body=TetBox()) if self.tetrahedra and not elements else scene

    def errors(self, sim: Any, nu: float, cells: int, until: float) -> tuple[Row, list[Row]]:
        """Largest component error of momentum and of stress over a period."""
        exact, instants = sim.scene.known_solution(), []
        for k in range(INSTANTS):
            ran = run(sim, until=(k + 0.5) * exact.period / INSTANTS)
            if not ran.survived:
                return ran.columns(), []
            instants.append(instant_errors(sim.snapshot(), exact))
        found = period_errors(instants)
        return ran.columns() | {
            name: max(value for key, value in found.items() if key[0] == letter)
            for name, letter in (("momentum", "p"), ("stress", "P"))
        } | {"stress_size": stress_size(sim.scene)}, []

    def cost(self, nu: float, cells: int) -> float:
        """Loads make three quarters of a run at large strain."""
        per_step = (0.3 if self.linear else 1.0) * (1.0 if self.on_lattice else 1.5)
        return 2e-5 * cells**4 * (5.0 if nu > 0.4 else 1.0) * per_step


@dataclass(frozen=True)
class TwistAndEnergy:
    """Rotation of the top [rad, within half a turn] and the energies [J]."""

    def record(self, snapshot: Snapshot, scene: Scene) -> Row:
        """Two columns."""
        energy = snapshot.kinetic_energy + snapshot.strain_energy
        return {"angle [rad]": twist_of_top(snapshot), "energy [J]": energy}


@dataclass(frozen=True)
class Column:
    """The twisting column; its errors need a reference (``reference``)."""

    title: str
    everyone: bool = True
    on_lattice: bool = True
    nus: tuple[float, ...] = (0.3, 0.495)
    measures: tuple[str, ...] = ("twist_rms", "twist_end", "energy")
    levels: tuple[int, ...] = (3, 5, 10)
    finest: int = 16
    quick: tuple[int, ...] = (3, 5)

    def stated(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """The paper's."""
        return twisting_column(poisson_ratio=nu)

    def timed(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """Hardly twisted."""
        return twisting_column(poisson_ratio=nu, angular_velocity=1.0)

    def errors(self, sim: Any, nu: float, cells: int, until: float) -> tuple[Row, list[Row]]:
        """Rows ``time [s], twist [rad], energy [J]`` of every record."""
        ran = run(sim, until=until, every=EVERY, record=[TwistAndEnergy()])
        twists = [0.0]
        for angle in ran.history["angle [rad]"]:
            twists.append(whole_turns(float(angle), twists[-1]))
        # The sense of rotation is not published, so it is counted positive.
        sense = 1.0 if max(twists) >= -min(twists) else -1.0
        energy = ran.history["energy [J]"]
        return ran.columns(), [
            {"time [s]": time, "twist [rad]": sense * angle, "energy [J]": kept}
            for time, angle, kept in zip(ran.history["time [s]"], twists[1:], energy, strict=True)
        ]

    def cost(self, nu: float, cells: int) -> float:
        """Six cubes."""
        return 3e-4 * cells**4 * (5.0 if nu > 0.4 else 1.0)


@dataclass(frozen=True)
class Vibration:
    """The clamped block's lowest mode (``studies.stability.waves``)."""

    title: str
    everyone: bool = False
    on_lattice: bool = True
    nus: tuple[float, ...] = (0.3, 0.495)
    measures: tuple[str, ...] = ("frequency",)
    levels: tuple[int, ...] = (4, 8, 12)
    finest: int = 24
    quick: tuple[int, ...] = (4, 6)

    def stated(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """Ten periods."""
        return vibrating_block(nu)

    timed = stated

    def errors(self, sim: Any, nu: float, cells: int, until: float) -> tuple[Row, list[Row]]:
        """``frequency`` (and how sure its reference is) and ``damping`` ratio."""
        found = vibration_of(sim, nu)
        unsure = abs(found["omega_finest"] / found["omega_reference"] - 1.0)
        return found | {
            "frequency": abs(found["frequency_error"]), "frequency_uncertainty": unsure,
            "damping": found["damping_ratio"],
        }, []  # fmt: skip

    def cost(self, nu: float, cells: int) -> float:
        """Many steps of a small body."""
        return 3e-2 * cells**2 * (5.0 if nu > 0.4 else 1.0)


@dataclass(frozen=True)
class Pulse:
    """A pulse in a bar of two spacings across, of the same length on every lattice."""

    title: str
    everyone: bool = False
    on_lattice: bool = True
    nus: tuple[float, ...] = (0.3, 0.495)
    measures: tuple[str, ...] = ("pulse",)
    levels: tuple[int, ...] = (10, 20, 40)
    finest: int = 80
    quick: tuple[int, ...] = (10, 20)

    def stated(self, nu: float, cells: int, *, elements: bool = False) -> Scene:
        """Of one dimension, so the bar may be as thin as its lattice allows."""
        return pulse_in_a_bar(nu, 1.0 / PULSE_CELLS, across=1.0 / cells)

    timed = stated

    def errors(self, sim: Any, nu: float, cells: int, until: float) -> tuple[Row, list[Row]]:
        """``pulse``: root mean square of what is wrong with the velocity over the exact one."""
        found = pulse_of(sim, nu, 1.0 / PULSE_CELLS)
        return found | {"pulse": found["error"]}, []

    def cost(self, nu: float, cells: int) -> float:
        """Short runs."""
        return 5e-4 * cells**2


Problem = Cube | Column | Vibration | Pulse
PROBLEMS: dict[str, Problem] = {
    CUBE: Cube("swinging cube, large strain", everyone=True),
    COLUMN: Column("twisting column"),
    FAIR: Cube("cube, moving start, large strain", start="moving"),
    LINEAR: Cube("cube, linear limit", linear=True),
    LINEAR_FAIR: Cube(
        "cube, moving start, linear limit", start="moving", linear=True, nus=(0.3, 0.495, 0.499)
    ),
    JITTERED: Cube("jittered cube, moving start", start="moving", jitter=0.4),
    TETRAHEDRA: Cube("cube of tetrahedra, moving start", start="moving", tetrahedra=True),
    VIBRATION: Vibration("clamped block, lowest mode"),
    PULSE: Pulse("pulse in a bar"),
}
MEASURES = {name: problem.measures for name, problem in PROBLEMS.items()}


def stated(scene: str, nu: float, cells: int = 1) -> Scene:
    """The problem that errors are taken of."""
    return PROBLEMS[scene].stated(nu, cells)


def timed(scene: str, nu: float, cells: int = 1) -> Scene:
    """The problem that a step is timed on."""
    return PROBLEMS[scene].timed(nu, cells)


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
