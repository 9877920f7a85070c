"""What a given error costs: particles, CPU seconds and bytes, interpolated between lattices.

Between two lattices all quantities are straight lines in the logarithms.  A lattice counts with
the largest error of it *and of all finer ones*: an error that passes through zero on one lattice is
luck and no accuracy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from studies.pareto.scenes import MEASURES

Array = NDArray[np.float64]
#: Errors at which costs are compared.
ASKED = (0.1, 0.03, 0.01)
#: An error is carried on at most so far beyond the finest lattice: a refinement at order two.
FARTHEST = 4.0
BETWEEN, BEYOND, COARSEST, NEVER = (
    "interpolated", "extrapolated", "coarsest is enough", "not reached",
)  # fmt: skip
#: Costs that are interpolated.
COSTS = ("particles", "cpu_s_per_s", "bytes")
FAMILY = ["scene", "nu", "measure", "asked"]


@dataclass(frozen=True)
class Iso:
    """How an error is reached, and the costs there (``nan`` where it is not)."""

    how: str
    costs: Mapping[str, float]


def envelope(error: Array) -> Array:
    """The largest error of each lattice and all finer ones; a lost run has ``inf``."""
    known = np.where(np.isfinite(error), error, np.inf)
    return np.maximum.accumulate(known[::-1])[::-1]


def iso_error(error: Sequence[float], costs: Mapping[str, Sequence[float]], asked: float) -> Iso:
    """Costs at ``asked`` of one method; lattices from coarse to fine."""
    size = envelope(np.asarray(error, dtype=float))
    tables = {name: np.asarray(values, dtype=float) for name, values in costs.items()}
    if size[0] <= asked:
        return Iso(COARSEST, {name: float(values[0]) for name, values in tables.items()})
    how, last = BETWEEN, int(np.argmax(size <= asked)) if (size <= asked).any() else len(size)
    if last == len(size):
        how, last = BEYOND, len(size) - 1
        falls = len(size) > 1 and np.isfinite(size[-2]) and size[-1] < size[-2]
        if not falls or size[-1] > FARTHEST * asked:
            return Iso(NEVER, dict.fromkeys(tables, float("nan")))
    if not np.isfinite(size[last - 1]):
        # Coarser ones are lost, so there is nothing to interpolate to.
        return Iso(COARSEST, {name: float(values[last]) for name, values in tables.items()})
    share = np.log(size[last - 1] / asked) / np.log(size[last - 1] / size[last])
    return Iso(
        how,
        {
            name: float(values[last - 1] * (values[last] / values[last - 1]) ** share)
            for name, values in tables.items()
        },
    )


def iso_table(table: pd.DataFrame, asked: Sequence[float] = ASKED) -> pd.DataFrame:
    """One row per scene, nu, measure, error asked for and method with its costs.

    ``reference_share``: the reference's uncertainty over the error asked for; above a half the row
    says little.
    """
    rows = []
    for (scene, nu, method), runs in table.groupby(["scene", "nu", "method"], sort=False):
        runs = runs[runs["cpu_s_per_s"].notna()].sort_values("particles")
        if len(runs) == 0:
            continue
        costs = {name: runs[name].tolist() for name in COSTS}
        for measure in MEASURES[str(scene)]:
            unsure = runs.get(f"{measure}_uncertainty", pd.Series(0.0, runs.index)).max()
            for level in asked:
                found = iso_error(runs[measure].tolist(), costs, level)
                rows.append(
                    {
                        "scene": scene, "nu": nu, "measure": measure, "asked": level,
                        "method": method, "family": runs["family"].iloc[0], "how": found.how,
                        **found.costs, "reference_share": unsure / level,
                    }
                )  # fmt: skip
    columns = [*FAMILY, "method", "family", "how", *COSTS, "reference_share"]
    frame = pd.DataFrame(rows, columns=columns)
    return frame.sort_values(FAMILY, ascending=[True, True, True, False], kind="stable")
