"""One run of the punch test: history, top face and frames."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import Diverged
from sphsolid.geometry.mesh import Mesh
from sphsolid.record import EnergyBudget, MomentumDrift, Reactions, Snapshot
from sphsolid.scenes import HeldVelocity, InitialVelocity, Scene, punch
from sphsolid.scenes.punch import Press
from sphsolid.scheme.stabilisation import Stabilisation
from studies.convergence.cases import FORMULATIONS, OPERATORS, SECONDARY, TIMES
from studies.pictures.shots import SaveShots, ShotFolder
from studies.punch.methods import FEM, METHODS, Method
from studies.report.folding import folding
from studies.report.indicators import pressure_noise, pressure_range

#: The instant [s] at which the paper compares methods (Fig. 11).
COMPARED = 0.015
#: Time [s] between two records.
EVERY = 5.0e-4
#: Readings of "a uniform velocity field applied on a region of the top face".
PRESSES: dict[str, Press] = {
    "initial": InitialVelocity(),
    "held": HeldVelocity(),
    "initial, top face only": InitialVelocity(where="top"),
    "held, sticking": HeldVelocity(direction="all"),
}
_NORMALS = {"X-": "x", "X+": "x", "Y-": "y", "Y+": "y", "Z-": "z", "pressed": "z"}


@dataclass(frozen=True)
class TopFace:
    """Lowest, highest and mean height [m] of the top face."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Three columns."""
        z = snapshot.x[on_top(snapshot.X), 2]
        return {
            "top_low [m]": float(z.min()),
            "top_high [m]": float(z.max()),
            "top_mean [m]": float(z.mean()),
        }


@dataclass(frozen=True)
class PressureState:
    """Percentiles [Pa] and noise of the pressure, range of ``J``."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Five columns."""
        low, high = pressure_range(snapshot)
        return {
            "pressure_1 [Pa]": low,
            "pressure_99 [Pa]": high,
            "noise": pressure_noise(snapshot),
            "J_min": float(snapshot.J.min()),
            "J_max": float(snapshot.J.max()),
        }


def on_top(X: np.ndarray) -> np.ndarray:
    """Which undeformed points ``(n, 3)`` are on the top face."""
    return np.isclose(X[:, 2], X[:, 2].max())


def lattice_name(mesh: Mesh) -> str:
    """Points along X, Z and Y, the paper's order: ``21x11x3``."""
    counts = [len(np.unique(np.round(mesh.vertices[:, axis], 9))) for axis in (0, 2, 1)]
    return "x".join(map(str, counts))


def simulation(scene: Scene, *, method: str, operator: str, cells: int) -> Any:
    """Either solver on ``scene`` with ``cells`` per metre."""
    m = METHODS[method]
    if method == FEM:
        return fem.Simulation(scene, spacing=1.0 / cells)
    formulation = FORMULATIONS[m.formulation]()
    given: dict[str, Any] = {"formulation": formulation, "operator": OPERATORS[operator]}
    if m.wide:
        given |= {"smoothing": sph.CubicSpline(), "h_over_dx": 1.0}
    if not m.by_default:
        given |= {"integrator": sph.TVDRK2(), "cfl": 0.3, "stabilisation": _stabilisation(m)}
    sim = sph.Simulation(scene, spacing=1.0 / cells, **given)
    usual = sim.stabilisation
    if m.by_default and isinstance(usual, sph.SUPG) and sph.OfStep(m.tau_p) != usual.tau_p:
        given["stabilisation"] = replace(usual, tau_p=m.tau_p)
        sim = sph.Simulation(scene, spacing=1.0 / cells, **given)
    return sim


def _stabilisation(m: Method) -> Stabilisation:
    if m.secondary == "-":
        return sph.NoStabilisation()
    return sph.SUPG(
        tau_F=TIMES[m.tau_unit](m.tau_F), xi_F=m.xi_F, tau_p=m.tau_p,
        secondary=SECONDARY[m.secondary],
    )


def run_case(
    *,
    key: str,
    press: str,
    method: str,
    operator: str,
    cells: int,
    until: float,
    shots: str,
    shot_times: list[float],
    label: str,
) -> list[dict[str, Any]]:
    """A row ``kind = run``, one ``instant`` per record, one ``profile`` per point of the top edge.

    Frames at ``shot_times`` [s] go to the folder ``shots``.  A run that diverges is a result: its
    rows end where the solution was lost, and the ``run`` row says where and why.
    """
    scene = punch(press=PRESSES[press], end_time=until)
    folder = ShotFolder(Path(shots))
    folder.clear(key)
    sim = simulation(scene, method=method, operator=operator, cells=cells)
    record = [
        TopFace(), PressureState(), EnergyBudget(), MomentumDrift(), Reactions(),
        SaveShots(folder, key, label, times=tuple(shot_times) or (-1.0,)),
    ]  # fmt: skip
    started, busy = time.perf_counter(), time.process_time()
    mesh = sim.snapshot().mesh
    run: dict[str, Any] = {
        "kind": "run",
        "press": press,
        "method": method,
        "operator": operator,
        "lattice": lattice_name(mesh),
        "cells": cells,
        "particles": len(mesh.vertices),
        "h_over_dx": getattr(sim, "h_over_dx", float("nan")),
        "integrator": sim.integrator.name if method != FEM else "central differences",
        "until": until,
        "survived": True,
        "lost_at": float("nan"),
        "lost_where": "",
        "reason": "",
    }
    tables, profile = [], []
    try:
        for target in sorted({min(COMPARED, until), until}):
            tables.append(sim.run(until=target, every=EVERY, record=record).table)
            profile += _profile(sim.snapshot())
    except Diverged as lost:
        tables.append(lost.history.table)  # type: ignore[attr-defined]
        folder.save_lost(key, label, lost)
        x, y, z = lost.position
        run |= {
            "survived": False,
            "lost_at": lost.time,
            "lost_where": f"({x:.3g}, {y:.3g}, {z:.3g}) m",
            "reason": lost.reason,
        }
    run |= {
        "steps": sim.step, "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - busy,
    } | folding(sim)  # fmt: skip
    instants = [row for table in tables for row in table.to_dict("records")]
    return [
        row | {"key": key}
        for row in (run, *({"kind": "instant"} | _kept(row) for row in instants), *profile)
    ]


def _profile(snapshot: Snapshot) -> list[dict[str, Any]]:
    """The edge of the top face at Y = 0."""
    edge = np.flatnonzero(on_top(snapshot.X) & np.isclose(snapshot.X[:, 1], 0.0))
    edge = edge[np.argsort(snapshot.X[edge, 0])]
    return [
        {"kind": "profile", "time": snapshot.time, "X": float(snapshot.X[a, 0]),
         "x": float(snapshot.x[a, 0]), "z": float(snapshot.x[a, 2])}
        for a in edge
    ]  # fmt: skip


def _kept(row: dict[Any, Any]) -> dict[str, Any]:
    """A record without what is zero by symmetry or said twice: 120 columns are too many."""
    out: dict[str, Any] = {}
    for name, value in row.items():
        name = str(name)
        if name.startswith("reaction"):
            face = name.removeprefix("reaction_").removeprefix("impulse_").split(" ")[0]
            if _NORMALS[face[:-2]] != face[-1]:
                continue
        elif name.startswith("angular") or "_impulse" in name:
            continue
        out[name] = value
    return out

