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

import fem_reference as fem
import sphsolid as sph
from sphsolid.defaults import default_cfl, default_integrator, default_stabilisation
from sphsolid.errors import Diverged
from sphsolid.record import EnergyBudget, MomentumDrift, Positions, Reactions, Snapshot
from sphsolid.record.recorders import Recorder
from sphsolid.scenes import twisting_column
from sphsolid.scenes.scene import Scene
from sphsolid.scheme.stabilisation import Stabilisation
from studies.convergence.cases import FORMULATIONS, OPERATORS, SECONDARY, TIMES
from studies.pictures.shots import SaveShots, ShotFolder
from studies.report.folding import folding
from studies.report.indicators import pressure_noise, twist_of_top, whole_turns
from studies.report.percentiles import weighted_percentile
from studies.report.places import in_cells
from studies.twisting_column.methods import INTEGRATORS, SELF_ADJOINT

Array = NDArray[np.float64]
Row = dict[str, Any]
#: Time [s] between two records, some fifteen steps of the coarsest lattice.
EVERY = 2.0e-3
#: Time [s] between the samples of a mean, no simple share of the period of any wave.
SAMPLE = 2.3e-4
#: Height [m] above which the clamp and the singular stress at its corners are not felt.
CLAMP = 0.5
SHARES = (1, 50, 99)
#: From the body's lower corner to the origin [m].
CORNER = np.array([0.5, 0.0, 0.5])


def cell_pressure(snapshot: Snapshot) -> tuple[Array, Array]:
    """Centroids ``(C, 3)`` [m] of the cells and the pressure there ``(C,)`` [Pa]."""
    found = in_cells(snapshot, "pressure")
    return found.X, found.values


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
        fields = {
            "": (snapshot.pressure, snapshot.stress_V),
            "vertices_": (snapshot.at_vertices("pressure"), snapshot.V),
            "cells_": (cells.values, cells.V),
            "free_": (cells.values[free], cells.V[free]),
        }
        for kind, (values, volume) in fields.items():
            for share, value in zip(
                SHARES, weighted_percentile(values, volume, SHARES), strict=True
            ):
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


RECORD = (ColumnState(), Positions(), EnergyBudget(), MomentumDrift(), Reactions())


def simulation(
    *,
    method: str,
    formulation: str,
    secondary: str,
    operator: str,
    weighting: str,
    tau_F: float,
    tau_unit: str,
    xi_F: float,
    tau_p: float,
    integrator: str,
    cells: int,
    cfl: float,
    nu: float,
) -> Any:
    """The solver of a case, ``cells`` per metre; ``tau_F`` in ``tau_unit``, ``tau_p`` in
    units of the step.

    With the package's integrator only what differs from its defaults is given.
    """
    scene = twisting_column(poisson_ratio=nu)
    if method == "B-bar FEM":
        return fem.Simulation(scene, spacing=1.0 / cells, cfl=cfl)
    stabilisation: Stabilisation = sph.NoStabilisation()
    if method == "SUPG-SPH":
        stabilisation = sph.SUPG(
            tau_F=TIMES[tau_unit](tau_F), xi_F=xi_F, tau_p=tau_p, secondary=SECONDARY[secondary],
            weighting=sph.SelfAdjoint() if weighting == SELF_ADJOINT else sph.AsPrinted(),
        )  # fmt: skip
    fields = FORMULATIONS[formulation]()
    given: dict[str, Any] = {
        "stabilisation": stabilisation, "operator": OPERATORS[operator], "cfl": cfl,
    }  # fmt: skip
    usual = default_integrator()
    if INTEGRATORS[integrator] != usual:
        given["integrator"] = INTEGRATORS[integrator]
    else:
        chosen = {
            "stabilisation": default_stabilisation(fields, scene.material),
            "operator": sph.Consistent(), "cfl": default_cfl(usual),
        }  # fmt: skip
        given = {name: value for name, value in given.items() if value != chosen[name]}
    return sph.Simulation(scene, spacing=1.0 / cells, formulation=fields, **given)


def run_case(
    *,
    label: str,
    cells: int,
    cfl: float,
    nu: float,
    until: float,
    frames: Sequence[float],
    shots: str,
    average: float,
    **options: Any,
) -> list[Row]:
    """Rows of three kinds: one ``run``, an ``instant`` a record, a ``layer`` a layer of cells.

    The surface is kept in the folder ``shots`` at each time of ``frames`` [s], records all.  After
    ``until`` the run goes on for ``average`` [s] for the mean pressure, if it got so far.
    """
    sim = simulation(cells=cells, cfl=cfl, nu=nu, **options)
    started, busy = time.perf_counter(), time.process_time()
    record: list[Recorder] = list(RECORD)
    folder, key = ShotFolder(Path(shots)), shot_key(label, cells)
    if frames:
        folder.clear(key)
        record.append(SaveShots(folder, key, label, times=tuple(frames)))
    reason = ""
    try:
        history = sim.run(until=until, every=EVERY, record=record).table
    except Diverged as lost:
        # That a method loses the solution is a result of this study: time, place and reason.
        history = lost.history.table  # type: ignore[attr-defined]
        reason = str(lost)
        if frames:
            folder.save_lost(key, label, lost)
    wall, busy = time.perf_counter() - started, time.process_time() - busy
    history.insert(2, "twist [rad]", unwrapped(history.pop("angle [rad]").to_numpy()))
    end = sim.snapshot()
    named = {"label": label, "cells": cells, "cfl": cfl, "nu": nu}
    run = options | {
        "h_over_dx": getattr(sim, "h_over_dx", float("nan")), "particles": len(end.X),
        "steps": sim.step, "wall_s": wall, "cpu_s": busy, "end_time": sim.time,
        "survived": not reason, "reason": reason,
    } | folding(sim)  # fmt: skip
    grid = fields_on_grid(end, cells)
    if average and not reason:
        grid |= mean_pressure(sim, until + average, cells)
    rows = [{"kind": "run"} | named | run | grid]
    rows += [{"kind": "instant"} | named | row for row in history.to_dict("records")]
    return rows + [{"kind": "layer"} | named | row for row in layers(end, cells)]


def shot_key(label: str, cells: int) -> str:
    """Under which the surfaces of a run at the usual step are kept."""
    return f"{label} 1/{cells}"


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
    centroids, pressure = cell_pressure(snapshot)
    x = snapshot.x[_order(snapshot.X, cells)]
    return {
        "grid_x": np.round(x, 7).ravel().tolist(),
        "grid_pressure": np.round(pressure[_order(centroids, cells)], 1).tolist(),
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
        self.kept.append(cell_pressure(snapshot)[1])
        return {}


def mean_pressure(sim: Any, until: float, cells: int) -> Row:
    """``grid_mean``: the mean pressure of the cells [Pa] from now to ``until`` [s]; ``ringing``:
    root mean square [Pa] of what varies about it.  Empty where the solution is lost on the way.

    Pressure waves cross the section in 1.4 ms, and where nothing damps them they ring on: what an
    instant shows is then mostly their phase.
    """
    recorder = Pressures([])
    centroids = cell_pressure(sim.snapshot())[0]
    try:
        sim.run(until=until, every=SAMPLE, record=[recorder])
    except Diverged:
        return {}
    kept = np.array(recorder.kept)
    mean = kept.mean(axis=0)
    return {
        "grid_mean": np.round(mean[_order(centroids, cells)], 1).tolist(),
        "ringing": float(np.sqrt(np.mean((kept - mean) ** 2))),
    }


def layers(snapshot: Snapshot, cells: int) -> list[Row]:
    """Mean, least and largest pressure [Pa] of the centroids of each layer of cells."""
    X, pressure = cell_pressure(snapshot)
    layer = np.floor(X[:, 1] * cells).astype(int)
    frame = pd.DataFrame({"Y [m]": X[:, 1], "pressure": pressure}).groupby(layer)
    found = frame["pressure"].agg(["mean", "min", "max"])
    found.columns = [f"pressure_{name} [Pa]" for name in found.columns]
    found.insert(0, "Y [m]", frame["Y [m]"].first())
    return list(found.to_dict("records"))


def cost_case(*, cells: int, steps: int, rounds: int) -> list[Row]:
    """Processor seconds a step of {p,F,H,J} without stabilisation, with H1, with H6, in turns.

    The three take turns of ``steps`` steps in one process, the least of ``rounds`` turns counts,
    and it is the processor's time: whatever else the machine does must not enter the ratio.
    """
    setups = {
        "none": {"method": "unstabilised", "secondary": "-", "xi_F": 0.0, "tau_p": 0.0},
        "H1": {"method": "SUPG-SPH", "secondary": "H1", "xi_F": 0.2, "tau_p": 0.1},
        "H6": {"method": "SUPG-SPH", "secondary": "H6", "xi_F": 0.0, "tau_p": 0.1},
    }
    best = dict.fromkeys(setups, float("inf"))
    same = {
        "formulation": "{p,F,H,J}", "operator": "Consistent", "weighting": "as printed",
        "tau_F": 1.0, "tau_unit": "dt", "integrator": "TVD-RK2",
    }  # fmt: skip
    sims = {
        name: simulation(cells=cells, cfl=0.3, nu=0.495, **same, **setup)  # type: ignore[arg-type]
        for name, setup in setups.items()
    }
    for sim in sims.values():
        sim.advance(sim.stable_time_step())
    for _ in range(rounds):
        for name, sim in sims.items():
            dt = sim.stable_time_step()
            started = time.process_time()
            for _ in range(steps):
                sim.advance(dt)
            best[name] = min(best[name], (time.process_time() - started) / steps)
    size = sims["none"].cloud.size
    return [
        {"kind": "cost", "cells": cells, "secondary": name, "particles": size,
         "step_s": seconds, "ns_per_particle": 1e9 * seconds / size}
        for name, seconds in best.items()
    ]  # fmt: skip
