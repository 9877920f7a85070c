"""Which formulation and stabilisation to use: the cheapest that is about as accurate as the best.

Methods are compared at equal particles, on the finest lattice that all of them were run on.  One
whose error is within :data:`WITHIN` of the best *in every measure* may be chosen; of these the
cheapest in CPU seconds per physical second is, and where costs are within :data:`SAME_COST` the
one that holds fewer bytes.  Differences below the uncertainty of the reference do not count: it is
added to all errors.  A method that was lost, folded or made energy is no choice.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.pareto.methods import CANDIDATES
from studies.pareto.scenes import COLUMN, CUBE
from studies.report.folding import sound

WITHIN = 0.10
#: Timings of a shared machine tell no less apart.
SAME_COST = 0.15
#: Share of its energy that a method may make.
ENERGY_MADE = 0.01
#: What is compared in each scene: one measure a field, none twice.
JUDGED = {CUBE: ("momentum", "stress"), COLUMN: ("twist_rms",)}
EVERY_SCENE = "all"
COLUMNS = [
    "scene", "nu", "formulation", "stabilisation", "error_ratio", "cpu_ratio", "bytes_ratio",
    "particles", "compared",
]  # fmt: skip


def error_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scene, nu and candidate: its worst error over the best, and its costs.

    ``error_ratio`` is ``inf`` for a method that is no choice; costs are those of a run.
    """
    rows = []
    shown = table[table["method"].isin(CANDIDATES) & table["cpu_s_per_s"].notna()]
    for (scene, nu), part in shown.groupby(["scene", "nu"], sort=False):
        counts = part.groupby("particles")["method"].nunique()
        if len(counts) == 0:
            continue
        particles = counts[counts == counts.max()].index.max()
        runs = part[part["particles"] == particles]
        worst = pd.Series(1.0, runs.index)
        for measure in JUDGED[str(scene)]:
            unsure = runs.get(f"{measure}_uncertainty", pd.Series(0.0, runs.index)).fillna(0.0)
            size = runs[measure] + unsure
            worst = np.maximum(worst, size / size.min())
        usable = sound(runs) & ~(runs["energy_kept"] > 1.0 + ENERGY_MADE)
        for row, ratio, good in zip(runs.itertuples(), worst, usable, strict=True):
            rows.append(
                {
                    "scene": scene, "nu": nu, "method": row.method,
                    "formulation": row.formulation, "stabilisation": row.stabilisation,
                    "error_ratio": float(ratio) if good and np.isfinite(ratio) else np.inf,
                    "cpu_s_per_s": row.cpu_s_per_s, "bytes": row.bytes, "particles": particles,
                    "compared": ", ".join(JUDGED[str(scene)]),
                }
            )  # fmt: skip
    names = ["scene", "nu", "method", "formulation", "stabilisation", "error_ratio",
             "cpu_s_per_s", "bytes", "particles", "compared"]  # fmt: skip
    return pd.DataFrame(rows, columns=names)


def over_all_scenes(by_scene: pd.DataFrame) -> pd.DataFrame:
    """One row per nu and candidate over both scenes: worst ratio, geometric mean of the costs.

    Costs of a scene count relative to its cheapest candidate, so that no scene outweighs another.
    """
    rows = []
    for nu, part in by_scene.groupby("nu", sort=False):
        scenes = part["scene"].nunique()
        cheapest = part.groupby("scene")[["cpu_s_per_s", "bytes"]].transform("min")
        relative = part.assign(
            cpu_s_per_s=part["cpu_s_per_s"] / cheapest["cpu_s_per_s"],
            bytes=part["bytes"] / cheapest["bytes"],
        )
        for _, runs in relative.groupby("method", sort=False):
            if len(runs) < scenes:
                continue
            first = runs.iloc[0]
            rows.append(
                {
                    "scene": EVERY_SCENE, "nu": nu, "method": first["method"],
                    "formulation": first["formulation"], "stabilisation": first["stabilisation"],
                    "error_ratio": runs["error_ratio"].max(),
                    "cpu_s_per_s": float(np.exp(np.log(runs["cpu_s_per_s"]).mean())),
                    "bytes": float(np.exp(np.log(runs["bytes"]).mean())),
                    "particles": runs["particles"].max(),
                    "compared": "; ".join(f"{run.scene}: {run.compared}"
                                          for run in runs.itertuples()),
                }
            )  # fmt: skip
    return pd.DataFrame(rows, columns=by_scene.columns)


def chosen(candidates: pd.DataFrame) -> pd.Series | None:
    """The row to recommend among candidates of one scene and nu; ``None`` if all are unsound.

    Where none is within :data:`WITHIN` of the best in all measures, the smallest worst ratio.
    """
    sound = candidates[np.isfinite(candidates["error_ratio"])]
    if len(sound) == 0:
        return None
    near = sound[sound["error_ratio"] <= 1.0 + WITHIN]
    if len(near) == 0:
        near = sound[sound["error_ratio"] == sound["error_ratio"].min()]
    cheap = near[near["cpu_s_per_s"] <= (1.0 + SAME_COST) * near["cpu_s_per_s"].min()]
    return cheap.loc[cheap["bytes"].idxmin()]


def recommendation(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scene and nu, and one per nu over all scenes.

    ``error_ratio``: worst error over the best candidate's; ``cpu_ratio`` and ``bytes_ratio``: cost
    over that of the most accurate candidate.
    """
    by_scene = error_ratios(table)
    rows = []
    for frame in (by_scene, over_all_scenes(by_scene)):
        for (scene, nu), candidates in frame.groupby(["scene", "nu"], sort=False):
            taken = chosen(candidates)
            if taken is None:
                continue
            best = candidates.loc[candidates["error_ratio"].idxmin()]
            rows.append(
                {
                    "scene": scene, "nu": nu, "formulation": taken["formulation"],
                    "stabilisation": taken["stabilisation"], "error_ratio": taken["error_ratio"],
                    "cpu_ratio": taken["cpu_s_per_s"] / best["cpu_s_per_s"],
                    "bytes_ratio": taken["bytes"] / best["bytes"],
                    "particles": taken["particles"], "compared": taken["compared"],
                }
            )  # fmt: skip
    return pd.DataFrame(rows, columns=COLUMNS)
