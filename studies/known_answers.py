"""Scenes whose answer is known: ``python -m studies.known_answers``.

A cable (d'Alembert's solution) and a bending column (a peak by independent finite elements).
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sphsolid import PF, PFJ
from sphsolid.defaults import default_cfl, default_integrator
from sphsolid.record import Errors, PointField, Probe, l2_norm, period_errors
from sphsolid.scenes import Pulse, Step, bending_column, cable
from studies.engine.plotting import Curve, convergence_panel, outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures import folding
from studies.measures.order import order_table
from studies.methods import B_BAR, PACKAGE, SUPG, Method

#: {p,F,J} repeats {p,F} where the material asks for no ``tau_p``: shown, not assumed.
COMPARED = (SUPG.but(formulation=PF()), SUPG.but(formulation=PFJ()), PACKAGE, B_BAR)
#: What is run on the cable.
ON_CABLE = (COMPARED[0], PACKAGE, B_BAR)
#: A pulse small enough for the linear solution to be exact; the published step [Pa].
LOADS: dict[str, tuple[Pulse | Step, float]] = {"pulse": (Pulse(), 1.0e4), "step": (Step(), 5.0e7)}
#: First peak of the bending column by independent finite elements [m], and its time [s].
PEAK, PEAK_TIME = 2.989, 0.453
#: Asked: order of the worst field after a pulse, of the displacement after a step; distance of the
#: peak of the finest run from the independent one.
ORDERS, TOLERANCE = {"pulse": 1.9, "step": 0.9}, 0.02
_INSTANTS = 16


def cases(options: argparse.Namespace) -> Sequence[Case]:
    """The cable at up to four spacings, the column at up to four."""
    listed = []
    for method in COMPARED:
        for load in LOADS if method in ON_CABLE else ():
            for cells in (2, 4) if options.quick else (2, 4, 8, 16):
                key = f"cable, {load}: {method.name} 1/{cells}"
                arguments = {"method": method, "load": load, "cells": cells}
                listed.append(Case(key, run_cable, arguments, cost=0.02 * cells**2))
        for cells in (2,) if options.quick else (4, 6, 8, 10):
            key = f"bending column: {method.name} 1/{cells}"
            arguments = {"method": method, "cells": cells}
            listed.append(Case(key, run_bending, arguments, cost=0.01 * cells**4))
    return listed


def run_cable(*, method: Method, load: str, cells: int) -> list[Row]:
    """Relative L2 errors over one period against d'Alembert, and of the stress at the wall.

    The bar is two cells wide on rollers, ``cells`` a metre.  ``wall`` is the relative error of the
    mean axial stress in the metre at the wall while the front is elsewhere: twice the load's.
    """
    started = time.perf_counter()
    shape, stress = LOADS[load]
    spacing = 1.0 / cells
    sim = method.simulation(cable(load=shape, stress=stress, width=2 * spacing), spacing=spacing)
    wave = sim.scene.known_solution()
    scale = stress / 2.0e11 * 10.0 * math.sqrt(sim.scene.body.volume)
    rows, wall = [], []
    for n in range(1, _INSTANTS + 1):
        last = sim.run(until=n * wave.period / _INSTANTS, record=[Errors()]).table.iloc[-1]
        shot = sim.snapshot()
        u, P = shot.field("u"), shot.field("P")
        miss = u.values - wave.displacement(u.X, shot.time)
        rows.append(
            {
                "p": float(last["p_x"]),
                "P": float(last["P_xx"]),
                "u": float(l2_norm(PointField(u.X, u.V, miss))[0]) / scale,
            }
        )
        near = P.X[:, 0] <= 1.0
        if 2.6e-3 <= shot.time <= 5.4e-3:
            wall.append(float(P.V[near] @ P.values[near, 0, 0] / P.V[near].sum()))
    doubled = abs(np.mean(wall) / (2.0 * stress) - 1.0) if load == "step" else float("nan")
    common = {"scene": "cable", "load": load, "method": method.name, "h": spacing}
    wall_s = time.perf_counter() - started
    return [
        common
        | {"field": name, "error": error, "wall_stress": doubled, "wall_s": wall_s}
        | folding.folding(sim)
        for name, error in period_errors(rows).items()
    ]


def run_bending(*, method: Method, cells: int) -> list[Row]:
    """First peak of ``u_x`` at the top's centre [m] and its time [s]; ``cells`` a metre."""
    started = time.perf_counter()
    sim = method.simulation(bending_column(), spacing=1.0 / cells)
    history = sim.run(until=0.6, every=1.0e-3, record=[Probe("top_centre")])
    u = history["top_centre_u_x [m]"]
    k = int(np.argmax(u))
    return [
        {
            "scene": "bending column", "method": method.name, "h": 1.0 / cells, "peak": float(u[k]),
            "time": float(history["time [s]"][k]), "wall_s": time.perf_counter() - started,
            **folding.folding(sim),
        }
    ]  # fmt: skip


def tables(rows: list[Row]) -> Tables:
    """``table``: orders of the cable; ``cable``: every error; ``bending``: every peak."""
    of_cable = ["load", "method", "field", "h", "error", "wall_stress", "wall_s", *folding.COLUMNS]
    bars = pd.DataFrame([row for row in rows if row["scene"] == "cable"], columns=of_cable)
    columns = ["method", "h", "peak", "time", "wall_s", *folding.COLUMNS]
    bending = pd.DataFrame([row for row in rows if row["scene"] != "cable"], columns=columns)
    bending["off"] = bending["peak"] / PEAK - 1.0
    orders = order_table(
        bars.drop(columns=["wall_stress", *folding.COLUMNS]), by=["load", "method", "field"]
    )
    return {"table": orders, "cable": bars, "bending": bending}


def claims(tables: Tables) -> list[Claim]:
    """What was asked of the answers; a run that folded has not given one."""
    found = []
    orders, bars = tables["table"], tables["cable"]
    for (load, method), part in orders.groupby(["load", "method"], sort=False):
        last = part.set_index("field")["order_last"]
        runs = bars[(bars["load"] == load) & (bars["method"] == method)]
        sound = not bool(folding.has_folded(runs).any())
        judged = last.min() if load == "pulse" else last["u"]
        what = "worst of p, P, u" if load == "pulse" else "displacement"
        found.append(
            Claim(
                f"cable, {load}: order of {what}", float(judged), ">=", ORDERS[str(load)],
                where=str(method), sound=sound, format=".2f",
            )
        )  # fmt: skip
        if load == "step":
            worst = float(last[["p", "P"]].min())
            what = "cable, step: order of p and P"
            found.append(Claim(what, worst, where=str(method), format=".2f"))
    for method, part in tables["bending"].groupby("method", sort=False):
        finest = part.sort_values("h").iloc[0]
        found.append(
            Claim(
                "bending column: peak off by", abs(float(finest["off"])), "<=", TOLERANCE,
                where=str(method), sound=not bool(finest["folded"]),
            )
        )  # fmt: skip
    return found


def cable_figure(results: Results) -> Figure:
    """Errors over spacing after a pulse and after a step."""
    figure, axes = panels(1, 2, width=3.4)
    bars = results.tables["cable"]
    look = {method.name: method.look for method in ON_CABLE}
    for ax, load in zip(axes.flat, LOADS, strict=True):
        curves = [
            Curve(
                f"{method}, {field}", runs["h"], runs["error"],
                look[str(method)] | {"linestyle": {"p": "-", "P": "--", "u": ":"}[str(field)]},
            )
            for (method, field), runs in bars[bars["load"] == load].groupby(["method", "field"])
        ]  # fmt: skip
        convergence_panel(ax, curves, title=f"cable, {load}")
    outside_legend(figure, axes.flat)
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """Materials and settings, and how far {p,F,J} is from {p,F}."""
    bar, bending = cable(), tables["bending"]
    peaks = bending.pivot_table(index="h", columns="method", values="peak")
    without, with_J = (method.name for method in COMPARED[:2])
    solid = bar.material
    return {
        "E": 9.0 * solid.kappa * solid.mu / (3.0 * solid.kappa + solid.mu) / 1.0e9,
        "rho": solid.density,
        "peak": PEAK,
        "peak_time": PEAK_TIME,
        "apart": (peaks[with_J] / peaks[without] - 1.0).abs().max(),
        "wall": tables["cable"].query("load == 'step' and field == 'P'"),
        "integrator": default_integrator().name,
        "cfl": default_cfl(default_integrator()),
    }


STUDY = Study(
    name="known_answers",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"cable": cable_figure},
    words=words,
    text=Path(__file__).with_suffix(".md"),
    description="The cable against d'Alembert, the bending column against a known peak.",
)

if __name__ == "__main__":
    run_study(STUDY)
