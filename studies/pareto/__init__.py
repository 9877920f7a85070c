"""Which method for which accuracy?  Error against cost of every formulation and element.

``python -m studies.pareto`` runs the swinging cube (manufactured, large strain) and the twisting
column with every method of ``methods.py`` on several lattices, and the other problems of
``problems.py`` with those of the front; one case at a time, errors on all threads.  Then all that
is compared is timed side by side, on one.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

import sphsolid as sph
from studies.engine.provenance import cores
from studies.engine.study import Case, Claim, Row, Study, Tables
from studies.measures import folding
from studies.measures.swinging_cube import LARGEST_GRADIENT
from studies.measures.tables import select
from studies.methods import B_BAR, LATTICE, PACKAGE, TAYLOR_HOOD, Method
from studies.pareto.choice import ENERGY_MADE, SAME_COST, WITHIN, recommendation
from studies.pareto.figures import at_cost, by_error, by_scene, decided_rows, drawing, of_each
from studies.pareto.front import front_claims, slope_claims
from studies.pareto.iso_error import (
    ASKED,
    CERTAIN,
    CHEAPER,
    DECIDED,
    EQUAL,
    FARTHEST,
    by_method,
    counts,
    equal_cost,
    iso_table,
    medians,
    ratios,
)
from studies.pareto.methods import (
    MIXED,
    PFJ,
    PLAIN,
    REFERENCES,
    compared,
    front,
    goes_finest,
    methods_of,
    options,
)
from studies.pareto.methods import PF as P_F
from studies.pareto.problems import (
    COLUMN,
    CUBE,
    END,
    FAIR,
    JITTERED,
    LINEAR,
    LINEAR_FAIR,
    PROBLEMS,
    PULSE,
    TETRAHEDRA,
    VIBRATION,
)
from studies.pareto.reference import column_errors, reference
from studies.pareto.runs import run_case
from studies.pareto.timing import Timing, side_by_side

POISSON = PROBLEMS[CUBE].nus
#: Cells per metre of the reference of the column in the short form.
QUICK_REFERENCE = 6
FULL, QUICK = Timing(0.1, 7), Timing(0.03, 3)
RUN = ["nu", "method", "cells"]
#: Columns that the timing gives.
TIMED = ["step_cpu_s", "step_cpu_spread", "repeats", "window_steps", "setup_cpu_s", "bytes"]
#: Columns of the main table; errors are shares, costs CPU seconds of one thread and bytes.
COLUMNS = [
    "scene", *RUN, "solver", "formulation", "stabilisation", "operator", "projection", "integrator",
    "particles", "steps", "evaluations_per_step", "evaluations", "end_time", "survived",
    "diverged_at", "where", "why", *folding.COLUMNS, "momentum", "stress", "stress_size",
    "twist_rms", "twist_end", "energy", "energy_kept", "twist_rms_uncertainty",
    "twist_end_uncertainty", "frequency", "frequency_uncertainty", "damping", "pulse",
    "cpu_s_per_s", "cpu_s_per_s_worst", "step_cpu_s", "step_cpu_spread",
    "ns_per_particle_step", "repeats", "window_steps", "setup_cpu_s", "error_run_cpu_s", "bytes",
    "bytes_per_particle", "pairs", "gathered_bytes", "streamed_bytes", "multiply_adds",
    "bytes_moved_per_s",
]  # fmt: skip
OF_OPTIONS = [
    "nu", "formulation", "stabilisation", "projection", "cells", "momentum", "stress", "survived",
    "ns_per_particle_step", "cpu_s_per_s", "bytes_per_particle",
]  # fmt: skip
#: Headings of the tables of all runs.
HEADINGS = {"method": "method", "particles": "particles", "steps": "steps"}
SIZES = {
    "momentum": "momentum", "stress": "stress", "stress_size": "size", "twist_rms": "twist rms",
    "twist_end": "end", "energy": "energy", "energy_kept": "E/E0", "frequency": "frequency",
    "damping": "damping", "pulse": "error",
}  # fmt: skip
COSTS = {
    "cpu_s_per_s": "CPU s/s", "step_cpu_spread": "spread", "ns_per_particle_step": "ns/step",
    "bytes_per_particle": "B/particle", "setup_cpu_s": "set-up s", "survived": "survived",
}  # fmt: skip


def short(scene: str, nu: float) -> tuple[Method, ...]:
    """One method of each family but the dearest; of the problems that not everyone runs, two."""
    if not PROBLEMS[scene].everyone:
        return () if nu > POISSON[0] else (PACKAGE, B_BAR)
    return PACKAGE, LATTICE[6], MIXED[P_F], MIXED[PFJ], PLAIN[P_F], compared(nu)[-3], B_BAR


def _cells(method: Method, cells: int) -> int:
    """Elements of second order have nodes at half their edge: an even number of cells of these."""
    edge = 2 if method == TAYLOR_HOOD else 1
    return edge * -(-cells // edge)


def _case(scene: str, nu: float, method: Method, cells: int, *, is_reference: bool = False) -> Case:
    on = _cells(method, cells)
    cost = PROBLEMS[scene].cost(nu, on) * (3.0 if "H6" in method.name else 1.0)
    key = f"{scene} nu {nu:g} {method.name} 1/{on}" + (" reference" if is_reference else "")
    arguments = {"scene": scene, "nu": nu, "method": method, "cells": on, "until": END}
    return Case(key, run_case, arguments | {"compared": not is_reference}, cost)


def _timing(scene: str, nu: float, runs: Sequence[tuple[Method, int]], timing: Timing) -> Case:
    # Windows of a timing, and at least two steps in each.
    windows = sum(max(timing.window_s, 2e-6 * cells**3) for _, cells in runs)
    arguments = {"scene": scene, "nu": nu, "compared": runs, "timing": timing}
    key = f"{scene} nu {nu:g}, timed side by side"
    return Case(key, side_by_side, arguments, (1.0 + timing.rounds) * windows)


def cases(given: argparse.Namespace) -> list[Case]:
    """Every run of the study, each once; those of a problem and Poisson's ratio share a timing."""
    made: dict[str, Case] = {}
    timed: dict[tuple[str, float], list[tuple[Method, int]]] = {}
    for scene, nu, method, cells in _all(given.quick):
        case = _case(scene, nu, method, cells)
        if case.key not in made:
            made[case.key] = case
            timed.setdefault((scene, nu), []).append((method, _cells(method, cells)))
    cells = QUICK_REFERENCE if given.quick else PROBLEMS[COLUMN].finest
    known = [
        _case(COLUMN, nu, method, cells, is_reference=True)
        for nu in POISSON for method in REFERENCES
    ]  # fmt: skip
    timing = QUICK if given.quick else FULL
    return [*made.values(), *known, *(_timing(*of, runs, timing) for of, runs in timed.items())]


def _all(quick: bool) -> Iterator[tuple[str, float, Method, int]]:
    """Scene, Poisson's ratio, method and cells per metre of all that is compared."""
    for scene, problem in PROBLEMS.items():
        for nu in problem.nus:
            for method in short(scene, nu) if quick else methods_of(scene, nu):
                levels = problem.quick if quick else problem.levels
                if not quick and goes_finest(scene, method, nu):
                    levels = (*levels, problem.finest)
                for cells in levels:
                    yield scene, nu, method, cells
    for nu in POISSON:
        for method in () if quick and nu > POISSON[0] else options():
            yield CUBE, nu, method, PROBLEMS[CUBE].quick[0] if quick else 16


def warm_up(given: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    tiny = []
    for scene in (CUBE, COLUMN, JITTERED, TETRAHEDRA):
        methods = methods_of(scene, POISSON[1])
        runs = [_case(scene, POISSON[1], method, 2) for method in methods]
        tiny += [Case(one.key, one.run, dict(one.arguments) | {"until": 2e-3}) for one in runs]
        tiny.append(_timing(scene, POISSON[1], [(each, 2) for each in methods], Timing(1e-3, 1)))
    return tiny


def tables(rows: list[Row]) -> Tables:
    """``table``, ``iso_error``, ``ratios`` (and those of stabilised particles alone),
    ``by_method`` with ``medians``, ``equal_cost``, ``options``, ``recommendation``, ``reference``
    and ``history``.
    """
    everything = pd.DataFrame(rows, columns=None if rows else ["kind", "scene", *RUN])
    of_history = ["scene", *RUN, "time [s]", "twist [rad]", "energy [J]"]
    history = select(everything, kind="instant").reindex(columns=of_history)
    known = reference(history)
    runs = select(everything, kind="run").drop(columns=TIMED, errors="ignore")
    timings = select(everything, kind="timing").reindex(columns=["scene", *RUN, *TIMED])
    runs = runs.merge(timings, on=["scene", *RUN], how="left").dropna(axis=1, how="all")
    table = main_table(runs, column_errors(history, known))
    of_compared = [method.name for method in compared(POISSON[0])]
    iso = iso_table(table[table["method"].isin(of_compared)])
    alone = by_method(iso)
    return {
        "table": table,
        "iso_error": iso,
        "ratios": ratios(iso),
        "ratios_stabilised": ratios(iso[iso["stabilisation"] != "none"]),
        "by_method": alone,
        "medians": medians(alone),
        "equal_cost": equal_cost(table),
        "options": options_table(table),
        "recommendation": recommendation(table),
        "reference": known,
        "history": history,
    }


def main_table(runs: pd.DataFrame, errors: pd.DataFrame) -> pd.DataFrame:
    """One row a run in :data:`COLUMNS`; runs that only serve as reference have no cost."""
    if len(runs) == 0:
        return pd.DataFrame(columns=COLUMNS)
    errors = errors.assign(scene=COLUMN)
    table = runs.merge(errors, on=["scene", *RUN], how="left").reindex(columns=COLUMNS)
    table[["where", "why"]] = table[["where", "why"]].fillna("")
    per_second = table["steps"] / table["end_time"]
    per_evaluation = table["gathered_bytes"] + table["streamed_bytes"]
    spread = 1.0 + table["step_cpu_spread"]
    table["evaluations"] = table["evaluations_per_step"] * table["steps"]
    table["cpu_s_per_s"] = per_second * table["step_cpu_s"]
    table["cpu_s_per_s_worst"] = table["cpu_s_per_s"] * spread
    table["ns_per_particle_step"] = 1e9 * table["step_cpu_s"] / table["particles"]
    table["bytes_per_particle"] = table["bytes"] / table["particles"]
    table["bytes_moved_per_s"] = per_second * table["evaluations_per_step"] * per_evaluation
    return table


def options_table(table: pd.DataFrame) -> pd.DataFrame:
    """Formulation x stabilisation x projection on the cube, on the finest lattice of all."""
    names = [method.name for method in options()]
    shown = table[(table["scene"] == CUBE) & table["method"].isin(names)]
    count = shown.groupby(["nu", "cells"])["method"].transform("nunique")
    most = shown[count == count.groupby(shown["nu"]).transform("max")]
    finest = most[most["cells"] == most.groupby("nu")["cells"].transform("max")]
    return finest.sort_values("nu", kind="stable")[OF_OPTIONS]


def claims(tables: Tables) -> list[Claim]:
    """What was asked of lattices; SPH against FEM, problem by problem: how often it costs less."""
    found = [
        *front_claims(tables["by_method"], tables["medians"]), *slope_claims(tables["table"]),
    ]  # fmt: skip
    for name, what in (("ratios", "any particles"), ("ratios_stabilised", "stabilised particles")):
        for (scene, nu), part in tables[name].groupby(["scene", "nu"], sort=False):
            if name == "ratios_stabilised" and not PROBLEMS[scene].everyone:
                # All particles there are.
                continue
            outcome, where = part["outcome"], f"{PROBLEMS[scene].title}, nu = {nu:g}"
            decided = int(outcome.isin(DECIDED).sum())
            found.append(
                Claim.counted(
                    f"at equal error {what} cost less CPU time than FEM",
                    int((outcome == CHEAPER).sum()), decided, where=where,
                    wanted="all that can be compared",
                )
            )  # fmt: skip
    return found


def words(tables: Tables) -> Mapping[str, Any]:
    """Thresholds, what the comparisons came to, and the tables by scene and Poisson's ratio."""
    table, known, alone = tables["table"], tables["reference"], tables["by_method"]
    even = (50.0 * known["time [s]"]).round(6) % 1.0 == 0.0
    parts = []
    for scene, problem in PROBLEMS.items():
        for nu in problem.nus:
            names = [method.name for method in methods_of(scene, nu)]
            runs = select(table[table["method"].isin(names)], scene=scene, nu=nu)
            own = {name: of for name, of in SIZES.items() if runs[name].notna().any()}
            if len(runs):
                parts.append(
                    {"title": problem.title, "nu": nu, "runs": runs,
                     "columns": HEADINGS | own | COSTS}
                )  # fmt: skip
    shown = [method for nu in POISSON for method in front(nu)]
    return {
        "parts": parts, "some": counts(tables["ratios"]),
        "decided": decided_rows(tables["ratios"]), "each": by_error(alone),
        "by_scene": by_scene(alone),
        "same_cost_errors": at_cost(tables["equal_cost"]), "of_each": of_each(tables["medians"]),
        "ratio_formats": {"nu": "g"} | {method.name: ".2f" for method in shown},
        "error_formats": {"nu": "g", "1/h": ".0f"} | {method.name: ".1e" for method in shown},
        "default": PACKAGE.name, "lattice": LATTICE[sph.LatticeDifference().order].name,
        "stabilised": counts(tables["ratios_stabilised"]), "asked": ASKED,
        "equal": EQUAL, "certain": CERTAIN, "farthest": FARTHEST, "within": WITHIN,
        "same_cost": SAME_COST, "energy_made": ENERGY_MADE, "end": END,
        "gradient": LARGEST_GRADIENT, "known": known[even & (known["time [s]"] > 0.0)],
    }  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """One case at a time: nothing may compete with a timing."""
    parser.set_defaults(jobs=1, threads=cores())


_TIME, _MEMORY = "cpu_s_per_s", "bytes"
STUDY = Study(
    name="pareto",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={
        "pareto": partial(drawing, ((FAIR, "stress"), (COLUMN, "twist_rms")), _TIME),
        "fair_time": partial(drawing, ((FAIR, "momentum"), (FAIR, "stress")), _TIME),
        "linear_time": partial(drawing, ((LINEAR_FAIR, "stress"), (LINEAR, "stress")), _TIME),
        "clouds_time": partial(drawing, ((JITTERED, "stress"), (TETRAHEDRA, "stress")), _TIME),
        "waves_time": partial(drawing, ((VIBRATION, "frequency"), (PULSE, "pulse")), _TIME),
        "cube_time": partial(drawing, ((CUBE, "momentum"), (CUBE, "stress")), _TIME),
        "cube_memory": partial(drawing, ((CUBE, "momentum"), (CUBE, "stress")), _MEMORY),
        "column_time": partial(drawing, ((COLUMN, "twist_rms"), (COLUMN, "energy")), _TIME),
        "column_memory": partial(drawing, ((COLUMN, "twist_rms"), (COLUMN, "energy")), _MEMORY),
    },
    shown=("pareto",),
    words=words,
    text=Path(__file__).with_name("pareto.md"),
    arguments=arguments,
    warm_up=warm_up,
    description="Error against CPU time and memory of SPH and FEM.",
)
