"""The main table of the twisting column, one row a run, and the figures that README quotes of it.

``python -m studies.twisting_column.summary [folder]`` prints the latter from a finished run.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from studies.convergence.figures import select
from studies.harness.cases import ROOT
from studies.harness.results import Tables, read_results
from studies.report import folding
from studies.twisting_column import outside
from studies.twisting_column.cases import CLAMP
from studies.twisting_column.compare import centres, kink, percentiles_of_cells
from studies.twisting_column.methods import FEM, H1, H6, TOOLKIT, lattice, usual
from studies.twisting_column.sequence import TooFew, twist_error, twist_sequence
from studies.twisting_column.verdicts import claims

Row = dict[str, Any]
#: What tells runs apart.
RUN = ["label", "cells", "cfl", "nu"]
SETTING = [
    "method", "formulation", "secondary", "operator", "weighting", "integrator", "tau_F",
    "tau_unit", "xi_F", "tau_p", "h_over_dx", "particles", "steps", "cpu_s", "wall_s", "survived",
    "end_time", "reason",
    *folding.COLUMNS,
]  # fmt: skip
#: Instants [ms] whose twist, height and noise are columns.
INSTANTS = (20, 40, 60, 80, 100)
_WORKS = {
    "dissipation_p": "dissipation_p [J]",
    "dissipation_J": "dissipation_J [J]",
    "projection": "work_projection [J]",
    "adjoint_defect": "work_adjoint_defect [J]",
    "constraint": "work_constraint [J]",
}
_STATE = [
    f"pressure_{kind}{share}"
    for kind in ("", "vertices_", "cells_", "free_")
    for share in (1, 50, 99)
]
COLUMNS = [
    *RUN, *SETTING, *(f"twist_{ms}" for ms in INSTANTS), "twist_max", "time_of_max",
    *(f"height_{ms}" for ms in INSTANTS), "corners_100", "energy_kept", *_WORKS,
    "rest", "rest_largest",
    *_STATE, "peaks_at_clamp", *(f"noise_{ms}" for ms in INSTANTS),
    *(f"noise_free_{ms}" for ms in INSTANTS), "noise_free_mean",
    "J_min", "J_max", "unseen_rms", "inside_out_share", "reaction_y_largest", "reaction_y_end",
    "torque_largest", "linear_drift", "angular_drift", "position_rms", "pressure_rms",
    "kink", "ringing", "mean_rms", *(f"pressure_mean_{s}" for s in (1, 50, 99)),
    *(f"reference_mean_{s}" for s in (1, 50, 99)),
]  # fmt: skip


def clamp_torque(history: pd.DataFrame) -> np.ndarray:
    """Mean torque [N m] about Y that the clamp exerted between two records; first entry zero."""
    given = history["angular_impulse_y [kg m^2/s]"].to_numpy()
    return np.diff(given, prepend=given[0]) / np.diff(history["time [s]"], prepend=-1.0)


def summarise(runs: list[Row], history: pd.DataFrame, apart: pd.DataFrame) -> pd.DataFrame:
    """One row a run in :data:`COLUMNS`: lengths in m, angles in rad, pressures in Pa, energies as
    shares of the energy at the start, drifts as shares of their natural scales.
    """
    rows = []
    for run in runs:
        mine = history[(history[RUN] == pd.Series({n: run[n] for n in RUN})).all(axis=1)]
        row = {name: run[name] for name in (*RUN, *SETTING)}
        row |= _of_means(run)
        row["kink"] = kink(run) if run["survived"] else float("nan")
        rows.append(row | _of_history(mine) | _of_reference(run, apart))
    return pd.DataFrame(rows, columns=COLUMNS)


def _of_history(history: pd.DataFrame) -> Row:
    time = history["time [s]"].to_numpy()
    end = history.iloc[-1]
    energy = history["total_energy [J]"].iloc[0]
    row: Row = {}
    for ms in INSTANTS:
        at = history[np.isclose(time, 1e-3 * ms)]
        for name, column in (
            ("twist", "twist [rad]"), ("height", "height [m]"), ("corners", "corners [m]"),
            ("noise", "noise"), ("noise_free", "noise_free"),
        ):  # fmt: skip
            row[f"{name}_{ms}"] = float(at[column].iloc[0]) if len(at) else float("nan")
    highest = int(history["twist [rad]"].to_numpy().argmax())
    row |= {"twist_max": history["twist [rad]"].iloc[highest], "time_of_max": time[highest]}
    row |= {name: end[f"{name} [Pa]"] for name in _STATE}
    row |= {name: end[column] / energy for name, column in _WORKS.items()}
    row |= {
        "energy_kept": end["total_energy [J]"] / energy,
        "rest": end["energy_rest [J]"] / energy,
        "rest_largest": history["energy_rest [J]"].abs().max() / energy,
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


def _of_reference(run: Row, apart: pd.DataFrame) -> Row:
    if len(apart) == 0:
        return {}
    same = (apart[RUN] == pd.Series({name: run[name] for name in RUN})).all(axis=1)
    found = apart[same & (apart["other"] == FEM)]
    if len(found) == 0:
        return {}
    one = found.iloc[0]
    row = {"position_rms": one["position_rms [m]"], "pressure_rms": one["pressure_rms"]}
    row["mean_rms"] = one.get("mean_rms", float("nan"))
    for share in (1, 50, 99):
        row[f"reference_mean_{share}"] = one.get(f"other_mean_{share} [Pa]", float("nan"))
    return row


def _of_means(run: Row) -> Row:
    if not run.get("grid_mean"):
        return {}
    free = np.broadcast_to(centres(run["cells"])[1] > CLAMP, (run["cells"], 6 * run["cells"]))
    mean = np.reshape(run["grid_mean"], (*free.shape, run["cells"]))[free]
    row: Row = {f"pressure_mean_{s}": value for s, value in percentiles_of_cells(mean).items()}
    return row | {"ringing": run["ringing"]}


def quoted(tables: Tables) -> str:
    """What README quotes: every claim as judged, the sequences, and runs at 6x31x6 and finer."""
    lines = [f"{one.claim}: {one.verdict}. {one.measured}" for one in claims(tables)]
    runs = usual(tables["table"])
    lines += ["", f"Twist at 0.1 s against {outside.NAME} ({outside.twist().value:g} rad):"]
    for label in (H1, H6, TOOLKIT, FEM):
        found = twist_sequence(runs, label)
        if not isinstance(found, TooFew):
            lines.append(f"{label}: {found.text()}")
    lines += ["", "Largest error of the twist at 20 .. 100 ms, energy kept, steps:"]
    for label in (H1, H6, TOOLKIT, FEM):
        for _, run in select(runs, label=label).sort_values("cells").iterrows():
            if run["survived"]:
                lines.append(
                    f"{label}, {lattice(int(run['cells']))}: {100 * twist_error(run):.2f} %, "
                    f"{100 * run['energy_kept']:.1f} %, {run['steps']} steps"
                    + (", folded" if run["folded"] else "")
                )
    return "\n".join(lines)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "reports" / "twisting_column"
    print(quoted(read_results("twisting_column", folder).tables))
