"""One punch on one cloud: how noisy its pressure is, and where its top goes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.cloud import T1
from sphsolid.errors import Diverged
from sphsolid.geometry import HexMesh
from sphsolid.record import Snapshot
from sphsolid.record.budget import Budget
from sphsolid.scenes import punch
from sphsolid.scenes.punch import HEIGHT
from sphsolid.scheme.stabilisation import SUPG
from studies.pictures.face import save_face
from studies.punch_cloud.bodies import body_of
from studies.report.folding import folding
from studies.report.indicators import pressure_noise, pressure_range
from studies.report.scattered_noise import scattered_noise

Row = dict[str, Any]
#: Time [s] between two records.
EVERY = 5.0e-4
DEFAULT, TETRAHEDRA, NO_TAU_P, NONE = "default", "T1", "no tau_p", "none"


def simulation(*, cloud: str, stabilisation: str, cells: int, seed: int) -> sph.Simulation:
    """{p,F,J} on one of the bodies, everything else but the stabilisation left to the package."""
    body, spacing = body_of(cloud, spacing=1.0 / cells, seed=seed)
    scene = punch(body=body)
    usual = sph.Simulation(scene, spacing=spacing, formulation=sph.PFJ())
    if stabilisation == DEFAULT:
        return usual
    chosen: Any = sph.NoStabilisation()
    if stabilisation != NONE:
        given = usual.stabilisation
        assert isinstance(given, SUPG)
        chosen = SUPG(
            tau_F=given.tau_F,
            xi_F=given.xi_F,
            tau_p=0.0 if stabilisation == NO_TAU_P else given.tau_p,
            weighting=given.weighting,
            secondary=T1() if stabilisation == TETRAHEDRA else given.secondary,
        )
    return sph.Simulation(
        scene, spacing=spacing, formulation=sph.PFJ(), stabilisation=chosen
    )


def run_case(
    *,
    key: str,
    cloud: str,
    stabilisation: str,
    cells: int,
    seed: int,
    until: float,
    shots: str,
) -> list[Row]:
    """A row ``kind = run`` and one ``instant`` every half millisecond; a loss is a result."""
    sim = simulation(cloud=cloud, stabilisation=stabilisation, cells=cells, seed=seed)
    common = {
        "key": key, "cloud": cloud, "stabilisation": stabilisation, "cells": cells, "seed": seed,
    }  # fmt: skip
    instants: list[Row] = []
    lost: Row = {"survived": True, "lost_at": float("nan"), "reason": ""}
    started = time.perf_counter()
    sim.track_budget()
    try:
        for n in range(1, round(until / EVERY) + 1):
            sim.run(until=n * EVERY)
            instants.append({"kind": "instant"} | _instant(sim.snapshot(), 1.0 / cells))
    except Diverged as stop:
        lost = {"survived": False, "lost_at": stop.time, "reason": stop.reason}
    shot = sim.snapshot()
    if lost["survived"]:
        save_face(Path(shots) / f"{key}.npz", shot.mesh, "Y-", shot.x, shot.pressure)
    last = instants[-1] if instants else {}
    run: Row = {
        "kind": "run",
        "method": f"{sim.stabilisation.name}, {sim.operator.name}",
        "particles": sim.cloud.size,
        "secondary": 0 if sim.secondary is None else len(sim.secondary.V),
        "noise": _mean(instants, "noise"),
        "noise_in_rows": _mean(instants, "noise_in_rows"),
        **{name: last.get(name, np.nan) for name in ("p_low", "p_high", "top_low", "top_high")},
        "missed_momentum": missed_momentum(shot),
        "steps": sim.step,
        "setup_s": sim.setup_seconds,
        "wall_s": time.perf_counter() - started,
    }
    return [common | row for row in (run | lost | folding(sim), *instants)]


def missed_momentum(shot: Snapshot) -> float:
    """Linear momentum that no load or constraint gave, over that of the start."""
    balance = shot.budget
    assert isinstance(balance, Budget)
    return float(np.linalg.norm(balance.drift[0]) / np.linalg.norm(balance.start_momentum[0]))


def _instant(shot: Snapshot, spacing: float) -> Row:
    low, high = pressure_range(shot)
    top = shot.x[np.isclose(shot.X[:, 2], HEIGHT), 2]
    in_rows = pressure_noise(shot) if isinstance(shot.mesh, HexMesh) else np.nan
    return {
        "time": shot.time, "noise": scattered_noise(shot, spacing=spacing),
        "noise_in_rows": in_rows,
        "p_low": low, "p_high": high, "top_low": float(top.min()), "top_high": float(top.max()),
    }  # fmt: skip


def _mean(instants: list[Row], name: str) -> float:
    return float(np.mean([row[name] for row in instants])) if instants else float("nan")
