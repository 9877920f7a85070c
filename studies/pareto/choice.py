"""Which formulation and stabilisation to use: the cheapest that is about as accurate as the best.

Rows of the family ``supg`` are such choices among the SUPG methods.  Those of the family
``restraint`` choose nothing: they say what the package default, which holds its shape where SUPG
methods fold (``studies.stability``), is beside all of them.

Methods are compared at equal particles, on the finest lattice that all of them were run on.  One
whose error is within :data:`WITHIN` of the best *in every measure* may be chosen; of these the
cheapest in CPU seconds per physical second is, and where costs are within :data:`SAME_COST` the
one that holds fewer bytes.  Differences below the uncertainty of the reference do not count: it is
added to all errors.  A method that diverged, folded or made energy is no choice.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.measures.folding import sound
from studies.methods import PACKAGE, Method
from studies.pareto.methods import CANDIDATES
from studies.pareto.problems import COLUMN, CUBE, FAIR

WITHIN = 0.10
#: Timings of a shared machine tell no less apart.
SAME_COST = 0.15
#: Share of its energy that a method may make.
ENERGY_MADE = 0.01
#: What is compared in each scene: one measure a field, none twice.
JUDGED = {
    CUBE: ("momentum", "stress"), FAIR: ("momentum", "stress"), COLUMN: ("twist_rms",),
}  # fmt: skip
#: The scenes of a family, and who is compared there.  A start at full displacement is not fair to a
#: method without damping.
FAMILIES: dict[str, tuple[tuple[str, ...], tuple[Method, ...]]] = {
    "supg": ((CUBE, COLUMN), CANDIDATES), "restraint": ((FAIR, COLUMN), (PACKAGE, *CANDIDATES)),
}  # fmt: skip
NAMES = ["method", "formulation", "stabilisation"]
CHOICES = ["scene", "nu", *NAMES, "error_ratio", "cpu_s_per_s", "bytes", "particles", "compared"]
COLUMNS = [
    "family", "scene", "nu", "formulation", "stabilisation", "error_ratio", "cpu_ratio",
    "bytes_ratio", "particles", "compared",
]  # fmt: skip


def error_ratios(table: pd.DataFrame, family: str) -> pd.DataFrame:
    """One row per scene, nu and candidate: its worst error over the best, and its costs.

    ``error_ratio`` is ``inf`` for a method that is no choice; costs are those of a run.
    """
    found = []
    scenes, candidates = FAMILIES[family]
    names = [method.name for method in candidates]
    shown = table[table["method"].isin(names) & table["scene"].isin(scenes)]
    shown = shown[shown["cpu_s_per_s"].notna()]
    for (scene, _), part in shown.groupby(["scene", "nu"], sort=False):
        counts = part.groupby("particles")["method"].nunique()
        runs = part[part["particles"] == counts[counts == counts.max()].index.max()]
        worst = pd.Series(1.0, runs.index)
        for measure in JUDGED[str(scene)]:
            unsure = runs.get(f"{measure}_uncertainty", pd.Series(0.0, runs.index)).fillna(0.0)
            size = runs[measure] + unsure
            worst = pd.Series(np.maximum(worst, size / size.min()), runs.index)
        usable = sound(runs) & ~(runs["energy_kept"] > 1.0 + ENERGY_MADE) & np.isfinite(worst)
        compared = ", ".join(JUDGED[str(scene)])
        found.append(runs.assign(error_ratio=worst.where(usable, np.inf), compared=compared))
    return pd.concat(found)[CHOICES] if found else pd.DataFrame(columns=CHOICES)


def over_all_scenes(by_scene: pd.DataFrame) -> pd.DataFrame:
    """One row per nu and candidate over both scenes: worst ratio, geometric mean of the costs.

    Costs of a scene count relative to its cheapest candidate, so that no scene outweighs another.
    """
    costs = ["cpu_s_per_s", "bytes"]
    cheapest = by_scene.groupby(["scene", "nu"])[costs].transform("min")
    relative = by_scene.assign(
        **{cost: np.log((by_scene[cost] / cheapest[cost]).astype(float)) for cost in costs},
        compared=by_scene["scene"] + ": " + by_scene["compared"],
        scenes=by_scene.groupby(["nu", "method"])["scene"].transform("nunique"),
    )
    everywhere = relative["scenes"] == relative.groupby("nu")["scene"].transform("nunique")
    together = relative[everywhere].groupby(["nu", *NAMES], sort=False, as_index=False)
    made = together.agg(
        error_ratio=("error_ratio", "max"), cpu_s_per_s=("cpu_s_per_s", "mean"),
        bytes=("bytes", "mean"), particles=("particles", "max"), compared=("compared", "; ".join),
    )  # fmt: skip
    return made.assign(scene="all", **{cost: np.exp(made[cost].astype(float)) for cost in costs})


def chosen(candidates: pd.DataFrame) -> pd.Series | None:
    """The row to recommend among candidates of one scene and nu; None if all are unsound.

    Where none is within :data:`WITHIN` of the best in all measures, the smallest worst ratio.
    """
    usable = candidates[np.isfinite(candidates["error_ratio"])]
    if len(usable) == 0:
        return None
    near = usable[usable["error_ratio"] <= max(1.0 + WITHIN, usable["error_ratio"].min())]
    cheap = near[near["cpu_s_per_s"] <= (1.0 + SAME_COST) * near["cpu_s_per_s"].min()]
    return cheap.loc[cheap["bytes"].idxmin()]


def recommendation(table: pd.DataFrame) -> pd.DataFrame:
    """One row per family, scene and nu, and one per family and nu over all of its scenes.

    ``error_ratio``: worst error over the best candidate's; ``cpu_ratio`` and ``bytes_ratio``: cost
    over that of the most accurate candidate.
    """
    rows = []
    for family in FAMILIES:
        by_scene = error_ratios(table, family)
        both = pd.concat([by_scene, over_all_scenes(by_scene)], ignore_index=True)
        for _, candidates in both.groupby(["scene", "nu"], sort=False):
            sure = candidates[candidates["method"] == PACKAGE.name]
            taken = chosen(candidates if family == "supg" else sure)
            if taken is not None:
                best = candidates.loc[candidates["error_ratio"].idxmin()]
                ratios = {
                    "cpu_ratio": taken["cpu_s_per_s"] / best["cpu_s_per_s"],
                    "bytes_ratio": taken["bytes"] / best["bytes"],
                }
                rows.append({"family": family} | dict(taken) | ratios)
    return pd.DataFrame(rows, columns=COLUMNS)
