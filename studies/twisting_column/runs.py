"""One run of the twisting column, and what a step of it costs: the units of work of the study."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sphsolid.defaults import default_cfl, default_integrator
from sphsolid.errors import Diverged
from sphsolid.look.cell_means import in_cells
from sphsolid.look.percentiles import weighted_percentile
from sphsolid.record import EnergyBudget, MomentumDrift, Positions, Reactions, Snapshot
from sphsolid.record.recorders import Recorder
from sphsolid.scenes import Scene, twisting_column
from studies.measures import folding
from studies.measures.indicators import pressure_noise, twist_of_top, whole_turns
from studies.measures.run import run
from studies.measures.setting import setting
from studies.methods import B_BAR, Method
from studies.pictures.shots import SaveShots, ShotFolder
from studies.twisting_column.compare import CLAMP, SHARES, kink, of_means

Array = NDArray[np.float64]
Row = dict[str, Any]
NU, END = 0.495, 0.1
#: Time [s] between two records, some fifteen steps of the coarsest lattice.
EVERY = 2.0e-3
#: Pressures are averaged over this time [s] after the end, by samples this far apart [s], no simple
#: share of the period of any wave.
AVERAGE, SAMPLE = 0.01, 2.3e-4
#: Instants [ms] whose twist, height and noise are columns.
INSTANTS = (20, 40, 60, 80, 100)
#: From the body's lower corner to the origin [m].
CORNER = np.array([0.5, 0.0, 0.5])


def usual_cfl(method: Method) -> float:
    """That of the integrator, which is the paper's 0.3 for its own; 0.6 for elements."""
    if method.name == B_BAR.name:
        return 0.6
    return default_cfl(dict(method.recipe.options).get("integrator", default_integrator()))  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Column:
    """A run with ``cells`` a metre; surfaces are kept at each time of ``frames`` [s].

    ``kept``: the intrinsic times are the same seconds as at the usual step.  At the usual step the
    run goes on for :data:`AVERAGE` after ``until`` [s] for the mean pressure, if it got so far.
    """

    method: Method
    cells: int
    share: float = 1.0
    kept: bool = False
    nu: float = NU
    frames: tuple[float, ...] = ()
    until: float = END
    average: float = AVERAGE

    @property
    def cfl(self) -> float:
        """``share`` of the usual CFL number."""
        return self.share * usual_cfl(self.method)

    @property
    def named(self) -> Row:
        """Columns that tell it from the others."""
        return {
            "method": self.method.name, "cells": self.cells, "cfl": self.cfl, "nu": self.nu,
            "kept": self.kept, "usual": self.share == 1.0,
        }  # fmt: skip

    @property
    def key(self) -> str:
        """The same in words."""
        words = [shot_key(self.method.name, self.cells)]
        words += [f"CFL {self.cfl:g}"] if self.share != 1.0 else []
        words += ["tau kept"] if self.kept else []
        words += [f"nu {self.nu:g}"] if self.nu != NU else []
        return ", ".join(words)

    def solver(self) -> Any:
        """The solver at its start."""
        scene = twisting_column(poisson_ratio=self.nu)
        return self.method.but(cfl=self.cfl).simulation(scene, spacing=1.0 / self.cells)


def shot_key(method: str, cells: int) -> str:
    """Under which the surfaces of a run at the usual step are kept."""
    return f"{method}, 1/{cells}"


def lattice(cells: int) -> str:
    """Particles of the lattice with ``cells`` cells per metre: 3 is 4x19x4."""
    return f"{cells + 1}x{6 * cells + 1}x{cells + 1}"


@dataclass(frozen=True)
class ColumnState:
    """What the paper's figures show of the column, as numbers."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Twist, heights, noise and percentiles of the pressure, range of ``J``.

        ``height``: of the top's centre, ``corners``: mean of the top's four.  Percentiles are by
        volume: ``pressure_*`` at the points where the law is evaluated, ``pressure_vertices_*`` at
        the vertices, ``pressure_cells_*`` in the cells, ``pressure_free_*`` in those above
        :data:`CLAMP`.  ``peaks_at_clamp`` is the share below :data:`CLAMP` of the volume whose
        pressure is at or above the 99th percentile.
        """
        near = np.linalg.norm(snapshot.X - np.array(scene.probes["top_centre"]), axis=1)
        # With an even number of particles across none is on the axis: then the four around it.
        top = near < near.min() + 1e-9
        cells = in_cells(snapshot, "pressure")
        free = cells.X[:, 1] > CLAMP
        row = {
            "angle [rad]": twist_of_top(snapshot),
            "height [m]": float(snapshot.x[top, 1].mean()),
            "corners [m]": float(snapshot.x[top_corners(snapshot.X), 1].mean()),
            "noise": pressure_noise(snapshot),
            "noise_free": pressure_noise(snapshot, above=CLAMP),
            "J_min": float(snapshot.J.min()),
            "J_max": float(snapshot.J.max()),
        }
        for kind, (values, volume) in {
            "": (snapshot.pressure, snapshot.stress_V),
            "vertices_": (snapshot.at_vertices("pressure"), snapshot.V),
            "cells_": (cells.values, cells.V),
            "free_": (cells.values[free], cells.V[free]),
        }.items():
            found = weighted_percentile(values, volume, SHARES)
            for share, value in zip(SHARES, found, strict=True):
                row[f"pressure_{kind}{share} [Pa]"] = float(value)
        peaks = snapshot.pressure >= row["pressure_99 [Pa]"]
        at_clamp = snapshot.stress_X[peaks, 1] <= CLAMP
        row["peaks_at_clamp"] = float(np.average(at_clamp, weights=snapshot.stress_V[peaks]))
        return row


def top_corners(X: Array) -> NDArray[np.bool_]:
    """Which undeformed points ``(n, 3)`` are the four corners of the top face."""
    off = np.abs(X[:, [0, 2]])
    corner = (off > off.max() - 1e-9).all(axis=1)
    return np.asarray(corner & (X[:, 1] > X[:, 1].max() - 1e-9))


def run_column(*, column: Column, shots: str) -> list[Row]:
    """Rows of three kinds: one ``table``, a ``history`` a record, a ``layers`` a layer of cells."""
    sim = column.solver()
    made = setting(sim)
    record: list[Recorder] = [ColumnState(), Positions(), EnergyBudget(), MomentumDrift(),
                              Reactions()]  # fmt: skip
    folder, key = ShotFolder(Path(shots)), shot_key(column.method.name, column.cells)
    if column.frames:
        folder.clear(key)
        record.append(SaveShots(folder, key, column.method.label, times=column.frames))
    ran = run(sim, until=column.until, every=EVERY, record=record)
    if column.frames and ran.diverged is not None:
        folder.save_diverged(key, column.method.label, ran.diverged)
    history = ran.history
    history.insert(2, "twist [rad]", unwrapped(history.pop("angle [rad]").to_numpy()))
    end = sim.snapshot()
    row = column.named | made | ran.columns() | {"end_time": sim.time} | summary(history)
    row |= fields_on_grid(end, column.cells)
    if ran.survived:
        row["kink"] = kink(row)
        if column.average and column.share == 1.0:
            row |= mean_pressure(sim, column.until + column.average, column.cells)
    rows = [{"of": "table"} | row]
    rows += [{"of": "history"} | column.named | one for one in history.to_dict("records")]
    return rows + [{"of": "layers"} | column.named | one for one in layers(end, column.cells)]


def summary(history: pd.DataFrame) -> Row:
    """What a run says in one row: lengths in m, angles in rad, pressures in Pa, energies as shares
    of the energy at the start, drifts as shares of their natural scales.
    """
    moments, end = history["time [s]"].to_numpy(), history.iloc[-1]
    energy = history["total_energy [J]"].iloc[0]
    row: Row = {}
    for ms in INSTANTS:
        at = history[np.isclose(moments, 1e-3 * ms)]
        for name, column in (
            ("twist", "twist [rad]"), ("height", "height [m]"), ("corners", "corners [m]"),
            ("noise", "noise"), ("noise_free", "noise_free"),
        ):  # fmt: skip
            row[f"{name}_{ms}"] = float(at[column].iloc[0]) if len(at) else float("nan")
    highest = int(history["twist [rad]"].to_numpy().argmax())
    row |= {"twist_max": history["twist [rad]"].iloc[highest], "time_of_max": moments[highest]}
    for kind in ("", "vertices_", "cells_", "free_"):
        row |= {f"pressure_{kind}{s}": end[f"pressure_{kind}{s} [Pa]"] for s in SHARES}
    for name, column in (
        ("energy_kept", "total_energy [J]"), ("dissipation_p", "dissipation_p [J]"),
        ("dissipation_J", "dissipation_J [J]"), ("projection", "work_projection [J]"),
        ("adjoint_defect", "work_adjoint_defect [J]"), ("constraint", "work_constraint [J]"),
        ("residual", "energy_rest [J]"),
    ):  # fmt: skip
        row[name] = end[column] / energy
    row["dissipation_restraint"] = end.get("dissipation_restraint [J]", 0.0) / energy
    row |= {
        "residual_largest": history["energy_rest [J]"].abs().max() / energy,
        "noise_free_mean": history["noise_free"].iloc[1:].mean(),
        "peaks_at_clamp": end["peaks_at_clamp"],
        "J_min": history["J_min"].min(),
        "J_max": history["J_max"].max(),
        "unseen_rms": folding.largest(history, "unseen_rms [-]"),
        "inside_out_share": folding.largest(history, "inside_out_share [-]"),
        "reaction_y_largest": history["reaction_Y-_y [N]"].abs().max(),
        "reaction_y_end": end["reaction_Y-_y [N]"],
        "torque_largest": np.abs(clamp_torque(history)).max(),
    }
    for kind, unit in (("linear", "kg m/s"), ("angular", "kg m^2/s")):
        scale = history[f"{kind}_scale [{unit}]"]
        row[f"{kind}_drift"] = float((history[f"{kind}_drift [{unit}]"] / scale).max())
    return row


def clamp_torque(history: pd.DataFrame) -> Array:
    """Mean torque [N m] about Y that the clamp exerted between two records; first entry zero."""
    given = history["angular_impulse_y [kg m^2/s]"].to_numpy()
    return np.asarray(np.diff(given, prepend=given[0]) / np.diff(history["time [s]"], prepend=-1.0))


def unwrapped(angles: Array) -> Array:
    """Angles [rad] with the turns that make them follow each other, positive from the start."""
    last, found = 0.0, []
    for angle in angles:
        # The top turns by a fifth of a radian between two records, so the jump tells the turns.
        last = whole_turns(float(angle), last)
        found.append(last)
    turned = np.array(found)
    # The sense of rotation is not published, so it is counted positive.
    return np.asarray(turned * np.sign(turned[np.argmax(np.abs(turned))]))


def fields_on_grid(snapshot: Snapshot, cells: int) -> Row:
    """Positions of the vertices and pressures of the cells, as lists in the order of a grid.

    Grids of different spacing can then be compared; the tables keep the differences alone.
    """
    found = in_cells(snapshot, "pressure")
    x = snapshot.x[_order(snapshot.X, cells)]
    return {
        "grid_x": np.round(x, 7).ravel().tolist(),
        "grid_pressure": np.round(found.values[_order(found.X, cells)], 1).tolist(),
    }


def _order(X: Array, cells: int) -> NDArray[np.int64]:
    index = np.floor((X + CORNER) * cells + 0.25).astype(np.int64)
    return np.lexsort(index.T[::-1])


@dataclass(frozen=True)
class Pressures:
    """A recorder that keeps the pressures of the cells and adds no column."""

    kept: list[Array]

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        self.kept.append(in_cells(snapshot, "pressure").values)
        return {}


def mean_pressure(sim: Any, until: float, cells: int) -> Row:
    """``grid_mean``: the mean pressure of the cells [Pa] from now to ``until`` [s], and percentiles
    of it above the clamp; ``ringing``: root mean square [Pa] of what varies about it.  Empty where
    the solution diverges on the way.

    Pressure waves cross the section in 1.4 ms, and where nothing damps them they ring on: what an
    instant shows is then mostly their phase.
    """
    recorder = Pressures([])
    order = _order(in_cells(sim.snapshot(), "pressure").X, cells)
    try:
        sim.run(until=until, every=SAMPLE, record=[recorder])
    except Diverged:
        return {}
    kept = np.array(recorder.kept)
    mean = kept.mean(axis=0)
    row = {"grid_mean": np.round(mean[order], 1).tolist()}
    return row | of_means(row["grid_mean"], cells) | {
        "ringing": float(np.sqrt(np.mean((kept - mean) ** 2)))
    }


def layers(snapshot: Snapshot, cells: int) -> list[Row]:
    """Mean, least and largest pressure [Pa] of the centroids of each layer of cells."""
    found = in_cells(snapshot, "pressure")
    height = found.X[:, 1]
    frame = pd.DataFrame({"Y [m]": height, "pressure": found.values})
    grouped = frame.groupby(np.floor(height * cells).astype(int))
    made = grouped["pressure"].agg(["mean", "min", "max"])
    made.columns = [f"pressure_{name} [Pa]" for name in made.columns]
    made.insert(0, "Y [m]", grouped["Y [m]"].first())
    return made.to_dict("records")


def cost_of_a_step(
    *, methods: Sequence[tuple[str, Method]], cells: int, steps: int, rounds: int
) -> list[Row]:
    """Processor seconds a step of ``methods`` by name, in turns.

    They take turns of ``steps`` steps in one process, the least of ``rounds`` turns counts,
    and it is the processor's time: whatever else the machine does must not enter the ratio.
    """
    sims = {name: Column(method, cells).solver() for name, method in methods}
    best = dict.fromkeys(sims, float("inf"))
    for sim in sims.values():
        sim.advance(sim.stable_time_step())
    for _ in range(rounds):
        for name, sim in sims.items():
            dt = sim.stable_time_step()
            started = time.process_time()
            for _ in range(steps):
                sim.advance(dt)
            best[name] = min(best[name], (time.process_time() - started) / steps)
    size = next(iter(sims.values())).cloud.size
    return [
        {"of": "cost", "cells": cells, "secondary": name, "particles": size,
         "step_s": seconds, "ns_per_particle": 1e9 * seconds / size}
        for name, seconds in best.items()
    ]  # fmt: skip
