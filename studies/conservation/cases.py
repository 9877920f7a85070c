"""One run of the L-shaped block: the unit of work of the first half of the conservation study."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sphsolid.record import EnergyBudget, MomentumDrift, Snapshot
from sphsolid.record.recorders import AXES, Recorder
from sphsolid.scenes import Scene, l_shaped_block
from studies.conservation.measures import (
    DEFAULTS,
    chosen,
    left_over,
    march,
    outcome,
    shares,
    solver,
    vectors,
)
from studies.harness.cases import Row
from studies.pictures.shots import SaveShots, ShotFolder
from studies.report.indicators import pressure_noise, pressure_range

#: The tractions of the L-shaped block end here [s].
LOAD_ENDS = 5.0
#: A record of the L-shaped block every so many seconds.
EVERY = 0.25


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


def block(
    *,
    key: str,
    shots: str,
    shot_times: Sequence[float],
    group: str,
    jitter: float,
    load: float,
    until: float,
    keep_history: bool,
    **options: Any,
) -> list[Row]:
    """The L-shaped block to ``until`` [s]: a row ``run``, and a row ``history`` per record.

    ``load``: factor of the published tractions; frames at ``shot_times`` go to folder ``shots``.
    """
    started = time.perf_counter()
    scene = l_shaped_block(load_factor=load, jitter=jitter)
    sim = solver(scene, **options)
    record: list[Recorder] = [EnergyBudget(), MomentumDrift(), PressureState()]
    folder, label = ShotFolder(Path(shots)), label_of(**options)
    if shot_times:
        folder.clear(key)
        record.append(SaveShots(folder, key, label, times=tuple(shot_times)))
    table, failure = march(sim, until=until, every=EVERY, record=record)
    if failure is not None and shot_times:
        folder.save_lost(key, label, failure)
    common = {"scene": "block", "group": group, "jitter": jitter, "load": load, "until": until}
    measures = _measures(table)
    how = outcome(sim, failure, measures["left_over"], started)
    row: Row = common | chosen(sim, options) | how | measures
    rows = [{"kind": "run", **row}]
    if keep_history:
        rows += [{"kind": "history", "scene": "block", "key": key, **r} for r in _history(table)]
    return rows


def _measures(table: pd.DataFrame) -> Row:
    """Numbers that judge a run; those after the loads are missing where it did not get there."""
    when = table["time [s]"].to_numpy()
    linear = np.linalg.norm(vectors(table, "linear", "momentum"), axis=1)
    L = vectors(table, "angular", "momentum")
    energy = table["total_energy [J]"].to_numpy()
    end, arm = table.iloc[-1], table["angular_scale [kg m^2/s]"].to_numpy()
    row: Row = {
        "linear": shares(table, "linear", linear).max(),
        "linear_step": end["linear_drift_step [kg m/s]"] / end["linear_scale [kg m/s]"],
        "angular_step": end["angular_drift_step [kg m^2/s]"] / arm[-1],
        "angular_total": shares(table, "angular", table["angular_drift [kg m^2/s]"].to_numpy())[
            when > 0.0
        ].max(initial=0.0),
        "work": end["work_traction [J]"],
        "dissipated": -(end["dissipation_p [J]"] + end["dissipation_J [J]"])
        / end["work_traction [J]"],
        "rest": end["energy_rest [J]"] / end["work_traction [J]"],
        "left_over": left_over(table)[-1] / end["work_traction [J]"],
        "J_min": table["J_min"].min(),
        "J_max": table["J_max"].max(),
    }
    free = when >= LOAD_ENDS * (1.0 - 1e-9)
    if free.any():
        k = int(np.flatnonzero(free)[0])
        drift = np.linalg.norm(L[free] - L[k], axis=1)
        impulse = vectors(table, "angular", "traction_impulse")[k]
        row |= {
            "angular_free": shares(table[free], "angular", drift).max(),
            "impulse_gap": float(np.linalg.norm(L[k] - impulse)) / arm[k],
            **{f"L_{AXES[i]}": L[k, i] for i in range(3)},
            "energy_5": energy[k],
            "energy_kept": energy[-1] / energy[k],
            "noise": table["pressure_noise"].to_numpy()[free].mean(),
            "pressure_1": table["pressure_1 [Pa]"].to_numpy()[free].min(),
            "pressure_99": table["pressure_99 [Pa]"].to_numpy()[free].max(),
        }
    return row


def _history(table: pd.DataFrame) -> list[Row]:
    L, p = vectors(table, "angular", "momentum"), vectors(table, "linear", "momentum")
    drift = shares(table, "angular", table["angular_drift [kg m^2/s]"].to_numpy())
    share = shares(table, "linear", np.linalg.norm(p, axis=1))
    return [
        {
            "time": r["time [s]"],
            **{f"L_{AXES[i]}": L[k, i] for i in range(3)},
            **{f"p_{AXES[i]}": p[k, i] for i in range(3)},
            "linear": share[k],
            "angular": drift[k],
            "kinetic": r["kinetic_energy [J]"],
            "deviatoric": r["deviatoric_energy [J]"],
            "volumetric": r["volumetric_energy [J]"],
            "work": r["work_traction [J]"],
            "projection": r["work_projection [J]"],
            "dissipation": r["dissipation_p [J]"] + r["dissipation_J [J]"],
            "rest": r["energy_rest [J]"],
            "noise": r["pressure_noise"],
        }
        for k, r in table.iterrows()
    ]


def label_of(*, method: str, formulation: str, secondary: str, operator: str, **others: Any) -> str:
    """The heading of a picture."""
    if method == "B-bar FEM":
        return method
    if method == DEFAULTS:
        return f"{formulation} {DEFAULTS}"
    return f"{formulation} {secondary} {operator}"
