"""The runs: the paper's scenes and the hard cases, each followed to its end or to where it ended.

All solvers are looked at in the same way: positions by what no method computes with, noise of the
pressure by neighbours in space, energy by the budget.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.errors import FoldingWarning
from sphsolid.record import EnergyBudget, MomentumDrift, Positions, Recorder, Snapshot
from sphsolid.scenes import Scene, punch, spinning_cube, twisting_column
from studies.engine.case import Row
from studies.measures.folding import largest
from studies.measures.indicators import (
    pressure_range,
    scattered_noise,
    twist_of_top,
    whole_turns,
)
from studies.measures.run import Ran, run
from studies.methods import Method
from studies.pareto.problems import FAIR, LINEAR_FAIR, PROBLEMS
from studies.pictures.shots import SaveShots, ShotFolder
from studies.stability.hard_problems import (
    SEED,
    Measured,
    Seed,
    block,
    energy_shares,
    give_up_on_collapse,
    height_of_top,
)

Array = NDArray[np.float64]
#: Records of a run.
RECORDS = 50
#: Poisson's ratio of the cube, and its two amplitudes: waves that begin moving.
CUBE_NU, AMPLITUDES = 0.3, {"linear": LINEAR_FAIR, "manufactured": FAIR}
#: Instants [s] of the punch whose frames are kept, the last of which the paper compares at.
EARLY = (0.005, 0.010, 0.015)
#: Time [s] between records of the punch.
EVERY = 5.0e-4
#: Turns of the free cube, and its cells a side.
TURNS, SPIN_CELLS = 1.0, 4
#: Cells a side of the block with the seed.
SEED_CELLS = 6


@dataclass(frozen=True)
class State:
    """Noise and percentiles [Pa] of the pressure and the range of ``J``; ``spacing`` [m]."""

    spacing: float

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Five columns."""
        low, high = pressure_range(snapshot)
        return {
            "noise": scattered_noise(snapshot, spacing=self.spacing),
            "pressure_1 [Pa]": low,
            "pressure_99 [Pa]": high,
            "J_min": float(snapshot.J.min()),
            "J_max": float(snapshot.J.max()),
        }


def followed(
    solver: Any, *, spacing: float, record: Sequence[Recorder] = (), every: float = 0.0
) -> tuple[Ran, Row]:
    """Run to the end of the scene: how it went, and what every row says of a run.

    ``every`` [s] between records; :data:`RECORDS` of them where it is not given.  That positions
    fold is in the row, and no warning.
    """
    give_up_on_collapse(solver)
    until = solver.scene.end_time
    recorders: list[Recorder] = [EnergyBudget(), Positions(), State(spacing), *record]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldingWarning)
        ran = run(solver, until=until, every=every or until / RECORDS, record=recorders)
    history = ran.history
    noise = history["noise"].to_numpy()
    row = ran.columns() | energy_shares({name: history[name].to_numpy() for name in history}) | {
        "applicable": True, "end_time": until, "particles": len(solver.snapshot().X),
        "J_min": history["J_min"].min(), "J_max": history["J_max"].max(),
        "unseen_rms": largest(history, "unseen_rms [-]"),
        "inside_out": largest(history, "inside_out_share [-]"),
        # Early on hardly any pressure is there, and its noise says nothing.
        "noise": float(np.mean(noise[len(noise) // 5 :])), "noise_end": float(noise[-1]),
        "pressure_1": history["pressure_1 [Pa]"].iloc[-1],
        "pressure_99": history["pressure_99 [Pa]"].iloc[-1],
    }  # fmt: skip
    return ran, row


def run_cube(*, name: str, method: Method, scene: str, cells: int) -> list[Row]:
    """A row ``cube``: the largest component errors of momentum and of stress over a period."""
    problem = PROBLEMS[AMPLITUDES[scene]]
    sim = method.simulation(problem.stated(CUBE_NU, cells), spacing=1.0 / cells)
    found, _ = problem.errors(sim, CUBE_NU, cells, 0.0)
    named = {"kind": "cube", "method": name, "scene": scene, "cells": cells}
    return [named | {"particles": len(sim.snapshot().X)} | found]


@dataclass(frozen=True)
class Shots:
    """Where frames go, and at which times [s]; none at all where there are no times."""

    folder: str
    times: tuple[float, ...] = ()

    def recorder(self, key: str, label: str) -> list[Recorder]:
        """What keeps the frames of a run; older ones of it are forgotten."""
        folder = ShotFolder(Path(self.folder))
        folder.clear(key)
        return [SaveShots(folder, key, label, times=self.times)] if self.times else []

    def ended(self, key: str, label: str, ran: Ran) -> None:
        """Keep that a run diverged."""
        if self.times and ran.diverged is not None:
            ShotFolder(Path(self.folder)).save_diverged(key, label, ran.diverged)


def column_case(omega: float, nu: float, cells: int) -> str:
    """``column 1/5, 105 rad/s, nu 0.495``."""
    return f"column 1/{cells}, {omega:g} rad/s, nu {nu:g}"


def run_column(
    *, name: str, method: Method, omega: float, nu: float, cells: int, shots: Shots
) -> list[Row]:
    """A row ``run`` with the twist [rad] at 20, 40, .. 100 ms, and one ``instant`` a record."""
    case = column_case(omega, nu, cells)
    scene = twisting_column(angular_velocity=omega, poisson_ratio=nu)
    solver = method.simulation(scene, spacing=1.0 / cells)
    key = f"{case}: {name}"
    shape = Measured({"angle": twist_of_top, "height": height_of_top})
    ran, row = followed(
        solver, spacing=1.0 / cells, record=[shape, *shots.recorder(key, method.label)]
    )
    shots.ended(key, method.label, ran)
    history = ran.history
    twist = np.array(list(
        itertools.accumulate(history["angle"], lambda a, b: whole_turns(b, a), initial=0.0)
    )[1:])  # fmt: skip
    # The sense of rotation is not published, so it is counted positive.
    twist *= math.copysign(1.0, twist[np.argmax(np.abs(twist))])
    time = history["time [s]"].to_numpy()
    at = {ms: twist[np.isclose(time, 1.0e-3 * ms)] for ms in (20, 40, 60, 80, 100)}
    row |= {
        "kind": "run", "scene": "column", "case": case, "method": name, "omega": omega, "nu": nu,
        "cells": cells, "answer": float(twist.max()), "answer_is": "largest twist [rad]",
        "height": float(history["height"].iloc[-1]) if row["survived"] else math.nan,
    }  # fmt: skip
    row |= {f"twist_{ms}": float(found[0]) if len(found) else math.nan for ms, found in at.items()}
    energy = history["total_energy [J]"] / history["total_energy [J]"].iloc[0]
    columns = {
        "time": time, "twist": twist, "energy": energy, "noise": history["noise"],
        "unseen_rms": history["unseen_rms [-]"],
    }  # fmt: skip
    return [row, *_instants(columns, case, name)]


def _instants(columns: dict[str, Any], case: str, name: str) -> list[Row]:
    frame = pd.DataFrame(columns)
    return [
        {"kind": "instant", "case": case, "method": name} | one
        for one in frame.to_dict("records")
    ]


def punch_case(cells: int) -> str:
    """``punch 1/20, initial``."""
    return f"punch 1/{cells}, initial"


def top(snapshot: Snapshot) -> Array:
    """Heights [m] of the points of the top face."""
    return np.asarray(snapshot.x[np.isclose(snapshot.X[:, 2], snapshot.X[:, 2].max()), 2])


def run_punch(*, name: str, method: Method, cells: int, shots: Shots) -> list[Row]:
    """A row ``run`` with the ends of the top face [m] at 15 ms, and one ``instant`` a record."""
    case = punch_case(cells)
    scene = punch(end_time=2.0 * EARLY[-1])
    solver = method.simulation(scene, spacing=1.0 / cells)
    key = f"{case}: {name}"
    shape = Measured({"low": lambda shot: top(shot).min(), "high": lambda shot: top(shot).max()})
    ran, row = followed(
        solver, spacing=1.0 / cells, record=[shape, *shots.recorder(key, method.label)],
        every=EVERY,
    )  # fmt: skip
    shots.ended(key, method.label, ran)
    history = ran.history
    time = history["time [s]"].to_numpy()
    at = history[np.isclose(time, EARLY[-1])]
    end, start = solver.snapshot(), solver.snapshot().X[:, 2].max()
    row |= {
        "kind": "run", "scene": "punch", "case": case, "method": name, "cells": cells,
        "answer": float(np.max(end.x[:, 2]) - start), "answer_is": "bulge of the top [m]",
    }  # fmt: skip
    for column, source in (
        ("low", "low"), ("high", "high"), ("pressure_1", "pressure_1 [Pa]"),
        ("pressure_99", "pressure_99 [Pa]"),
    ):  # fmt: skip
        row[column] = float(at[source].iloc[0]) if len(at) else math.nan
    columns = {
        "time": time, "low": history["low"], "high": history["high"],
        "energy": history["total_energy [J]"] / history["total_energy [J]"].iloc[0],
        "noise": history["noise"], "unseen_rms": history["unseen_rms [-]"],
    }  # fmt: skip
    return [row, *_instants(columns, case, name)]


def run_seed(*, name: str, method: Method) -> list[Row]:
    """A row ``run``: a random velocity of 1e-4 of the wave speed in a clamped block.

    Answer: the root of the energy over that at the start.
    """
    still, seed, h = block(), Seed("noise"), 1.0 / SEED_CELLS
    size = SEED * reference_p_wave_speed(still.material)
    scene = replace(still, initial_velocity=lambda X: size * seed.velocity(X, h))
    solver = method.simulation(scene, spacing=h)
    ran, row = followed(solver, spacing=h)
    energy = np.sqrt(np.abs(ran.history["total_energy [J]"].to_numpy()))
    last = float(energy[-max(1, len(energy) // 4) :].max() / energy[0])
    return [
        row | {
            "kind": "run", "scene": "seed", "case": "seeded noise", "method": name,
            "cells": SEED_CELLS, "answer": last, "answer_is": "seed left [-]",
        }
    ]  # fmt: skip


def run_spin(*, name: str, method: Method) -> list[Row]:
    """A row ``spin``: the largest drifts of both momenta of a free cube over their scales."""
    scene = spinning_cube(turns=TURNS)
    solver = method.simulation(scene, spacing=1.0 / SPIN_CELLS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldingWarning)
        ran = run(
            solver, until=scene.end_time, every=scene.end_time / 16.0, record=[MomentumDrift()]
        )
    drift = {
        f"{kind}_drift": float(
            (ran.history[f"{kind}_drift [{unit}]"] / ran.history[f"{kind}_scale [{unit}]"]).max()
        )
        for kind, unit in (("linear", "kg m/s"), ("angular", "kg m^2/s"))
    }
    return [{"kind": "spin", "method": name} | ran.columns() | drift]
