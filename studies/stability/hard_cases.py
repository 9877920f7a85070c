"""The hard cases: which methods are put to which problems.

A method is one entry in :data:`METHODS`, a problem is one in :data:`CASES`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pandas as pd

import sphsolid as sph
from studies.engine.case import Case, Row
from studies.engine.plotting import ORANGE, SKY
from studies.methods import (
    B_BAR,
    DISPLACEMENT,
    PACKAGE,
    PAPER,
    SUPG,
    UNSTABILISED,
    Method,
    Times,
)
from studies.stability.hard_problems import Checkerboard, Column, Problem, Pulled, Punch, Seed

#: The paper's settings of its column with H1.
PAPER_COLUMN = PAPER.but(
    name="paper", label="paper: {p,F,H,J}, H1, tau_F = dt, xi_F = 0.2, tau_p = 0.1 dt",
    formulation=sph.PFHJ(), xi_F=0.2, tau_p=sph.OfStep(0.1),
)  # fmt: skip
WITHOUT_J = SUPG.but(formulation=sph.PF(), marker="^")
RK3 = SUPG.but(integrator=sph.SSPRK3(), colour=ORANGE, marker="<")
#: What the package chose before the self-adjoint weighting.
PRINTED = RK3.but(
    name="self-adjoint SUPG, SSP-RK3, printed", colour=SKY, marker=">",
    weighting=sph.AsPrinted(), tau_F=sph.OfStep(0.5), tau_p=sph.OfStep(0.1),
)  # fmt: skip
#: Every method that is put to the short cases.
METHODS = (
    PACKAGE, SUPG, WITHOUT_J, RK3, PRINTED, PAPER_COLUMN, UNSTABILISED, DISPLACEMENT, B_BAR,
)  # fmt: skip
#: Evidence for choices among SUPG methods: not put to the long columns and the waves.
_SHORT_ONLY = (WITHOUT_J, RK3, PRINTED, DISPLACEMENT)
LONG_METHODS = tuple(method for method in METHODS if method not in _SHORT_ONLY)
#: SUPG methods, of which the paper's claims speak.
STABILISED = tuple(
    m.name for m in METHODS if m not in (PACKAGE, UNSTABILISED, DISPLACEMENT, B_BAR)
)
#: One change of self-adjoint SUPG each: the evidence for what it is.
VARIANTS = (
    SUPG.but(cfl=0.5), SUPG.but(cfl=0.8), SUPG.but(tau_F=Times(0.5)),
    SUPG.but(tau_F=Times(2.0)), SUPG.but(tau_F=Times(4.0)), SUPG.but(tau_p=0.0),
)  # fmt: skip
OTHER_STEPS, WITHOUT_TAU_P = tuple(each.name for each in VARIANTS[:2]), VARIANTS[-1].name
#: What the answers of the columns and the punch are compared with.
REFERENCE = B_BAR.but(name="B-bar FEM, half spacing")
#: What the default is held against where more is asked of it; it judges no other method.
FINE = B_BAR.but(name="B-bar FEM, twice as fine")
_QUICK = (PACKAGE, SUPG, WITHOUT_J, PRINTED, B_BAR, VARIANTS[1])


@dataclass(frozen=True)
class HardCase:
    """One problem on one lattice of ``cells`` a metre.

    ``reference`` names the case whose run with elements says what the answer should be; if it is
    its own and ``fine``, elements of half the spacing run it too; with ``held_against`` they run it
    as :data:`FINE`.  ``cost`` in seconds, roughly; ``short`` the cells of ``--quick``; ``methods``
    who runs it.
    """

    name: str
    problem: Problem
    cells: int
    cost: float = 1.0
    reference: str = ""
    short: int = 0
    fine: bool = True
    methods: tuple[Method, ...] = METHODS
    held_against: bool = False


#: How the names of cases begin that only a few methods run.
LONG_COLUMN, FAST_COLUMN = "long column", "fast column"
#: The two cases in which the default is held against finer elements.
AT_200, AT_300 = "column, Omega 200", f"{FAST_COLUMN} 1/8, Omega 300"
#: Time of the long columns [s]: twice the paper's, a whole swing of a compressible one.
LONG = 0.2


def _columns() -> Iterator[HardCase]:
    for omega, cost in ((105, 4.0), (200, 5.5), (300, 6.5)):
        name = f"column, Omega {omega}"
        # Beyond 105 rad/s the fine reference takes minutes: the coarse one judges.
        first = omega == 105
        yield HardCase(
            name, Column(float(omega)), 5, cost, name, 3 if first else 0, first,
            held_against=name == AT_200,
        )  # fmt: skip
    for nu, cost in ((0.495, 0.9), (0.499, 1.8), (0.4999, 6.0)):
        # The answer hardly depends on nu there, the reference's cost does.
        near = f"column 4x19x4, nu {min(nu, 0.499):g}"
        yield HardCase(f"column 4x19x4, nu {nu:g}", Column(poisson_ratio=nu), 3, cost, near)
    for percent, cost in ((0, 2.0), (20, 3.3), (40, 4.2)):
        name, problem = f"column 5x25x5, jitter {percent} %", Column(jitter=percent / 100.0)
        yield HardCase(name, problem, 4, cost, "column, Omega 105")


def _long_columns() -> Iterator[HardCase]:
    """Softer solids, and longer: the lattices on which the positions fold, and do not."""
    for nu, stiff in ((0.3, 0.25), (0.4, 0.35), (0.45, 0.5), (0.495, 1.4)):
        for cells, jitter in ((4, 0.0), (5, 0.0), (5, 0.4), (6, 0.0), (8, 0.0)):
            name = f"{LONG_COLUMN} 1/{cells}{', jitter 40 %' if jitter else ''}, nu {nu:g}"
            cost = 4.0 * stiff * (cells / 4.0) ** 4 * (1.7 if jitter else 1.0)
            short = 2 if (cells, jitter, nu) == (4, 0.0, 0.3) else 0
            problem = Column(poisson_ratio=nu, jitter=jitter, end_time=LONG)
            yield HardCase(name, problem, cells, cost, name, short, False, LONG_METHODS)
    yield HardCase(
        AT_300, Column(300.0), 8, 40.0, AT_300, 0, False, (PACKAGE, B_BAR), held_against=True
    )


#: To 0.1 s but for the long columns; the 6x31x6 lattice where none is named.
CASES = (
    *_columns(),
    HardCase("punch, initial", Punch(held=False), 20, 2.2, "punch, initial", 10),
    HardCase("punch, held", Punch(held=True), 20, 5.0, "punch, held", 10),
    HardCase("seeded sawtooth", Seed("sawtooth"), 6, 3.0, short=3),
    HardCase("seeded hourglass", Seed("hourglass"), 6, 3.0),
    HardCase("seeded noise", Seed("noise"), 6, 3.0),
    HardCase("seeded checkerboard", Checkerboard(), 6, 3.0, short=3),
    HardCase("pulled to stretch 2", Pulled(), 8, 4.0, short=4),
    *_long_columns(),
)
#: The cases that variants are put to: one of each sort, and the worst.
KEY_CASES = (
    "column, Omega 105", "column, Omega 200", "column 4x19x4, nu 0.4999",
    "column 5x25x5, jitter 20 %", "punch, initial", "punch, held", "seeded sawtooth",
    "seeded checkerboard", "pulled to stretch 2",
)  # fmt: skip
COLUMNS = (
    "case", "method", "cells", "formulation", "stabilisation", "operator", "h_over_dx",
    "integrator", "particles", "end_time", "applicable", "survived", "diverged_at", "where",
    "folded", "folded_at", "steps", "energy_kept", "energy_gain", "energy_at_tenth",
    "dissipated_p", "dissipated_J", "dissipated_restraint", "energy_projection",
    "energy_defect", "energy_rest", "J_min", "J_max", "unseen_rms",
    "unseen_max", "inside_out", "smallest_det", "noise_end", "noise_max", "answer", "answer_is",
    "top_height", "noise_left", "clumping", "why", "wall_s", "cpu_s",
)  # fmt: skip


def run_case(*, case: str, problem: Problem, method: Method, cells: int) -> list[Row]:
    """One row: whether the method lasts, where its energy went, and its answer."""
    row = {"part": "hard", "case": case, "method": method.name, "cells": cells, "applicable": True}
    return [row | problem.row(method, 1.0 / cells)]


def _case(case: HardCase, method: Method, cells: int) -> Case:
    arguments = {"case": case.name, "problem": case.problem, "method": method, "cells": cells}
    cost = case.cost * (cells / case.cells) ** 4
    return Case(f"{case.name}: {method.name}", run_case, arguments, cost)


def hard_cases(*, quick: bool) -> Iterator[Case]:
    """Every method with every case, the key cases with the variants, the references."""
    for case in CASES:
        methods = case.methods + (VARIANTS if case.name in KEY_CASES else ())
        if not quick:
            yield from (_case(case, method, case.cells) for method in methods)
            if case.reference == case.name and case.fine:
                yield _case(case, REFERENCE, 2 * case.cells)
            if case.held_against:
                yield _case(case, FINE, 2 * case.cells)
        elif case.short:
            yield from (_case(case, m, case.short) for m in methods if m in _QUICK)


def tiny_cases() -> Iterator[Case]:
    """Every kernel of the hard cases, compiled on next to nothing."""
    by_name = {case.name: case for case in CASES}
    for method in (PACKAGE, PAPER_COLUMN, PRINTED, WITHOUT_J, DISPLACEMENT, UNSTABILISED):
        yield _case(by_name["punch, held"], method, 4)
    yield _case(by_name["column 5x25x5, jitter 40 %"], PACKAGE, 2)
    yield _case(by_name["pulled to stretch 2"], SUPG, 2)
    yield _case(by_name["column, Omega 105"], B_BAR, 2)


def hard_table(rows: list[Row]) -> pd.DataFrame:
    """One row a case and method, in the order of the cases."""
    return pd.DataFrame([row for row in rows if row.get("part") == "hard"], columns=[*COLUMNS])
