"""What was asked of the convergence study, and whether its tables meet it."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from studies.convergence.figures import select
from studies.harness.front import Results
from studies.report.document import Table


def _verdicts(results: Results) -> Iterable[tuple[str, str, float, float, str]]:
    """Requirement, where, measured, wanted, verdict."""
    summary = results.tables["summary"]
    sph = select(summary, method="SUPG-SPH", nu=0.3, projection="local", xi_F=0.0)
    asked = [
        ("momentum slope, Consistent", sph, "Consistent", "slope_p_last", 1.95),
        ("momentum slope, Consistent(force)", sph, "Consistent(force)", "slope_p_last", 1.95),
        ("stress slope, Consistent", sph, "Consistent", "slope_P_last", 1.65),
        ("stress slope, Consistent(force)", sph, "Consistent(force)", "slope_P_last", 1.90),
    ]
    for what, frame, operator, column, wanted in asked:
        part = select(frame, operator=operator)
        if len(part) and part[column].notna().any():
            worst = part.loc[part[column].idxmin()]
            where = (
                f"{worst['scene']}, {worst['family']}, {worst['formulation']} "
                f"{worst['secondary']}"
            )
            yield what, where, worst[column], wanted, _verdict(worst[column] >= wanted)
    literal = select(sph, operator="Literal")
    if len(literal):
        best = literal["slope_P_last"].max()
        yield "best stress slope, Literal", "all", best, float("nan"), "reported"
    for method, nu in (("B-bar FEM", 0.3), ("B-bar FEM", 0.499)):
        part = select(summary, method=method, nu=nu)
        for column, name in (("slope_p_last", "momentum"), ("slope_P_last", "stress")):
            if len(part):
                worst_slope = part[column].min()
                yield (
                    f"{name} slope, {method}, nu {nu:g}", "all", worst_slope, 1.95,
                    _verdict(worst_slope >= 1.95),
                )  # fmt: skip
    yield from _error_verdicts(results.tables["table"])
    near = select(summary, method="SUPG-SPH", nu=0.499)
    if len(near):
        worst = near.loc[near["slope_p_last"].idxmin()]
        yield (
            "momentum slope, nu 0.499", f"{worst['formulation']} {worst['secondary']}",
            worst["slope_p_last"], 1.95, _verdict(worst["slope_p_last"] >= 1.95),
        )  # fmt: skip


def _error_verdicts(table: pd.DataFrame) -> Iterable[tuple[str, str, float, float, str]]:
    """Errors at 17^3, linear limit, A+B+C=0, against what was asked."""
    part = select(table, scene="linear", family="A+B+C=0", h=1.0 / 16.0, method="SUPG-SPH")
    basic = select(part, nu=0.3, formulation="{p,F}", secondary="H1")
    asked = [
        ("Consistent", "p", "x", 2.6e-3),
        ("Consistent(force)", "p", "x", 2.6e-3),
        ("Consistent", "P", "xx", 1.0e-2),
        ("Consistent(force)", "P", "xx", 5.5e-3),
    ]
    for operator, field, component, wanted in asked:
        runs = select(basic, operator=operator, field=field, component=component)
        for row in runs.sort_values(["projection", "xi_F"], ascending=False).itertuples():
            where = "no projection" if row.projection == "none" else "projected"
            yield (
                f"{field}_{component} at 17^3, {operator}", f"{where}, xi_F {row.xi_F:g}",
                row.error, wanted, _verdict(row.error <= wanted),
            )  # fmt: skip
    near = select(part, nu=0.499, field="p", component="x")
    for row in near.itertuples():
        yield (
            "p_x at 17^3, nu 0.499", f"{row.formulation} {row.secondary}", row.error, 3.2e-3,
            _verdict(row.error <= 3.2e-3),
        )  # fmt: skip


def _verdict(holds: bool) -> str:
    return "met" if holds else "not met"


def verdict_table(results: Results) -> Table:
    """One row per requirement: the worst case measured, what was asked, the verdict."""
    frame = pd.DataFrame(
        list(_verdicts(results)), columns=["what", "worst case", "measured", "asked", "verdict"]
    )
    # Slopes are read with two decimals, errors in powers of ten: one column of text serves both.
    for column in ("measured", "asked"):
        frame[column] = [
            "–" if value != value else (f"{value:.2f}" if value > 0.05 else f"{value:.2e}")
            for value in frame[column]
        ]
    return Table(
        "What was asked of the study and what it gave: the worst slope of the last refinement "
        "over all components, families, scenes, formulations and secondary points, and errors at "
        "17^3 particles in the linear limit, A+B+C=0, of {p,F} SUPG-SPH-H1.",
        frame,
    )
