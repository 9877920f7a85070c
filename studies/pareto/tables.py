"""All tables of the study, from the rows of its cases alone."""

from __future__ import annotations

from typing import Any

import pandas as pd

from studies.pareto.choice import recommendation
from studies.pareto.iso_error import iso_table
from studies.pareto.methods import COMPARED, OPTIONS, PLAIN
from studies.pareto.reference import column_errors, reference
from studies.pareto.scenes import CUBE
from studies.pareto.verdicts import ratios
from studies.report import folding

Row = dict[str, Any]
RUN = ["nu", "method", "cells"]
#: Columns of the main table; errors are shares, costs CPU seconds of one thread and bytes.
COLUMNS = [
    "scene", "nu", "method", "cells", "family", "formulation", "stabilisation", "projection",
    "integrator", "particles", "steps", "evaluations_per_step", "evaluations", "end_time",
    "survived", "reason", *folding.COLUMNS, "momentum", "stress", "stress_size", "twist_rms",
    "twist_end", "energy",
    "energy_kept", "twist_rms_uncertainty", "twist_end_uncertainty", "cpu_s_per_s",
    "cpu_s_per_s_worst", "step_cpu_s", "step_cpu_spread", "ns_per_particle_step", "repeats",
    "window_steps", "setup_cpu_s", "error_run_cpu_s", "bytes", "bytes_per_particle", "pairs",
    "gathered_bytes", "streamed_bytes", "multiply_adds", "bytes_moved_per_s",
]  # fmt: skip


def tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``table``, ``iso_error``, ``ratios`` (and those of stabilised particles alone), ``options``,
    ``recommendation``, ``reference`` and ``history``.
    """
    runs = pd.DataFrame([_without_kind(row) for row in rows if row["kind"] == "run"])
    history = pd.DataFrame(
        [_without_kind(row) for row in rows if row["kind"] == "instant"],
        columns=["scene", *RUN, "time [s]", "twist [rad]", "energy [J]"],
    )
    known = reference(history)
    table = main_table(runs, column_errors(history, known))
    compared = table[table["method"].isin([method.label for method in COMPARED])]
    iso = iso_table(compared)
    return {
        "table": table,
        "iso_error": iso,
        "ratios": ratios(iso),
        "ratios_stabilised": ratios(iso[iso["family"] != PLAIN]),
        "options": options_table(table),
        "recommendation": recommendation(table),
        "reference": known,
        "history": history,
    }


def _without_kind(row: Row) -> Row:
    return {name: value for name, value in row.items() if name != "kind"}


def main_table(runs: pd.DataFrame, errors: pd.DataFrame) -> pd.DataFrame:
    """One row a run in :data:`COLUMNS`; runs that only serve as reference have no cost."""
    if len(runs) == 0:
        return pd.DataFrame(columns=COLUMNS)
    table = runs.merge(errors, on=RUN, how="left").reindex(columns=COLUMNS)
    per_second = table["steps"] / table["end_time"]
    table["evaluations"] = table["evaluations_per_step"] * table["steps"]
    table["cpu_s_per_s"] = per_second * table["step_cpu_s"]
    table["cpu_s_per_s_worst"] = table["cpu_s_per_s"] * (1.0 + table["step_cpu_spread"])
    table["ns_per_particle_step"] = 1e9 * table["step_cpu_s"] / table["particles"]
    table["bytes_per_particle"] = table["bytes"] / table["particles"]
    evaluations_per_second = per_second * table["evaluations_per_step"]
    moved = table["gathered_bytes"] + table["streamed_bytes"]
    table["bytes_moved_per_s"] = evaluations_per_second * moved
    return table


def options_table(table: pd.DataFrame) -> pd.DataFrame:
    """Formulation x stabilisation x projection on the cube, on the finest lattice of all."""
    shown = table[
        (table["scene"] == CUBE) & table["method"].isin([method.label for method in OPTIONS])
    ]
    columns = [
        "nu", "formulation", "stabilisation", "projection", "cells", "momentum", "stress",
        "survived", "ns_per_particle_step", "cpu_s_per_s", "bytes_per_particle",
    ]  # fmt: skip
    rows = []
    for _, part in shown.groupby("nu", sort=True):
        counts = part.groupby("cells")["method"].nunique()
        finest = counts[counts == counts.max()].index.max()
        rows.append(part[part["cells"] == finest])
    return pd.concat(rows)[columns] if rows else pd.DataFrame(columns=columns)
