"""What was asked of the plate, and whether it is met."""

from __future__ import annotations

import math

import pandas as pd

from studies.harness.results import Tables
from studies.plate_with_hole.cases import FEM

#: Allowed distance from B-bar.
TOLERANCE = 0.03
_ASKED = {
    "against_fit": "edge, both by the same fit",
    "against_particles": "edge, particles against the elements' fit",
    "against_highest": "highest of all particles on the hole",
    "against_ring": "middles of the cells at the hole, largest",
}


def verdicts(tables: Tables) -> pd.DataFrame:
    """One row per run and way of comparing; what was not compared has no row.

    Nothing is met by a run whose positions folded.
    """
    rows = []
    for run in tables["table"].to_dict("records"):
        if run["method"] == FEM:
            continue
        for column, what in _ASKED.items():
            off = float(run[column])
            if math.isfinite(off):
                rows.append(
                    {
                        "operator": run["operator"], "mesh": run["mesh"],
                        "thickness": run["thickness"], "compared": what, "off": off,
                        "asked": TOLERANCE, "folded": run["folded"],
                        "met": "met" if abs(off) <= TOLERANCE and not run["folded"] else "not met",
                    }
                )  # fmt: skip
    columns = ["operator", "mesh", "thickness", "compared", "off", "asked", "folded", "met"]
    return pd.DataFrame(rows, columns=columns)
