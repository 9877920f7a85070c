"""A study of your own: four methods on the swinging cube, ``python own_study.py --quick``.

Its words are in ``own_study.md`` beside it.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

import fem_reference as fem
from sphsolid.errors import InputError
from sphsolid.record import Errors
from sphsolid.scenes import Scene, swinging_cube
from studies.engine.plotting import BLACK, Curve, convergence_panel, outside_legend, panels
from studies.engine.study import Case, Claim, Results, Row, Study, Tables, run_study
from studies.measures.order import order_table
from studies.measures.run import run
from studies.methods import PACKAGE, SUPG, Method, Times

#: Order that is asked of the momentum.
ASKED = 1.5


@dataclass(frozen=True)
class TwiceAsFine:
    """A recipe of your own: B-bar elements of half the spacing that is asked for."""

    def build(self, scene: Scene, spacing: float) -> fem.Simulation:
        """The solver; anything with the methods of ``sphsolid.record.Solver`` will do."""
        return fem.Simulation(scene, spacing=0.5 * spacing, element=fem.BBarHex())

    def but(self, changes: Mapping[str, Any]) -> TwiceAsFine:
        """It has no options."""
        raise InputError(f"B-bar, h/2 has no options, got {', '.join(changes)}")


METHODS = (
    PACKAGE,
    SUPG,
    SUPG.but(tau_F=Times(2.0), line="--"),
    Method("B-bar, h/2", "B-bar FEM on half the spacing", BLACK, "d", TwiceAsFine()),
)


def cases(options: Namespace) -> list[Case]:
    """Every method on every lattice; ``cost`` is a guess of the time of each."""
    return [
        Case(f"{method.name} 1/{cells}", errors, {"method": method, "cells": cells}, cells**4)
        for method in METHODS
        for cells in ((2, 4) if options.quick else (4, 8, 16))
    ]


def errors(*, method: Method, cells: int) -> list[Row]:
    """Relative L2 error of the momentum after a quarter and a half of a period, the larger."""
    sim = method.simulation(swinging_cube(), spacing=1.0 / cells)
    period = sim.scene.known_solution().period
    ran = run(sim, until=0.5 * period, every=0.25 * period, record=[Errors()])
    error = float(ran.history["p_x"].max())
    return [{"method": method.name, "h": 1.0 / cells, "error": error} | ran.columns()]


def tables(rows: list[Row]) -> Tables:
    """``table``: every run; ``orders``: one row a method."""
    table = pd.DataFrame(rows, columns=["method", "h", "error", "survived", "folded", "cpu_s"])
    return {"table": table, "orders": order_table(table[["method", "h", "error"]], by=["method"])}


def claims(tables: Tables) -> list[Claim]:
    """The order between the two finest lattices of each method."""
    return [
        Claim("order of the momentum", row.order_last, ">=", ASKED, where=row.method, format=".2f")
        for row in tables["orders"].itertuples()
    ]


def convergence(results: Results) -> Figure:
    """Errors over spacing."""
    figure, axes = panels(1, 1, width=4.5)
    table = results.tables["table"].groupby("method")
    runs = {method: table.get_group(method.name) for method in METHODS}
    curves = [Curve(m.name, part["h"], part["error"], m.look) for m, part in runs.items()]
    convergence_panel(axes[0, 0], curves, title="momentum")
    outside_legend(figure, axes.flat)
    return figure


def words(tables: Tables) -> Mapping[str, Any]:
    """What the text says beside the tables."""
    return {"asked": ASKED, "best": tables["orders"].sort_values("error_finest").iloc[0]}


STUDY = Study(
    name="own_study",
    cases=cases,
    tables=tables,
    claims=claims,
    figures={"convergence": convergence},
    words=words,
    text=Path(__file__).with_suffix(".md"),
)

if __name__ == "__main__":
    run_study(STUDY)
