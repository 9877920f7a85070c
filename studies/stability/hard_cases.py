"""The hard cases: what each is, and with which methods."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from studies.harness.cases import Case, Row
from studies.stability.hard_case_judgement import judged
from studies.stability.hard_case_methods import FEM, FEW, METHODS, REFERENCE, VARIANTS, Method


@dataclass(frozen=True)
class HardCase:
    """One problem on one lattice; ``reference`` names the case whose reference run it shares.

    If it is its own and ``fine``, it is run by ``REFERENCE`` too.  ``cost`` in seconds of {p,F,J}
    H1 with TVD-RK2 at CFL 0.3; ``short`` the coarse form of ``--quick``; ``methods`` who runs it.
    """

    name: str
    kind: str
    cells: int
    arguments: dict[str, Any] = field(default_factory=dict)
    cost: float = 1.0
    reference: str = ""
    short: int = 0
    fine: bool = True
    methods: tuple[Method, ...] = METHODS


#: Time of the long columns [s]: twice the paper's, a whole swing of a compressible one.
LONG = 0.2
LONG_COLUMN = "long column"


def _long_columns() -> Iterable[HardCase]:
    """Softer solids, and longer: the lattices on which today's positions fold, and do not."""
    for nu in (0.3, 0.4, 0.45, 0.495):
        stiff = {0.3: 0.25, 0.4: 0.35, 0.45: 0.5}.get(nu, 1.4)
        for cells, jitter in ((4, 0.0), (5, 0.0), (5, 0.4), (6, 0.0), (8, 0.0)):
            name = f"{LONG_COLUMN} 1/{cells}{', jitter 40 %' if jitter else ''}, nu {nu:g}"
            yield HardCase(
                name, "column", cells,
                {"poisson_ratio": nu, "jitter": jitter, "end_time": LONG},
                4.0 * stiff * (cells / 4.0) ** 4 * (1.7 if jitter else 1.0), name, fine=False,
                short=2 if (cells, jitter, nu) == (4, 0.0, 0.3) else 0, methods=FEW,
            )  # fmt: skip


def _columns() -> Iterable[HardCase]:
    for omega, cost in ((105, 4.0), (200, 5.5), (300, 6.5)):
        name = f"column, Omega {omega}"
        yield HardCase(
            # Beyond 105 rad/s the fine reference takes minutes: the coarse one judges.
            name, "column", 5, {"angular_velocity": float(omega)}, cost,
            name, fine=omega == 105,
            short=3 if omega == 105 else 0,
        )  # fmt: skip
    for nu, cost in ((0.495, 0.9), (0.499, 1.8), (0.4999, 6.0)):
        name = f"column 4x19x4, nu {nu:g}"
        # The answer hardly depends on nu there, the reference's cost does.
        near = name if nu < 0.4999 else "column 4x19x4, nu 0.499"
        yield HardCase(name, "column", 3, {"poisson_ratio": nu}, cost, near)
    for percent, cost in ((0, 2.0), (20, 3.3), (40, 4.2)):
        yield HardCase(
            f"column 5x25x5, jitter {percent} %", "column", 4, {"jitter": percent / 100.0}, cost,
            "column, Omega 105",
        )  # fmt: skip


#: To 0.1 s but for the long columns; the 6x31x6 lattice where none is named.  ``cells`` are a
#: metre.
CASES = (
    *_columns(),
    HardCase(
        "punch, initial", "pressed", 20, {"held": False, "end_time": 0.03}, 2.2, "punch, initial",
        short=10,
    ),
    HardCase(
        "punch, held", "pressed", 20, {"held": True, "end_time": 0.03}, 5.0, "punch, held", short=10
    ),
    HardCase("seeded sawtooth", "seeded", 6, {"pattern": "sawtooth"}, 3.0, short=3),
    HardCase("seeded hourglass", "seeded", 6, {"pattern": "hourglass"}, 3.0),
    HardCase("seeded noise", "seeded", 6, {"pattern": "noise"}, 3.0),
    HardCase("seeded checkerboard", "checkerboard", 6, {}, 3.0, short=3),
    HardCase("pulled to stretch 2", "pulled", 8, {}, 4.0, short=4),
    *_long_columns(),
)
CASE_NAMES = tuple(case.name for case in CASES)
#: The cases that variants are put to: one of each sort, and the worst.
KEY_CASES = (
    "column, Omega 105", "column, Omega 200", "column 4x19x4, nu 0.4999",
    "column 5x25x5, jitter 20 %", "punch, initial", "punch, held", "seeded sawtooth",
    "seeded checkerboard", "pulled to stretch 2",
)  # fmt: skip
_QUICK_METHODS = ("defaults", "{p,F} H1", "{p,F,J} H1", "{p,F,J} H1, printed", "B-bar FEM")
_QUICK_VARIANTS = ("CFL 0.8",)
_DEARER = {"H6": 2.0, "-": 0.6}


_STEP = {"TVD-RK2": 0.3, "SSP-RK3": 0.45, "position Verlet": 0.15, "-": 0.6}


def _case(case: HardCase, method: Method, cells: int) -> Case:
    arguments = {
        "case": case.name, "method": method.arguments(), "kind": case.kind,
        "cells": cells, "arguments": case.arguments,
    }  # fmt: skip
    cost = case.cost * _DEARER.get(method.secondary, 1.0) * (cells / case.cells) ** 4
    cost *= _STEP[method.integrator] / method.cfl
    return Case(f"{case.name}: {method.name}", "studies.stability.hard_case_runs:run", arguments,
                cost)  # fmt: skip


def hard_cases(quick: bool) -> list[Case]:
    """Every method with every case, some by variants; the references."""
    listed = []
    for case in CASES:
        if quick and not case.short:
            continue
        cells = case.short if quick else case.cells
        for method in case.methods:
            if not quick or method.name in _QUICK_METHODS:
                listed.append(_case(case, method, cells))
        for variant in VARIANTS:
            if case.name in KEY_CASES and (not quick or variant.name in _QUICK_VARIANTS):
                listed.append(_case(case, variant, cells))
        if case.reference == case.name and case.fine and not quick:
            listed.append(_case(case, REFERENCE, 2 * cells))
    return listed


def hard_case_warm_up() -> list[Case]:
    """Tiny runs that compile every kernel: all of the punch's, the column's and the blocks'."""
    by_name = {case.name: case for case in CASES}
    chosen = {method.name: method for method in METHODS}
    pairs = [
        ("punch, held", "{p,F,H,J} H1, paper's settings", 4),
        ("punch, held", "{p,F,J} H1, printed", 4),
        ("punch, held", "{p,F} H1", 4),
        ("punch, held", "displacement SPH", 4),
        ("punch, held", "{p,F,J} unstabilised", 4),
        ("pulled to stretch 2", "{p,F,J} H1", 2),
        ("column, Omega 105", "B-bar FEM", 2),
    ]
    return [_case(by_name[case], chosen[name], cells) for case, name, cells in pairs]


def hard_case_table(rows: list[Row]) -> pd.DataFrame:
    """One row per case and method in the order of the cases, judged."""
    table = pd.DataFrame(
        [row for row in rows if row.get("part") == "hard"], columns=[*COLUMNS]
    ).drop(columns="part")
    references = {case.name: case.reference for case in CASES}
    return judged(table, references, REFERENCE.name, FEM.name)


COLUMNS = (
    "part", "case", "method", "cells", "solver", "formulation", "secondary", "operator",
    "weighting", "tau_F", "xi_F", "tau_p", "h_over_dx", "integrator", "cfl", "particles",
    "steps", "end_time", "applicable", "survived", "lost_time", "lost_step", "lost_particle",
    "lost_X", "lost_Y", "lost_Z", "reason", "energy_kept", "energy_gain", "dissipated_p",
    "dissipated_J", "energy_projection", "energy_defect", "energy_rest", "J_min", "J_max",
    "unseen_rms", "unseen_max", "inside_out", "smallest_det",
    "noise_end", "noise_max", "answer", "answer_is", "noise_left", "clumping", "wall_s",
)  # fmt: skip
