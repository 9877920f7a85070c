"""The methods that meet in the punch test, one run of it, and what H1 and H6 cost."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud.operator import OperatorKind
from sphsolid.geometry.mesh import Mesh
from sphsolid.record import EnergyBudget, MomentumDrift, Reactions, Snapshot
from sphsolid.record.recorders import Recorder
from sphsolid.scenes import HeldVelocity, InitialVelocity, Scene, punch
from sphsolid.scenes.punch import Press
from studies.engine.case import Row
from studies.measures.indicators import pressure_noise, pressure_range
from studies.measures.run import run
from studies.methods import B_BAR, DISPLACEMENT, PACKAGE, PAPER, SUPG, UNSTABILISED, Method
from studies.pictures.shots import SaveShots, ShotFolder

#: The instant [s] at which the paper compares methods (Fig. 11), and the time between records.
COMPARED, EVERY = 0.015, 5.0e-4


@dataclass(frozen=True)
class Reading:
    """A reading of "a uniform velocity field applied on a region of the top face"."""

    name: str
    press: Press


INITIAL, HELD = Reading("initial", InitialVelocity()), Reading("held", HeldVelocity())
READINGS = (INITIAL, HELD)
#: Readings that nobody chose.
OTHERS = (
    Reading("initial, top face only", InitialVelocity(where="top")),
    Reading("held, sticking", HeldVelocity(direction="all")),
)

#: The paper's settings of this scene; H6 without and with ``tau_p`` are (c) and (d) of its Fig. 10.
_TIMES: dict[str, Any] = {"tau_F": sph.OfStep(0.5), "tau_p": sph.OfStep(0.1)}
H1 = PAPER.but(name="paper, {p,F,H,J} H1", formulation=sph.PFHJ(), xi_F=0.1, **_TIMES)
H6 = PAPER.but(
    name="paper, {p,F,H,J} H6", line="--", formulation=sph.PFHJ(), secondary=sph.H6(), **_TIMES
)
H6_NO_TAU_P = H6.but(tau_p=sph.OfStep(0.0), line=":")
#: Support of 2 spacings with the cubic spline, the usual one of displacement-based codes.
WIDE = H6.but(name=f"{H6.name}, support 2 dx", smoothing=sph.CubicSpline(), h_over_dx=1.0)
WIDE_NO_TAU_P = WIDE.but(tau_p=sph.OfStep(0.0), line=":")
GALERKIN = PAPER.but(
    name="paper, {p,F,H,J} unstabilised", colour=UNSTABILISED.colour, marker=UNSTABILISED.marker,
    formulation=sph.PFHJ(), stabilisation=sph.NoStabilisation(),
)  # fmt: skip
CLASSICAL = PAPER.but(
    name="paper, displacement SPH", colour=DISPLACEMENT.colour, marker=DISPLACEMENT.marker,
    formulation=sph.Displacement(), stabilisation=sph.NoStabilisation(),
)  # fmt: skip
#: ``tau_p`` in steps, for three families in which nothing else changes: self-adjoint SUPG, and
#: with the paper's integrator {p,F,J} H1 with ``tau_F = dt`` and with ``tau_F = 0``.
TAU_P = (0.0, 0.05, 0.1, 0.2)
DEFAULTS = {t: SUPG if t == 0.1 else SUPG.but(tau_p=sph.OfStep(t)) for t in TAU_P}
WITH_TAU_F = {t: PAPER.but(formulation=sph.PFJ(), tau_p=sph.OfStep(t)) for t in TAU_P}
WITHOUT_TAU_F = {
    t: PAPER.but(formulation=sph.PFJ(), tau_F=0.0, xi_F=0.1, tau_p=sph.OfStep(t)) for t in TAU_P
}
CONSISTENT, LITERAL = sph.Consistent(), sph.Literal()


@dataclass(frozen=True)
class State:
    """Heights [m] of the top face; percentiles [Pa] and noise of the pressure; range of ``J``."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Eight columns."""
        z = snapshot.x[on_top(snapshot.X), 2]
        low, high = pressure_range(snapshot)
        return {
            "top_low [m]": float(z.min()),
            "top_high [m]": float(z.max()),
            "top_mean [m]": float(z.mean()),
            "pressure_1 [Pa]": low,
            "pressure_99 [Pa]": high,
            "noise": pressure_noise(snapshot),
            "J_min": float(snapshot.J.min()),
            "J_max": float(snapshot.J.max()),
        }


@dataclass(frozen=True)
class TopEdge:
    """Keeps in ``rows`` the edge of the top face at Y = 0 at ``times`` [s]; adds no column."""

    times: Sequence[float]
    rows: list[Row] = field(default_factory=list)

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        if np.isclose(self.times, snapshot.time, rtol=0.0, atol=0.01 * EVERY).any():
            edge = np.flatnonzero(on_top(snapshot.X) & np.isclose(snapshot.X[:, 1], 0.0))
            for a in edge[np.argsort(snapshot.X[edge, 0])]:
                x, z = snapshot.x[a, [0, 2]].tolist()
                X = float(snapshot.X[a, 0])
                self.rows.append({"kind": "profile", "time": snapshot.time, "X": X, "x": x, "z": z})
        return {}


def on_top(X: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which undeformed points ``(n, 3)`` are on the top face."""
    return np.isclose(X[:, 2], X[:, 2].max())


def lattice_name(mesh: Mesh) -> str:
    """Points along X, Z and Y, the paper's order: ``21x11x3``."""
    counts = [len(np.unique(np.round(mesh.vertices[:, axis], 9))) for axis in (0, 2, 1)]
    return "x".join(map(str, counts))


def simulation(
    reading: Reading, method: Method, operator: OperatorKind | None, cells: int, until: float
) -> Any:
    """A solver with ``cells`` a metre; ``operator`` is ``None`` for :data:`OWN_OPERATOR`."""
    chosen = method if operator is None else method.but(operator=operator)
    return chosen.simulation(punch(press=reading.press, end_time=until), spacing=1.0 / cells)


def run_case(
    *, key: str, reading: Reading, method: Method, operator: OperatorKind | None, cells: int,
    until: float, shots: str, shot_times: tuple[float, ...],
) -> list[Row]:  # fmt: skip
    """A row ``kind = run``, one ``instant`` per record, one ``profile`` per point of the top edge.

    Frames at ``shot_times`` [s] go to the folder ``shots``.  A run that diverges is a result: its
    rows end where it did.
    """
    folder, edge = ShotFolder(Path(shots)), TopEdge((COMPARED, until))
    folder.clear(key)
    sim = simulation(reading, method, operator, cells, until)
    mesh = sim.snapshot().mesh
    record: list[Recorder] = [
        State(), EnergyBudget(), MomentumDrift(), Reactions(), edge,
        SaveShots(folder, key, method.name, times=shot_times or (-1.0,)),
    ]  # fmt: skip
    ran = run(sim, until=until, every=EVERY, record=record)
    if ran.diverged is not None:
        folder.save_diverged(key, method.name, ran.diverged)
    row: Row = {
        "kind": "run",
        "press": reading.name,
        "method": method.name,
        "operator": sim.operator.name if isinstance(sim, sph.Simulation) else "",
        "lattice": lattice_name(mesh),
        "cells": cells,
        "particles": len(mesh.vertices),
        "h_over_dx": getattr(sim, "h_over_dx", float("nan")),
        "integrator": (
            sim.integrator.name if isinstance(sim, sph.Simulation) else "central differences"
        ),
        "until": until,
    } | ran.columns()
    instants = [{"kind": "instant"} | _kept(each) for each in ran.history.to_dict("records")]
    return [each | {"key": key} for each in (row, *instants, *edge.rows)]


_NORMALS = {"X-": "x", "X+": "x", "Y-": "y", "Y+": "y", "Z-": "z", "pressed": "z"}


def _kept(row: dict[Any, Any]) -> Row:
    """A record without what is zero by symmetry or said twice: 120 columns are too many."""
    out: Row = {}
    for name, value in row.items():
        if name.startswith("reaction"):
            face = name.removeprefix("reaction_").removeprefix("impulse_").split(" ")[0]
            if _NORMALS[face[:-2]] != face[-1]:
                continue
        elif name.startswith("angular") or "_impulse" in name:
            continue
        out[name] = value
    return out


def run_cost(
    *, key: str, tau_p: float, cells: int, repeats: int = 9, work: float = 5.0e4
) -> list[Row]:
    """One row: nanoseconds per particle-step without, with H1 and with H6 terms.

    The fastest of ``repeats`` timings of ``work`` particles times steps each, taken in turn: the
    machine is shared, the minimum is what it can.  ``terms_ratio`` is what H6 adds to a step
    without secondary particles over what H1 adds; ``step_ratio`` is the whole step with H6 over
    that with H1.
    """
    with_terms = H1.but(tau_p=sph.OfStep(tau_p))
    methods = {"none": GALERKIN, "H1": with_terms, "H6": with_terms.but(secondary=sph.H6())}
    sims = {
        name: method.simulation(punch(), spacing=1.0 / cells) for name, method in methods.items()
    }
    size = sims["none"].cloud.size
    # The step is far below the stable one, nothing diverges.
    steps = max(2, int(work / size))
    best = dict.fromkeys(sims, float("inf"))
    for repeat in range(repeats + 1):
        for name, sim in sims.items():
            started = time.perf_counter()
            for _ in range(steps):
                sim.advance(1.0e-7)
            if repeat > 0:
                best[name] = min(best[name], (time.perf_counter() - started) / steps)
    ns = {name: 1.0e9 * seconds / size for name, seconds in best.items()}
    return [
        {
            "kind": "cost", "key": key, "lattice": lattice_name(sims["none"].cloud.mesh),
            "tau_p": tau_p, "ns_none": ns["none"], "ns_H1": ns["H1"], "ns_H6": ns["H6"],
            "terms_ratio": (ns["H6"] - ns["none"]) / (ns["H1"] - ns["none"]),
            "step_ratio": ns["H6"] / ns["H1"],
        }
    ]  # fmt: skip


#: What is run with both operators, and what on a finer lattice.
BOTH_OPERATORS: tuple[Method, ...] = (
    CLASSICAL, GALERKIN, H6_NO_TAU_P, H6, H1, SUPG, *WITH_TAU_F.values(), WIDE_NO_TAU_P, WIDE,
)  # fmt: skip
#: Elements have no operator, and the default chooses its own.
OWN_OPERATOR = (B_BAR, PACKAGE)
FINER = (B_BAR, PACKAGE, CLASSICAL, H6_NO_TAU_P, H6, H1, SUPG)
