"""One run of the spinning cube: the unit of work of the second half of the conservation study."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from sphsolid.record import EnergyBudget, MomentumDrift
from sphsolid.scenes import spinning_cube
from studies.conservation.measures import (
    chosen,
    left_over,
    march,
    outcome,
    shares,
    solver,
    vectors,
)
from studies.harness.cases import Row

#: Records a turn.
RECORDS_A_TURN = 16


def cube(
    *, key: str, group: str, spin: float, turns: float, keep_history: bool, **options: Any
) -> list[Row]:
    """The spinning cube for ``turns`` turns at ``spin`` [rad/s].

    A row ``run`` and, if asked, a row ``history`` per record.
    """
    started = time.perf_counter()
    scene = spinning_cube(angular_velocity=spin, turns=turns)
    sim = solver(scene, **options)
    every = scene.end_time / max(1, round(turns * RECORDS_A_TURN))
    table, failure = march(
        sim, until=scene.end_time, every=every, record=[EnergyBudget(), MomentumDrift()]
    )
    energy = table["total_energy [J]"].to_numpy()
    rest = table["energy_rest [J]"].to_numpy() / energy[0]
    missed = left_over(table) / energy[0]
    end = table.iloc[-1]
    angular = shares(table, "angular", table["angular_drift [kg m^2/s]"].to_numpy())
    linear = shares(table, "linear", table["linear_drift [kg m/s]"].to_numpy())
    scales = end["angular_scale [kg m^2/s]"], end["linear_scale [kg m/s]"]
    row: Row = (
        {"scene": "cube", "group": group, "spin": spin, "turns": turns}
        | chosen(sim, options)
        | outcome(sim, failure, missed[-1], started)
        | {
            "L_z": vectors(table, "angular", "momentum")[0, 2],
            "energy_0": energy[0],
            "angular_total": angular.max(),
            "angular_step": end["angular_drift_step [kg m^2/s]"] / scales[0],
            "linear_total": linear.max(),
            "linear_step": end["linear_drift_step [kg m/s]"] / scales[1],
            "rest": np.abs(rest).max(),
            "rest_end": rest[-1],
            "left_over": np.abs(missed).max(),
            "energy_kept": energy[-1] / energy[0],
            "dissipated": -(end["dissipation_p [J]"] + end["dissipation_J [J]"]) / energy[0],
            "projection_work": end["work_projection [J]"] / energy[0],
        }
    )
    rows = [{"kind": "run", **row}]
    if keep_history:
        rows += [
            {
                "kind": "history",
                "scene": "cube",
                "key": key,
                "turn": r["time [s]"] * abs(spin) / (2.0 * math.pi),
                "kinetic": r["kinetic_energy [J]"] / energy[0],
                "strain": (r["deviatoric_energy [J]"] + r["volumetric_energy [J]"]) / energy[0],
                "total": r["total_energy [J]"] / energy[0],
                "dissipation": (r["dissipation_p [J]"] + r["dissipation_J [J]"]) / energy[0],
                "rest": rest[k],
                "angular": angular[k],
            }
            for k, r in table.iterrows()
        ]
    return rows
