"""What a given error costs: particles, CPU seconds and bytes, interpolated between lattices.

Between two lattices all quantities are straight lines in the logarithms.  A lattice counts with
the largest error of it *and of all finer ones*: an error that passes through zero on one lattice is
luck and no accuracy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from studies.measures.tables import select
from studies.methods import B_BAR
from studies.pareto.problems import MEASURES, PULSE, VIBRATION

Array = NDArray[np.float64]
#: Errors at which costs are compared.
ASKED = (0.1, 0.03, 0.01, 0.003, 0.001)
#: An error is carried on at most so far beyond the finest lattice: a refinement at order two.
FARTHEST = 4.0
BETWEEN, BEYOND, COARSEST, NEVER = (
    "interpolated", "extrapolated", "coarsest is enough", "not reached",
)  # fmt: skip
COSTS = ("particles", "cpu_s_per_s", "bytes")
GROUP = ["scene", "nu", "measure", "asked"]
ISO = [*GROUP, "method", "solver", "stabilisation", "how", *COSTS, "reference_share"]


@dataclass(frozen=True)
class Iso:
    """How an error is reached, and the costs there (nan where it is not)."""

    how: str
    costs: Mapping[str, float]


def envelope(error: Array) -> Array:
    """The largest error of each lattice and all finer ones; a run that diverged has ``inf``."""
    known = np.where(np.isfinite(error), error, np.inf)
    return np.maximum.accumulate(known[::-1])[::-1]


def iso_error(error: Sequence[float], costs: Mapping[str, Sequence[float]], asked: float) -> Iso:
    """Costs at ``asked`` of one method; lattices from coarse to fine."""
    size = envelope(np.asarray(error, dtype=float))
    if size[0] <= asked:
        return Iso(COARSEST, {name: float(values[0]) for name, values in costs.items()})
    how, last = BETWEEN, int(np.argmax(size <= asked))
    if not (size <= asked).any():
        how, last = BEYOND, len(size) - 1
        falls = len(size) > 1 and np.isfinite(size[-2]) and size[-1] < size[-2]
        if not falls or size[-1] > FARTHEST * asked:
            return Iso(NEVER, dict.fromkeys(costs, float("nan")))
    if not np.isfinite(size[last - 1]):
        # Coarser ones diverged, so there is nothing to interpolate to.
        return Iso(COARSEST, {name: float(values[last]) for name, values in costs.items()})
    share = np.log(size[last - 1] / asked) / np.log(size[last - 1] / size[last])
    between = {
        name: float(values[last - 1] * (values[last] / values[last - 1]) ** share)
        for name, values in costs.items()
    }
    return Iso(how, between)


def iso_table(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scene, nu, measure, error asked for and method with its costs.

    ``reference_share``: the reference's uncertainty over the error asked for; above a half the row
    says little.
    """
    rows = []
    for (scene, nu, method), runs in table.groupby(["scene", "nu", "method"], sort=False):
        runs = runs[runs["cpu_s_per_s"].notna()].sort_values("particles")
        if len(runs) == 0:
            continue
        costs = {name: runs[name].astype(float).tolist() for name in COSTS}
        for measure in MEASURES[str(scene)]:
            unsure = runs.get(f"{measure}_uncertainty", pd.Series(0.0, runs.index)).max()
            for asked in ASKED:
                found = iso_error(runs[measure].tolist(), costs, asked)
                rows.append(
                    {
                        "scene": scene, "nu": nu, "measure": measure, "asked": asked,
                        "method": method, "how": found.how, "reference_share": unsure / asked,
                        **runs[["solver", "stabilisation"]].iloc[0], **found.costs,
                    }
                )  # fmt: skip
    frame = pd.DataFrame(rows, columns=ISO)
    return frame.sort_values(GROUP, ascending=[True, True, True, False], kind="stable")


#: Costs within this share of each other are called equal.
EQUAL = 0.1
#: Where the reference is less certain than this share of the error asked for nothing is compared.
CERTAIN = 0.5
#: What a comparison can end with; the first three compare costs.
CHEAPER, DEARER, SAME, OPEN, ONLY_SPH, ONLY_FEM, NEITHER, UNSURE = (
    "SPH cheaper", "SPH dearer", "equal", "open: coarsest lattices are enough", "only SPH",
    "only FEM", "neither", "reference too uncertain",
)  # fmt: skip
DECIDED = (CHEAPER, DEARER, SAME)
BOUNDS = {
    (False, False): "", (True, False): "at most", (False, True): "at least",
    (True, True): "both bounds",
}  # fmt: skip
RATIOS = {"cpu_ratio": "cpu_s_per_s", "bytes_ratio": "bytes", "particles_ratio": "particles"}


def ratios(iso: pd.DataFrame) -> pd.DataFrame:
    """The cheapest SPH and the cheapest FEM that reach each error, SPH's cost over FEM's, outcome.

    A method whose coarsest lattice is enough may cost less than that lattice does, so its cost is
    an upper bound: then the ratio is ``at most`` or ``at least`` what it says.
    """
    rows = []
    for key, group in iso.groupby(GROUP, sort=False):
        row: dict[str, Any] = dict(zip(GROUP, key, strict=True)) | {"bound": ""}
        reached = group[group["how"] != NEVER].sort_values("cpu_s_per_s")
        best = {
            name: part.iloc[0]
            for name in ("SPH", "FEM") if len(part := reached[reached["solver"] == name])
        }  # fmt: skip
        for name, one in best.items():
            side = name.lower()
            row |= {side: one["method"], f"{side}_cpu_s_per_s": one["cpu_s_per_s"]}
        if len(best) == 2:
            sph, fem = best["SPH"], best["FEM"]
            row |= {ratio: sph[cost] / fem[cost] for ratio, cost in RATIOS.items()}
            row["bound"] = BOUNDS[sph["how"] == COARSEST, fem["how"] == COARSEST]
        unsure = group["reference_share"].max() > CERTAIN
        row["outcome"] = UNSURE if unsure else _outcome(row, set(best))
        rows.append(row)
    columns = [*GROUP, "sph", "sph_cpu_s_per_s", "fem", "fem_cpu_s_per_s", "bound", *RATIOS]
    return pd.DataFrame(rows, columns=[*columns, "outcome"])


def _outcome(row: Mapping[str, Any], reached: set[str]) -> str:
    if len(reached) < 2:
        return ONLY_SPH if "SPH" in reached else ONLY_FEM if "FEM" in reached else NEITHER
    ratio, bound = row["cpu_ratio"], row["bound"]
    if bound in ("", "at most") and ratio < 1.0 / (1.0 + EQUAL):
        return CHEAPER
    if bound in ("", "at least") and ratio > 1.0 + EQUAL:
        return DEARER
    return OPEN if bound else SAME


def counts(compared: pd.DataFrame) -> dict[str, Any]:
    """How often each outcome came, and the range of the decided CPU ratios, for the words."""
    outcome = compared["outcome"]
    ratio = compared.loc[outcome.isin(DECIDED), "cpu_ratio"]
    return {
        "all": len(compared), "decided": len(ratio), "low": ratio.min(), "high": ratio.max(),
        "median": ratio.median(), "cheaper": int((outcome == CHEAPER).sum()),
        "dearer": int((outcome == DEARER).sum()), "same": int((outcome == SAME).sum()),
        "only_sph": int((outcome == ONLY_SPH).sum()), "only_fem": int((outcome == ONLY_FEM).sum()),
    }  # fmt: skip


def by_method(iso: pd.DataFrame) -> pd.DataFrame:
    """:func:`ratios` of each particle method alone over the cheapest FEM, where both were run."""
    particles, elements = (iso[iso["solver"] == solver] for solver in ("SPH", "FEM"))
    found = []
    for method, own in particles.groupby("method", sort=False):
        beside = elements.merge(own[GROUP], on=GROUP)
        found.append(ratios(pd.concat([own, beside])).assign(method=method))
    columns = ["method", *ratios(iso.iloc[:0]).columns.drop("sph")]
    return pd.concat(found)[columns] if found else pd.DataFrame(columns=columns)


def medians(compared: pd.DataFrame, by: Sequence[str] = ("method",)) -> pd.DataFrame:
    """:func:`counts` of each method of :func:`by_method`."""
    rows = [
        dict(zip(by, key, strict=True)) | counts(part)
        for key, part in compared.groupby(list(by), sort=False)
    ]
    return pd.DataFrame(rows, columns=[*by, *counts(compared)])


# --- what is wrong at equal cost ------------------------------------------------------------------

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
