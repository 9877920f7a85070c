"""Which consistent operator?  One choice changed at a time: ``python -m studies.operators``.

Every variant gives the orders and errors of {p,F} on the swinging cube (linear limit, both
families).  An accurate operator that makes energy is of no use, so it also gives twist, energy and
pressure range of {p,F,J} on the twisting column.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

import sphsolid as sph
from sphsolid.record import Snapshot
from sphsolid.scenes import Scene, twisting_column
from studies.engine.study import Case, Row, Study, Tables, run_study
from studies.measures.indicators import pressure_range, twist_of_top, whole_turns
from studies.measures.order import order_table
from studies.measures.run import run
from studies.measures.swinging_cube import FAMILIES, cube_scene, period_errors_of
from studies.measures.tables import select
from studies.methods import PAPER, Method

BASE = PAPER.but(
    name="paper", formulation=sph.PF(), operator=sph.Consistent(), initial_strain=sph.Compatible()
)
#: The base with the changes that a name says.
_CHANGES: dict[str, Mapping[str, Any]] = {
    "as printed": {"operator": sph.Literal()},
    "as printed, linear-kernel gradient": {"operator": sph.Literal(gradient="linear_kernel")},
    "as printed, support 1.4 dx": {"operator": sph.Literal(), "h_over_dx": 0.7},
    "weights W^0": {"operator": sph.Consistent(weight_exponent=0.0)},
    "weights W^1": {"operator": sph.Consistent(weight_exponent=1.0)},
    "weights W^2": {"operator": sph.Consistent(weight_exponent=2.0)},
    "cubic spline": {"smoothing": sph.CubicSpline()},
    "cubic spline, W^0": {
        "smoothing": sph.CubicSpline(), "operator": sph.Consistent(weight_exponent=0.0),
    },
    "cubic spline, W^1": {
        "smoothing": sph.CubicSpline(), "operator": sph.Consistent(weight_exponent=1.0),
    },
    "quintic spline": {"smoothing": sph.QuinticSpline(), "h_over_dx": 0.51},
    "support 1.44 dx": {"h_over_dx": 0.72},
    "support 1.5 dx": {"h_over_dx": 0.75},
    "support 1.8 dx": {"h_over_dx": 0.9},
    "support 2 dx": {"h_over_dx": 1.0},
    "linear-kernel gradient": {"operator": sph.Consistent(gradient="linear_kernel")},
    "band of 4 layers": {"operator": sph.Consistent(layers=4)},
    "xi_F = 0.05": {"xi_F": 0.05},
    "xi_F = 0.1": {"xi_F": 0.1},
    "given initial strain": {"initial_strain": sph.Given()},
    "force only, given strain": {
        "operator": sph.Consistent(use="force"), "initial_strain": sph.Given(),
    },
    "force only, compatible strain": {"operator": sph.Consistent(use="force")},
    "force only, given strain, xi_F = 0.1": {
        "operator": sph.Consistent(use="force"), "initial_strain": sph.Given(), "xi_F": 0.1,
    },
}  # fmt: skip
VARIANTS = (BASE, *(BASE.but(name=name, **changes) for name, changes in _CHANGES.items()))
SHORT_FORM = (BASE.name, "cubic spline", "force only, given strain")
#: End of the column's run and distance of the instants at which its top is looked at [s]: it turns
#: by less than half a turn between two of them, so the jump tells the turns.
END, EVERY = 0.1, 0.002
TAU_P, NU = 0.1, 0.495
#: Cells per metre of the column and its lattice: the paper's two.
LATTICES = {3: "4x19x4", 5: "6x31x6"}


@dataclass(frozen=True)
class Twist:
    """Rotation of the top [rad], within half a turn."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """One column."""
        return {"angle": twist_of_top(snapshot)}


def cube(*, method: Method, family: str, cells: int) -> list[Row]:
    """Errors in the linear limit: one row per component."""
    started = time.perf_counter()
    sim = method.simulation(cube_scene("linear", family), spacing=1.0 / cells)
    errors = period_errors_of(sim)
    wall = time.perf_counter() - started
    return [
        {"scene": "cube", "variant": method.name, "family": family, "component": name,
         "h": 1.0 / cells, "error": error, "wall_s": wall}
        for name, error in errors.items()
    ]  # fmt: skip


def column(*, method: Method, cells: int) -> list[Row]:
    """Twist, energy and pressure range of {p,F,J} on the twisting column at its end."""
    mixed = method.but(
        formulation=sph.PFJ(), tau_p=sph.OfStep(TAU_P), initial_strain=sph.Compatible()
    )
    sim = mixed.simulation(twisting_column(poisson_ratio=NU), spacing=1.0 / cells)
    start = sim.snapshot()
    ran = run(sim, until=END, every=EVERY, record=[Twist()])
    row = {"scene": "column", "variant": method.name, "cells": cells, **ran.columns()}
    if not ran.survived:
        return [row]
    twist, end = 0.0, sim.snapshot()
    for angle in ran.history["angle"]:
        twist = whole_turns(angle, twist)
    low, high = pressure_range(end)
    energy = (end.kinetic_energy + end.strain_energy) / (start.kinetic_energy + start.strain_energy)
    return [
        row | {"twist": abs(twist), "energy": energy, "pressure_1": low, "pressure_99": high}
    ]


def cases(options: argparse.Namespace) -> list[Case]:
    """Cube at 1/8, 1/16 (and 1/32), column on 4x19x4 and 6x31x6, for every variant."""
    listed = []
    for method in VARIANTS:
        if options.quick and method.name not in SHORT_FORM:
            continue
        for cells in (8, 16) if options.quick else (8, 16, 32):
            for family in FAMILIES:
                key = f"cube {family} 1/{cells}: {method.name}"
                arguments = {"method": method, "family": family, "cells": cells}
                cost = cells**4 * (0.55 if family == "A=B=C" else 1.0) / 16**4
                listed.append(Case(key, cube, arguments, cost))
        for cells in (3,) if options.quick else LATTICES:
            arguments = {"method": method, "cells": cells}
            cost = 2.0 * (cells / 3) ** 4
            listed.append(Case(f"column 1/{cells}: {method.name}", column, arguments, cost))
    return listed


def tables(rows: list[Row]) -> Tables:
    """``table``: a row per variant; ``errors``, ``orders`` and ``column``: what it is made from."""
    errors = pd.DataFrame(
        [row for row in rows if row["scene"] == "cube"],
        columns=["scene", "variant", "family", "component", "h", "error", "wall_s"],
    )
    columns = pd.DataFrame(
        [row for row in rows if row["scene"] == "column"],
        columns=["scene", "variant", "cells", "twist", "energy", "pressure_1", "pressure_99",
                 "survived", "why", "folded", "folded_at", "wall_s"],
    )  # fmt: skip
    orders = order_table(errors, by=["variant", "family", "component"])
    found = []
    for variant in dict.fromkeys(orders["variant"]):
        mine = select(orders, variant=variant)
        momentum = mine["component"].str.startswith("p_")
        at_17 = select(errors, variant=variant, h=1 / 16, family="A+B+C=0").set_index("component")
        row: Row = {
            "variant": variant,
            "slope_p": mine[momentum]["order_last"].min(),
            "slope_P": mine[~momentum]["order_last"].min(),
            "p_x_17": at_17["error"].get("p_x"),
            "P_xx_17": at_17["error"].get("P_xx"),
        }
        for cells, lattice in LATTICES.items():
            for one in select(columns, variant=variant, cells=cells).to_dict("records"):
                row |= {f"{name}_{lattice}": one[name] for name in ("twist", "energy")}
                row[f"pressure_99_{lattice}"] = one["pressure_99"]
        found.append(row)
    names = [
        "variant", "slope_p", "slope_P", "p_x_17", "P_xx_17", "twist_4x19x4", "energy_4x19x4",
        "twist_6x31x6", "energy_6x31x6", "pressure_99_6x31x6",
    ]  # fmt: skip
    table = pd.DataFrame(found, columns=names)
    return {"table": table, "errors": errors, "orders": orders, "column": columns}


def words(tables: Tables) -> Mapping[str, Any]:
    """Settings of both scenes."""
    return {"tau_p": TAU_P, "nu": NU, "end": END, "base": BASE.name}


STUDY = Study(
    name="operators",
    cases=cases,
    tables=tables,
    words=words,
    text=Path(__file__).with_suffix(".md"),
    warm_up=lambda options: [
        Case("cube", cube, {"method": BASE, "family": "A=B=C", "cells": 2}),
        Case("column", column, {"method": BASE, "cells": 1}),
    ],
    description="Variants of the consistent operator, one choice changed at a time.",
)

if __name__ == "__main__":
    run_study(STUDY)
