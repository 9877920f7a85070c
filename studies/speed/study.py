"""Where does the time of a step go, and how far is it from what the machine can do?

``python -m studies.speed`` times whole steps (all stages, time-step control, boundary conditions)
and single passes on the swinging cube, counts what they must compute and move, and measures the
machine's bandwidth and arithmetic in the same run.  Timings are minima of repeats on a shared
machine: compare the rows of one run, not runs of different days.
"""

from __future__ import annotations

import argparse
from typing import Any

import pandas as pd

from studies.harness.cases import Case, Row
from studies.harness.front import Study
from studies.harness.provenance import cores
from studies.harness.results import Tables
from studies.speed.report import report
from studies.speed.targets import targets

COLUMNS = [
    "solver", "cloud", "storage", "formulation", "secondary", "weighting", "tau_p", "projects",
    "integrator", "cfl", "neighbours", "particles", "threads", "ns_per_particle_step",
    "ns_per_particle_crossing", "bytes_per_particle", "flops_per_particle",
    "traffic_per_particle", "roofline_share", "setup_s",
]  # fmt: skip
PASS_COLUMNS = [
    "cloud", "formulation", "weighting", "particles", "threads", "pass", "ns_per_particle",
    "flops_per_particle", "traffic_per_particle", "roofline_share",
]  # fmt: skip
_DEFAULT: dict[str, Any] = {
    "formulation": "{p,F,J}", "secondary": "H1", "weighting": "self-adjoint", "tau_p": 0.0,
    "projects": True, "integrator": "position Verlet", "jitter": 0.0,
}  # fmt: skip
_PAPER: dict[str, Any] = _DEFAULT | {"weighting": "as printed", "integrator": "TVD-RK2"}


def _step(cells: int, threads: int, **changes: Any) -> Case:
    options = _DEFAULT | changes
    words = [str(value) for value in options.values()]
    key = " ".join([*words, f"1/{cells}", f"{threads} thread(s)"])
    arguments = options | {"cells": cells, "threads": threads}
    return Case(key, "studies.speed.cases:sph_step", arguments, 1.0 + (cells / 32) ** 3)


def _fem(cells: int, threads: int) -> Case:
    arguments = {"element": "B-bar FEM", "cells": cells, "threads": threads}
    key = f"B-bar FEM 1/{cells} {threads} thread(s)"
    return Case(key, "studies.speed.cases:fem_step", arguments, 1.0 + (cells / 32) ** 3)


def cases(options: argparse.Namespace) -> list[Case]:
    """33^3 on one and all threads; the full form adds options, sizes, disorder and the column."""
    most = options.threads
    counts = sorted({1, most})
    listed = [
        Case(f"machine {n}", "studies.speed.cases:machine_speed", {"threads": n}, 0.5)
        for n in counts
    ]
    for n in counts:
        listed += [_step(32, n), _step(32, n, **_PAPER), _fem(32, n)]
    if options.quick:
        return listed
    for formulation in ("{p,F}", "{p,F,J}", "{p,F,H,J}", "displacement"):
        for secondary, weighting, tau_p in (
            ("-", "-", 0.0),
            ("H1", "as printed", 0.0),
            ("H1", "self-adjoint", 0.0),
            ("H1", "self-adjoint", 0.1),
            ("H6", "self-adjoint", 0.0),
        ):
            for projects in (True, False):
                if tau_p and not formulation.endswith("J}"):
                    continue
                if not projects and (secondary == "H6" or tau_p or weighting == "as printed"):
                    continue
                changes: dict[str, Any] = {
                    "formulation": formulation, "secondary": secondary, "weighting": weighting,
                    "tau_p": tau_p, "projects": projects,
                }  # fmt: skip
                case = _step(32, most, **changes)
                if case.key not in {each.key for each in listed}:
                    listed.append(case)
    listed.append(_step(32, most, integrator="SSP-RK3"))
    listed += [_step(32, n, jitter=0.2) for n in counts]
    listed += [_step(32, n, **(_PAPER | {"jitter": 0.2})) for n in counts]
    for cells in (22, 64, 100):
        listed.append(_step(cells, most))
    listed += [_step(64, most, **_PAPER), _fem(64, most)]
    listed.append(Case("plain 1/24", "studies.speed.cases:plain", {"cells": 24}, 1.0))
    listed.append(Case("start-up", "studies.speed.cases:start_up", {}, 2.0))
    for integrator in ("position Verlet", "SSP-RK3", "TVD-RK2"):
        arguments = {"integrator": integrator, "cells": 5}
        listed.append(
            Case(f"column {integrator}", "studies.speed.cases:column", arguments, 1.0)
        )
    return listed


def warm_up(options: argparse.Namespace) -> list[Case]:
    """Tiny runs that compile every kernel of the study."""
    return [
        _step(2, options.threads, tau_p=0.1),
        _step(2, options.threads, **_PAPER),
        _fem(2, options.threads),
    ]


def tables(rows: list[Row]) -> Tables:
    """``table`` of steps, ``passes``, ``options``, ``machine``, ``other`` and ``targets``."""
    everything = pd.DataFrame(rows)
    machine = _of(everything, "machine", ["threads", "bandwidth", "flops"])
    steps = _with_share(_of(everything, "step", COLUMNS), machine, "ns_per_particle_step")
    alone = _with_share(_of(everything, "pass", PASS_COLUMNS), machine, "ns_per_particle")
    found = {
        "table": steps,
        "passes": alone,
        "machine": machine,
        "column": _of(
            everything,
            "column",
            ["integrator", "settings", "particles", "steps", "evaluations", "cpu_s",
             "cpu_ms_per_particle", "energy_kept"],
        ),
        "plain": _of(everything, "plain", ["particles", "ns_plain", "ns_compiled", "ratio"]),
        "start": _of(everything, "start", ["cold_s", "warm_s"]),
    }  # fmt: skip
    return found | {"targets": targets(found)}


def _of(everything: pd.DataFrame, kind: str, columns: list[str]) -> pd.DataFrame:
    if "kind" not in everything:
        return pd.DataFrame(columns=columns)
    return everything[everything["kind"] == kind].reindex(columns=columns).reset_index(drop=True)


def _with_share(table: pd.DataFrame, machine: pd.DataFrame, time: str) -> pd.DataFrame:
    """Share of the time that the machine itself would need for the traffic or the arithmetic."""
    by_threads = machine.set_index("threads")
    needs = pd.concat(
        [
            table["traffic_per_particle"] / table["threads"].map(by_threads["bandwidth"]),
            table["flops_per_particle"] / table["threads"].map(by_threads["flops"]),
        ],
        axis=1,
    ).max(axis=1)
    return table.assign(roofline_share=1.0e9 * needs / table[time])


def arguments(parser: argparse.ArgumentParser) -> None:
    """Timings run one at a time with all cores."""
    parser.set_defaults(jobs=1, threads=cores())


STUDY = Study(
    name="speed",
    cases=cases,
    tables=tables,
    report=report,
    arguments=arguments,
    warm_up=warm_up,
    description="Cost of a step and of its passes, against the machine; each timing runs alone.",
)
