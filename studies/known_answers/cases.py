"""One run of the cable, or of the bending column, by either solver at its defaults."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

import fem_reference as fem
import sphsolid as sph
from sphsolid.record import Errors, PointField, Probe, l2_norm, period_errors
from sphsolid.scenes import Pulse, Scene, Step, bending_column, cable
from studies.report.folding import folding

METHODS = ("SUPG-SPH {p,F}", "SUPG-SPH {p,F,J}", "B-bar FEM")
#: A pulse small enough for the linear solution to be exact; the published step.
LOADS: dict[str, tuple[Pulse | Step, float]] = {"pulse": (Pulse(), 1.0e4), "step": (Step(), 5.0e7)}
_INSTANTS = 16


def solver(scene: Scene, method: str, spacing: float) -> Any:
    """Either solver with nothing given but the formulation."""
    if method == "B-bar FEM":
        return fem.Simulation(scene, spacing=spacing)
    formulation = sph.PFJ() if "J" in method else sph.PF()
    return sph.Simulation(scene, spacing=spacing, formulation=formulation)


def run_cable(*, method: str, load: str, cells: int) -> list[dict[str, Any]]:
    """Relative L2 errors over one period against d'Alembert, and of the stress at the wall.

    The bar is two cells wide on rollers, ``cells`` a metre.  ``wall`` is the relative error of the
    mean axial stress in the metre at the wall while the front is elsewhere: twice the load's.
    """
    started = time.perf_counter()
    shape, stress = LOADS[load]
    spacing = 1.0 / cells
    sim = solver(cable(load=shape, stress=stress, width=2 * spacing), method, spacing)
    wave = sim.scene.known_solution()
    scale = stress / 2.0e11 * 10.0 * math.sqrt(sim.scene.body.volume)
    rows, wall = [], []
    for n in range(1, _INSTANTS + 1):
        last = sim.run(until=n * wave.period / _INSTANTS, record=[Errors()]).table.iloc[-1]
        shot = sim.snapshot()
        u, P = shot.field("u"), shot.field("P")
        miss = u.values - wave.displacement(u.X, shot.time)
        rows.append(
            {
                "p": float(last["p_x"]),
                "P": float(last["P_xx"]),
                "u": float(l2_norm(PointField(u.X, u.V, miss))[0]) / scale,
            }
        )
        near = P.X[:, 0] <= 1.0
        if 2.6e-3 <= shot.time <= 5.4e-3:
            wall.append(float(P.V[near] @ P.values[near, 0, 0] / P.V[near].sum()))
    doubled = abs(np.mean(wall) / (2.0 * stress) - 1.0) if load == "step" else float("nan")
    common = {"scene": "cable", "load": load, "method": method, "h": spacing}
    wall_s = time.perf_counter() - started
    return [
        common
        | {"field": name, "error": error, "wall_stress": doubled, "wall_s": wall_s}
        | folding(sim)
        for name, error in period_errors(rows).items()
    ]


def run_bending(*, method: str, cells: int) -> list[dict[str, Any]]:
    """First peak of ``u_x`` at the top's centre [m] and its time [s]; ``cells`` a metre."""
    started = time.perf_counter()
    sim = solver(bending_column(), method, 1.0 / cells)
    history = sim.run(until=0.6, every=1.0e-3, record=[Probe("top_centre")])
    u = history["top_centre_u_x [m]"]
    k = int(np.argmax(u))
    return [
        {
            "scene": "bending column", "method": method, "h": 1.0 / cells, "peak": float(u[k]),
            "time": float(history["time [s]"][k]), "wall_s": time.perf_counter() - started,
            **folding(sim),
        }
    ]  # fmt: skip
