"""A study that costs nothing, to try the engine on; workers import its cases from here."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from sphsolid.errors import Diverged
from studies.engine.plotting import Curve, convergence_panel, outside_legend, panels
from studies.engine.study import Case, Claim, Study
from studies.measures.order import order_table

TEXT = """# A study of powers

What it is about.

## Orders

The exponent is {{ tables.orders.order_last[0] | number(".3f") }}.

{{ figure("convergence", "Errors.") }}

{{ table(tables.orders, "Fits.", {"method": "law", "order_last": "order"}) }}
"""


@dataclass(frozen=True)
class Law:
    """An option object: errors are ``h^order``."""

    order: float

    @property
    def name(self):
        return f"order {self.order:g}"


def power_law(*, h, law, log=""):
    """Two rows; ``log`` counts how often this really ran."""
    if log:
        with Path(log).open("a") as file:
            file.write(f"{h}\n")
    return [
        {"method": law.name, "component": component, "h": h, "error": factor * h**law.order}
        for component, factor in (("p_x", 1.0), ("P_xx", 3.0))
    ]


def diverges(*, h):
    raise Diverged("J = -0.1", 0.25, 12, 3, (0.0, h, 1.0), "a smaller CFL")


def breaks():
    return [{"error": 1.0 / 0.0}]


def forgets_the_list():
    return {"error": 1.0}


def dies():
    os._exit(9)


def sleeps(*, seconds):
    row = {"method": "m", "component": "p_x", "h": seconds, "error": 1.0, "process": os.getpid()}
    row |= {"threads": os.environ.get("NUMBA_NUM_THREADS"), "began": time.monotonic()}
    time.sleep(seconds)
    return [row | {"ended": time.monotonic()}]


def power(h, *, log="", cost=1.0, order=2.0):
    return Case(f"h = {h:g}", power_law, {"h": h, "law": Law(order), "log": str(log)}, cost)


def tables(rows):
    table = pd.DataFrame(rows, columns=["method", "component", "h", "error"])
    return {"table": table, "orders": order_table(table)}


def claims(tables):
    return [
        Claim(f"order of {row.component}", row.order_last, ">=", 1.9, where=row.method)
        for row in tables["orders"].itertuples()
    ]


def convergence(results):
    figure, axes = panels(1, 2)
    for ax, (component, part) in zip(
        axes.flat, results.tables["table"].groupby("component"), strict=True
    ):
        curves = [Curve(str(m), g["h"], g["error"]) for m, g in part.groupby("method")]
        convergence_panel(ax, curves, title=str(component))
    outside_legend(figure, axes.flat)
    return figure


def nothing(options):
    return []


def study_of(cases, folder, *, text=TEXT, warm_up=nothing):
    """The study of ``cases`` with its text in ``folder``, without a warm-up unless asked for."""
    path = folder / "fake.md"
    path.write_text(text)

    def listed(options):
        return cases

    return Study(
        name="fake", cases=listed, tables=tables, claims=claims, text=path,
        figures={"convergence": convergence}, shown=("convergence",), warm_up=warm_up,
    )  # fmt: skip
