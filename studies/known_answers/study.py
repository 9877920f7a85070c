"""Two scenes whose answer is known: ``python -m studies.known_answers``.

The cable is a bar of no Poisson's ratio on rollers, with d'Alembert's solution: a smooth pulse must
converge at second order, a step at the order its front allows.  The bending column has a first peak
of 2.989 m at 0.453 s by an independent finite element code.  Everything runs at the defaults.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import pandas as pd

from sphsolid import PF, scenes
from sphsolid.defaults import default_cfl, default_integrator, default_stabilisation
from studies.convergence.cases import said
from studies.harness.cases import Case, Row
from studies.harness.front import Results, Study
from studies.harness.results import Tables
from studies.known_answers.cases import LOADS, METHODS
from studies.report import folding
from studies.report.document import Document, Figure, Paragraph, Section, Table
from studies.report.order import order_table
from studies.report.plotting import (
    Curve,
    convergence_panel,
    method_look,
    outside_legend,
    panels,
    save_figure,
)
from studies.report.standard_sections import subtitle, what_failed, what_was_run

#: Independent finite elements [m], [s].
PEAK, PEAK_TIME = 2.989, 0.453
#: Allowed distance from it, of the finest run.
TOLERANCE = 0.02


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """Cable at three or four spacings, column at two or four."""
    listed = []
    for method in METHODS:
        if method != "SUPG-SPH {p,F,J}":
            for load in LOADS:
                for cells in (2, 4) if options.quick else (2, 4, 8, 16):
                    key = f"cable, {load}: {method} 1/{cells}"
                    arguments = {"method": method, "load": load, "cells": cells}
                    run = "studies.known_answers.cases:run_cable"
                    listed.append(Case(key, run, arguments, cost=0.02 * cells**2))
        for cells in (2,) if options.quick else (4, 6, 8, 10):
            key = f"bending column: {method} 1/{cells}"
            arguments = {"method": method, "cells": cells}
            run = "studies.known_answers.cases:run_bending"
            listed.append(Case(key, run, arguments, cost=0.01 * cells**4))
    return listed


def tables(rows: list[Row]) -> Tables:
    """``table``: orders and peaks; ``cable``: every error; ``bending``: every peak."""
    cable = pd.DataFrame(
        [row for row in rows if row["scene"] == "cable"],
        columns=[
            "load", "method", "field", "h", "error", "wall_stress", "wall_s", *folding.COLUMNS,
        ],
    )
    bending = pd.DataFrame(
        [row for row in rows if row["scene"] == "bending column"],
        columns=["method", "h", "peak", "time", "wall_s", *folding.COLUMNS],
    )
    bending["off"] = bending["peak"] / PEAK - 1.0
    orders = order_table(
        cable.drop(columns=["wall_stress", *folding.COLUMNS]), by=["load", "method", "field"]
    )
    return {"table": orders, "cable": cable, "bending": bending}


def verdicts(results: Tables) -> pd.DataFrame:
    """What was asked of the answers, and whether it is met; not by runs that folded."""
    rows: list[tuple[Any, ...]] = []
    orders, cable = results["table"], results["cable"]
    for (load, method), found in orders.groupby(["load", "method"], sort=False):
        last = found.set_index("field")["order_last"]
        asked = {"pulse": 1.9, "step": 0.9}[str(load)]
        judged = last.min() if load == "pulse" else last["u"]
        what = "worst of p, P, u" if load == "pulse" else "displacement"
        runs = cable[(cable["load"] == load) & (cable["method"] == method)]
        met = bool(judged >= asked) and not bool(folding.has_folded(runs).any())
        rows.append((f"cable, {load}: order of {what}", method, judged, asked, met))
        if load == "step":
            rows.append(
                ("cable, step: order of p and P", method, last[["p", "P"]].min(), float("nan"),
                 "front, see text"),
            )  # fmt: skip
    for method, found in results["bending"].groupby("method", sort=False):
        finest = found.sort_values("h").iloc[0]
        off = abs(float(finest["off"]))
        met = off <= TOLERANCE and not bool(finest["folded"])
        rows.append(("bending column: peak off by", method, off, TOLERANCE, met))
    frame = pd.DataFrame(rows, columns=["what", "method", "measured", "asked", "met"])
    frame["met"] = [
        {True: "met", False: "not met"}.get(met, met) for met in frame["met"]
    ]
    return frame


def _of_the_package() -> str:
    integrator = default_integrator()
    cfl = default_cfl(integrator)
    solids = (scenes.cable().material, scenes.bending_column().material)
    chosen = [default_stabilisation(PF(), material) for material in solids]
    weighting = "self-adjoint" if chosen[0].is_self_adjoint else "printed"
    times = sorted({said(supg.tau_F) for supg in chosen})
    return (
        f"{integrator.name} at CFL {cfl:g}, {chosen[0].name} with {weighting} weighting, tau_F = "
        f"{' and '.join(times)}"
    )


def _as_without_J(bending: pd.DataFrame) -> str:
    peaks = bending.pivot_table(index="h", columns="method", values="peak")
    if not {"SUPG-SPH {p,F}", "SUPG-SPH {p,F,J}"} <= set(peaks):
        return ""
    apart = (peaks["SUPG-SPH {p,F,J}"] / peaks["SUPG-SPH {p,F}"] - 1.0).abs().max()
    if apart > 1e-9:
        return ""
    return (
        f" {{p,F,J}} repeats {{p,F}} (within {apart:.0e}): at this Poisson's ratio there is no "
        "tau_p by default, and the drift of position Verlet is exact, so J stays det F."
    )


def report(results: Results) -> Document:
    """Verdicts, orders of the cable, peaks of the column."""
    figure, axes = panels(1, 2, width=3.4)
    cable = results.tables["cable"]
    for ax, load in zip(axes.flat, LOADS, strict=True):
        curves = []
        for (method, field), found in cable[cable["load"] == load].groupby(["method", "field"]):
            look = method_look("bbar" if "FEM" in method else method)
            look["linestyle"] = {"p": "-", "P": "--", "u": ":"}[field]
            curves.append(Curve(f"{method}, {field}", found["h"], found["error"], look))
        convergence_panel(ax, curves, title=f"cable, {load}")
    outside_legend(figure, axes.flat)
    stem = save_figure(figure, results.out / "cable")
    numbers = {"measured": ".3g", "asked": ".3g"}
    return Document(
        title="Known answers: the cable and the bending column",
        subtitle=subtitle(results.run),
        abstract=(
            "Both solvers at their defaults on a bar with d'Alembert's solution and on a column "
            "whose first peak is known from an independent finite element code. SUPG-SPH: "
            f"{_of_the_package()}."
        ),
        sections=[
            Section("Asked and met", [Table("Verdicts.", verdicts(results.tables), numbers)]),
            Section(
                "Cable",
                [
                    Paragraph(
                        "L = 10 m, E = 200 GPa, rho0 = 8000 kg/m^3, nu = 0, fixed at X = 0, pulled "
                        "at the other end; two cells wide, on rollers. Relative L2 errors over one "
                        "period. After a step a jump travels through the bar: a second-order "
                        "scheme without limiter meets it with order 1/3 in momentum and stress and "
                        "1 in displacement, whatever the method. The pulse is small enough for the "
                        "linear solution to be exact (strain 5e-8)."
                    ),
                    Figure("Errors over one period.", stem),
                    Table("Orders.", results.tables["table"]),
                    Table(
                        "Error of the doubled stress at the wall after a step.",
                        cable[(cable["load"] == "step") & (cable["field"] == "P")][
                            ["method", "h", "wall_stress"]
                        ],
                    ),
                ],
            ),
            Section(
                "Bending column",
                [
                    Paragraph(
                        f"First peak of u_x at the centre of the top; independent finite elements "
                        f"give {PEAK} m at {PEAK_TIME} s. Histories are read every millisecond."
                        + _as_without_J(results.tables["bending"])
                    ),
                    Table("Peaks.", results.tables["bending"], {"peak": ".4f", "time": ".3f"}),
                ],
            ),
            what_was_run(results.run),
            what_failed(results.failures),
        ],
    )


STUDY = Study(
    name="known_answers",
    cases=cases,
    tables=tables,
    report=report,
    summary=lambda found: verdicts(found).to_string(index=False),
    description="The cable against d'Alembert, the bending column against a known peak.",
)
