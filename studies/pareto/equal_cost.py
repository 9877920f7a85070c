"""What is wrong at equal cost: every method's errors at what B-bar elements cost."""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.measures.tables import select
from studies.methods import B_BAR
from studies.pareto.problems import PULSE, VIBRATION

#: Measures of small motions; damping has no error that elements could be asked for.
SHOWN = {VIBRATION: ("frequency", "damping"), PULSE: ("pulse",)}
COLUMNS = ["scene", "nu", "measure", "cells", "cpu_s_per_s", "method", "error"]
#: Sizes below are round-off.
_LEAST = 1.0e-12


def equal_cost(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scene, nu, measure, lattice of B-bar elements and method.

    ``error`` lies on straight lines in the logarithms between lattices; nan where a method is
    dearer on its coarsest lattice, or cheaper on its finest.
    """
    rows = []
    for (scene, nu), runs in table[table["scene"].isin(SHOWN)].groupby(["scene", "nu"], sort=False):
        for base in select(runs, method=B_BAR.name).sort_values("cells").itertuples():
            for method, own in runs.groupby("method", sort=False):
                cost = own.sort_values("cpu_s_per_s")
                for measure in SHOWN[str(scene)]:
                    size = np.maximum(cost[measure].astype(float).abs(), _LEAST)
                    at = np.interp(
                        np.log(base.cpu_s_per_s), np.log(cost["cpu_s_per_s"].astype(float)),
                        np.log(size), left=np.nan, right=np.nan,
                    )  # fmt: skip
                    rows.append(
                        (scene, nu, measure, base.cells, base.cpu_s_per_s, method, np.exp(at))
                    )
    return pd.DataFrame(rows, columns=COLUMNS)
