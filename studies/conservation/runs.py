"""The runs of both scenes: momenta over their natural scales, and every term of the energy budget.

A run of the L-shaped block gives a row ``table``, one of the spinning cube a row ``cube``, and each
of their records, where they are kept, a row of a history.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.record import EnergyBudget, MomentumDrift, Snapshot
from sphsolid.record.recorders import AXES, Recorder
from sphsolid.scenes import Scene, l_shaped_block, spinning_cube
from sphsolid.scenes.l_shaped_block import PUBLISHED_SPACING
from studies.clouds.runs import conservation
from studies.measures.indicators import pressure_noise, pressure_range
from studies.measures.run import Ran, run
from studies.measures.setting import setting
from studies.methods import Method
from studies.pictures.shots import SaveShots, ShotFolder

Array = NDArray[np.float64]
Row = dict[str, Any]
#: Share of the energy beyond which the time integrator, not the method, decides a run.
MADE_BY_TIME = 1.0e-2
_UNITS = {"linear": "kg m/s", "angular": "kg m^2/s"}
#: The tractions end here, and the run [s]; a record every so many seconds.
LOAD_ENDS, END, EVERY = 5.0, 20.0, 0.25
#: Particles are moved by half of this share of the spacing at most, in each direction.
DISORDER = 0.2
#: Instants [s] of the pictures.
SHOT_TIMES = (2.5, 5.0, 10.0, 15.0, 20.0)
#: Shapes and clouds of the free bodies, as ``studies.clouds`` names them.
BODIES = (
    ("cube", "lattice"), ("cube", "jitter 0.4"), ("cube", "tet"), ("L-block", "lattice"),
    ("L-block", "jitter 0.4"), ("cylinder", "hex file"), ("cylinder", "tet file"),
    ("plate with a hole", "hex file"), ("plate with a hole", "tet file"),
)  # fmt: skip
#: Records a turn, and turns.
RECORDS_A_TURN, TURNS = 16, 10.0
#: [rad/s]; ten times slower, ten turns take ten times the steps and have a hundredth of the energy.
SPIN, SLOW_SPIN = 105.0, 10.5


def vectors(history: pd.DataFrame, kind: str, what: str) -> Array:
    """Columns ``<kind>_<what>_x .. z`` of :class:`MomentumDrift`, ``(n, 3)``."""
    return np.asarray(history[[f"{kind}_{what}_{axis} [{_UNITS[kind]}]" for axis in AXES]], float)


def column(history: pd.DataFrame, kind: str, what: str) -> Array:
    """Column ``<kind>_<what>`` of :class:`MomentumDrift`, ``(n,)``."""
    return np.asarray(history[f"{kind}_{what} [{_UNITS[kind]}]"], float)


def shares(history: pd.DataFrame, kind: str, values: Array) -> Array:
    """Values over the natural scale at the same record; zero while nothing moves."""
    scale = column(history, kind, "scale")
    return np.divide(values, scale, out=np.zeros_like(scale), where=scale > 0.0)


def drifts(history: pd.DataFrame, kind: str) -> Array:
    """Momentum that no load gave, over its natural scale, at every record."""
    return shares(history, kind, column(history, kind, "drift"))


def dissipated(history: pd.DataFrame) -> Array:
    """Work of ``D(p)``, ``D(J)`` and a restraint [J], negative where they take energy."""
    of_supg = history["dissipation_p [J]"] + history["dissipation_J [J]"]
    return np.asarray(of_supg, float) + of_restraint(history)


def of_restraint(history: pd.DataFrame) -> Array:
    """Work of a restraint's viscosity [J]; zeros where there is none."""
    name = "dissipation_restraint [J]"
    return np.asarray(history[name] if name in history else np.zeros(len(history)), float)


def given_back(history: pd.DataFrame) -> float:
    """The most that a restraint gave back between two records [J]: nothing, if it dissipates."""
    return float(np.diff(of_restraint(history)).max(initial=0.0))


def left_over(history: pd.DataFrame) -> Array:
    """Residual of the energy budget and work of the projection together [J], at every record.

    Stages project with positions that differ from what ``F`` has come to by ``dt^2``: the work
    that this costs is no physical one, and the integrator gives it back.  Apart, the two columns
    are artefacts of equal size; their sum is what the energy really missed.
    """
    return np.asarray(history["energy_rest [J]"] + history["work_projection [J]"], float)


def ended(ran: Ran, missed: float) -> dict[str, Any]:
    """The columns of a run and its ``outcome``, first of these that holds.

    ``diverged``; ``folded``, the positions, at any time; by ``missed``, the share of the energy
    that is left over at the end, beyond :data:`MADE_BY_TIME`: ``energy made``, or ``energy
    missing``; else ``kept``.
    """
    outcome = "kept"
    if abs(missed) > MADE_BY_TIME:
        outcome = "energy made" if missed > 0.0 else "energy missing"
    if ran.folded:
        outcome = "folded"
    if not ran.survived:
        outcome = "diverged"
    return {"outcome": outcome} | ran.columns()


def block_key(method: str, spacing: float) -> str:
    """Under which the run of a method is known that has nothing else of its own."""
    return f"block: {method}, spacing {spacing:g}"


@dataclass(frozen=True)
class Block:
    """A run: ``load`` is a factor of the published tractions; ``pictured`` keeps frames."""

    group: str
    method: Method
    spacing: float = PUBLISHED_SPACING
    jitter: float = DISORDER
    load: float = 1.0
    until: float = END
    pictured: bool = False

    @property
    def key(self) -> str:
        """What tells it from the others."""
        usual = {"jitter": DISORDER, "load": 1.0, "until": END}
        words = [f"{name} {getattr(self, name):g}" for name in usual
                 if getattr(self, name) != usual[name]]  # fmt: skip
        return ", ".join([block_key(self.method.name, self.spacing), *words])

    @property
    def columns(self) -> Row:
        """What was asked of the run."""
        return {
            "group": self.group, "method": self.method.name, "spacing": self.spacing,
            "jitter": self.jitter, "load": self.load, "until": self.until,
        }  # fmt: skip


class PressureState:
    """Noise, 1 % and 99 % pressure [Pa] and range of ``J``."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Five columns."""
        low, high = pressure_range(snapshot)
        return {
            "pressure_noise": pressure_noise(snapshot),
            "pressure_1 [Pa]": low,
            "pressure_99 [Pa]": high,
            "J_min": float(np.min(snapshot.J)),
            "J_max": float(np.max(snapshot.J)),
        }


def run_block(*, block: Block, shots: str) -> list[Row]:
    """A row ``table`` and rows ``history``; frames go to the folder ``shots``."""
    scene = l_shaped_block(load_factor=block.load, jitter=block.jitter)
    sim = block.method.simulation(scene, spacing=block.spacing)
    record: list[Recorder] = [EnergyBudget(), MomentumDrift(), PressureState()]
    folder = ShotFolder(Path(shots))
    if block.pictured:
        folder.clear(block.key)
        times = tuple(t for t in SHOT_TIMES if t <= block.until)
        record.append(SaveShots(folder, block.key, block.method.label, times=times))
    made = setting(sim)
    ran = run(sim, until=block.until, every=EVERY, record=record)
    if block.pictured and ran.diverged is not None:
        folder.save_diverged(block.key, block.method.label, ran.diverged)
    measured = _measures(ran.history)
    named: Row = {"of": "table"} | block.columns
    rows = [named | made | ended(ran, measured["left_over"]) | measured]
    if block.pictured or block.group in ("no projection", "long"):
        named = {"of": "history", "method": block.method.name, "spacing": block.spacing}
        named |= {"until": block.until}
        rows += [named | row for row in _history(ran.history)]
    return rows


def _measures(history: pd.DataFrame) -> Row:
    """Numbers that judge a run; those after the loads are missing where it did not get there."""
    when = history["time [s]"].to_numpy()
    L = vectors(history, "angular", "momentum")
    linear = np.linalg.norm(vectors(history, "linear", "momentum"), axis=1)
    end, arm = history.iloc[-1], history["angular_scale [kg m^2/s]"].to_numpy()
    work = end["work_traction [J]"]
    row: Row = {
        "linear": shares(history, "linear", linear).max(),
        "linear_step": end["linear_drift_step [kg m/s]"] / end["linear_scale [kg m/s]"],
        "angular_step": end["angular_drift_step [kg m^2/s]"] / arm[-1],
        "angular_total": drifts(history, "angular")[when > 0.0].max(initial=0.0),
        "work": work,
        "dissipated": 0.0 - dissipated(history)[-1] / work,
        "given_back": given_back(history) / work,
        "residual": end["energy_rest [J]"] / work,
        "left_over": left_over(history)[-1] / work,
        "J_min": history["J_min"].min(),
        "J_max": history["J_max"].max(),
    }
    free = when >= LOAD_ENDS * (1.0 - 1e-9)
    late = ["angular_free", "impulse_gap", *(f"L_{axis}" for axis in AXES), "energy_5",
            "energy_kept", "noise", "pressure_1", "pressure_99"]  # fmt: skip
    if not free.any():
        return row | dict.fromkeys(late, math.nan)
    k = int(np.flatnonzero(free)[0])
    energy = history["total_energy [J]"].to_numpy()
    drift = np.linalg.norm(L[free] - L[k], axis=1)
    impulse = vectors(history, "angular", "traction_impulse")[k]
    return row | {
        "angular_free": shares(history[free], "angular", drift).max(),
        "impulse_gap": float(np.linalg.norm(L[k] - impulse)) / arm[k],
        **{f"L_{axis}": L[k, i] for i, axis in enumerate(AXES)},
        "energy_5": energy[k],
        "energy_kept": energy[-1] / energy[k],
        "noise": history["pressure_noise"].to_numpy()[free].mean(),
        "pressure_1": history["pressure_1 [Pa]"].to_numpy()[free].min(),
        "pressure_99": history["pressure_99 [Pa]"].to_numpy()[free].max(),
    }


def _history(history: pd.DataFrame) -> list[Row]:
    L, p = vectors(history, "angular", "momentum"), vectors(history, "linear", "momentum")
    named = {
        "time": history["time [s]"],
        **{f"L_{axis}": L[:, i] for i, axis in enumerate(AXES)},
        **{f"p_{axis}": p[:, i] for i, axis in enumerate(AXES)},
        "linear": shares(history, "linear", np.linalg.norm(p, axis=1)),
        "angular": drifts(history, "angular"),
        "kinetic": history["kinetic_energy [J]"],
        "deviatoric": history["deviatoric_energy [J]"],
        "volumetric": history["volumetric_energy [J]"],
        "work": history["work_traction [J]"],
        "projection": history["work_projection [J]"],
        "dissipation": dissipated(history),
        "residual": history["energy_rest [J]"],
        "noise": history["pressure_noise"],
    }
    return pd.DataFrame(named).to_dict("records")


@dataclass(frozen=True)
class Cube:
    """A run; the name of a method does not say its CFL number, which is varied."""

    group: str
    method: Method
    spacing: float = 0.25
    cfl: float = 0.3
    spin: float = SPIN
    turns: float = TURNS

    @property
    def key(self) -> str:
        """What tells it from the others."""
        spin = "" if self.spin == SPIN else f", spin {self.spin:g}"
        return f"cube: {self.method.name}, spacing {self.spacing:g}, CFL {self.cfl:g}{spin}"


def run_cube(*, cube: Cube, keep_history: bool) -> list[Row]:
    """A row ``cube`` and, if asked, rows ``cube_history``."""
    scene = spinning_cube(angular_velocity=cube.spin, turns=cube.turns)
    sim = cube.method.but(cfl=cube.cfl).simulation(scene, spacing=cube.spacing)
    made = setting(sim)
    every = scene.end_time / max(1, round(cube.turns * RECORDS_A_TURN))
    ran = run(sim, until=scene.end_time, every=every, record=[EnergyBudget(), MomentumDrift()])
    history = ran.history
    energy = history["total_energy [J]"].to_numpy()
    residual = history["energy_rest [J]"].to_numpy() / energy[0]
    missed, gone = left_over(history) / energy[0], dissipated(history) / energy[0]
    end, angular = history.iloc[-1], drifts(history, "angular")
    named = {"method": cube.method.name, "spacing": cube.spacing, "spin": cube.spin}
    row = {
        "L_z": vectors(history, "angular", "momentum")[0, 2],
        "energy_0": energy[0],
        "angular_total": angular.max(),
        "angular_step": end["angular_drift_step [kg m^2/s]"] / end["angular_scale [kg m^2/s]"],
        "linear_total": drifts(history, "linear").max(),
        "linear_step": end["linear_drift_step [kg m/s]"] / end["linear_scale [kg m/s]"],
        "residual": np.abs(residual).max(),
        "residual_end": residual[-1],
        "left_over": np.abs(missed).max(),
        "energy_kept": energy[-1] / energy[0],
        "dissipated": 0.0 - gone[-1],
        "given_back": given_back(history) / energy[0],
        "projection_work": end["work_projection [J]"] / energy[0],
    }
    how = ended(ran, missed[-1])
    rows = [{"of": "cube", "group": cube.group, "turns": cube.turns} | named | made | how | row]
    if keep_history:
        strain = history["deviatoric_energy [J]"] + history["volumetric_energy [J]"]
        frame = pd.DataFrame(
            {
                "turn": history["time [s]"] * abs(cube.spin) / (2.0 * math.pi),
                "kinetic": history["kinetic_energy [J]"] / energy[0],
                "strain": strain / energy[0],
                "total": energy / energy[0],
                "dissipation": gone,
                "residual": residual,
                "angular": angular,
            }
        )
        named |= {"of": "cube_history", "cfl": made["cfl"]}
        rows += [named | record for record in frame.to_dict("records")]
    return rows


@dataclass(frozen=True)
class Body:
    """A free body of ``studies.clouds`` that spins, shears and breathes."""

    group: str
    method: Method
    shape: str
    cloud: str

    @property
    def key(self) -> str:
        """What tells it from the others."""
        return f"body: {self.method.name}, {self.shape}, {self.cloud}"


def run_body(*, body: Body) -> list[Row]:
    """A row ``bodies``: drifts of both momenta over their scales."""
    (row,) = conservation(
        shape=body.shape, cloud=body.cloud, method=body.method, operator=body.method.name
    )
    empty = dict.fromkeys(("linear_drift", "angular_drift"), math.nan)
    kept = ("shape", "cloud", "outcome", "steps", "particles", "why", *empty)
    named = {"of": "bodies", "group": body.group, "method": body.method.name}
    return [named | empty | {name: row[name] for name in kept if name in row}]
