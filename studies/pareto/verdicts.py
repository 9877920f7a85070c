"""SPH against FEM at equal error, computed from the iso-error table: whichever way it falls."""

from __future__ import annotations

from typing import Any

import pandas as pd

from studies.pareto.iso_error import COARSEST, FAMILY, NEVER
from studies.pareto.methods import FEM

#: Costs within this share of each other are called equal.
EQUAL = 0.1
#: Where the reference is less certain than this share of the error asked for nothing is compared.
CERTAIN = 0.5
COLUMNS = [
    *FAMILY, "sph", "sph_cpu_s_per_s", "fem", "fem_cpu_s_per_s", "bound", "cpu_ratio",
    "bytes_ratio", "particles_ratio", "outcome",
]  # fmt: skip
#: What a comparison can end with.
CHEAPER, DEARER, SAME, OPEN, ONLY_SPH, ONLY_FEM, NEITHER, UNSURE = OUTCOMES = (
    "SPH cheaper", "SPH dearer", "equal", "open: coarsest lattices are enough", "only SPH",
    "only FEM", "neither", "reference too uncertain",
)  # fmt: skip
DECIDED = (CHEAPER, DEARER, SAME)
_RATIOS = {"cpu_ratio": "cpu_s_per_s", "bytes_ratio": "bytes", "particles_ratio": "particles"}


def ratios(iso: pd.DataFrame) -> pd.DataFrame:
    """The cheapest SPH and the cheapest FEM that reach each error, SPH's cost over FEM's, outcome.

    A method whose coarsest lattice is enough may cost less than that lattice does, so its cost is
    an upper bound: then the ratio is ``at most`` or ``at least`` what it says.
    """
    rows = []
    for key, group in iso.groupby(FAMILY, sort=False):
        row: dict[str, Any] = dict(zip(FAMILY, key, strict=True)) | {"bound": ""}
        reached = group[group["how"] != NEVER].sort_values("cpu_s_per_s")
        sides = {
            "sph": reached[reached["family"] != FEM], "fem": reached[reached["family"] == FEM]
        }  # fmt: skip
        best = {name: part.iloc[0] for name, part in sides.items() if len(part)}
        for name, one in best.items():
            row |= {name: one["method"], f"{name}_cpu_s_per_s": one["cpu_s_per_s"]}
        if len(best) == 2:
            row |= {ratio: best["sph"][c] / best["fem"][c] for ratio, c in _RATIOS.items()}
            row["bound"] = {
                (False, False): "", (True, False): "at most", (False, True): "at least",
                (True, True): "both bounds",
            }[best["sph"]["how"] == COARSEST, best["fem"]["how"] == COARSEST]  # fmt: skip
        unsure = group["reference_share"].max() > CERTAIN
        row["outcome"] = UNSURE if unsure else _outcome(row, set(best))
        rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


def _outcome(row: dict[str, Any], reached: set[str]) -> str:
    if len(reached) < 2:
        return ONLY_SPH if "sph" in reached else ONLY_FEM if "fem" in reached else NEITHER
    ratio, bound = row["cpu_ratio"], row["bound"]
    if bound in ("", "at most") and ratio < 1.0 / (1.0 + EQUAL):
        return CHEAPER
    if bound in ("", "at least") and ratio > 1.0 + EQUAL:
        return DEARER
    return OPEN if bound else SAME


def sentence(compared: pd.DataFrame) -> str:
    """One sentence on SPH against FEM from the table of :func:`ratios`."""
    decided = compared[compared["outcome"].isin(DECIDED)]
    counts = {outcome: int((compared["outcome"] == outcome).sum()) for outcome in OUTCOMES}
    alone = _alone(counts)
    if len(decided) == 0:
        return f"No error is reached by both SPH and FEM so that costs can be compared{alone}."
    ratio, all_of = decided["cpu_ratio"], f"{len(decided)} of {len(compared)}"
    span = f"{ratio.min():.2g} to {ratio.max():.2g} (median {ratio.median():.2g})"
    if counts[DEARER] == len(decided):
        return (
            f"At equal error SPH costs {span} times the CPU time of FEM, more in all {all_of} "
            f"comparisons that can be made{alone}: on these scenes FEM is the cheaper method."
        )
    if counts[CHEAPER] == len(decided):
        return (
            f"At equal error SPH costs {span} times the CPU time of FEM, less in all {all_of} "
            f"comparisons that can be made{alone}: on these scenes SPH is the cheaper method."
        )
    return (
        f"At equal error SPH is cheaper than FEM in {counts[CHEAPER]}, dearer in {counts[DEARER]} "
        f"and within {EQUAL:.0%} in {counts[SAME]} of the {all_of} comparisons that can be made: "
        f"its CPU time is {span} times that of FEM{alone}."
    )


def _alone(counts: dict[str, int]) -> str:
    said = [
        f"{counts[outcome]} error{'s' if counts[outcome] > 1 else ''} only {name} reaches"
        for name, outcome in (("SPH", ONLY_SPH), ("FEM", ONLY_FEM))
        if counts[outcome]
    ]
    return f" ({', '.join(said)})" if said else ""


def sentence_by_scene(compared: pd.DataFrame) -> pd.DataFrame:
    """The sentence for every scene and nu."""
    rows = [
        {"scene": scene, "nu": nu, "verdict": sentence(part)}
        for (scene, nu), part in compared.groupby(["scene", "nu"], sort=False)
    ]
    return pd.DataFrame(rows, columns=["scene", "nu", "verdict"])
