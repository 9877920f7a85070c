"""What was asked of the cloud, and whether it is met."""

from __future__ import annotations

import math

import pandas as pd

from studies.harness.results import Tables
from studies.punch_cloud.bodies import HEXAHEDRA
from studies.punch_cloud.cases import DEFAULT, NONE
from studies.report.folding import has_folded

#: How much noisier than H1 on the same points a cloud may be.
TOLERANCE = 0.2
#: Smooth: at most this share of the noise without stabilisation.  Ours.
SMOOTH = 0.5


def verdicts(tables: Tables) -> pd.DataFrame:
    """One row per claim and lattice; what has not run has no row."""
    runs = tables["runs"]
    rows = []
    for cells, found in runs.groupby("cells", sort=False):
        h1 = _noise(found, HEXAHEDRA, DEFAULT)
        for cloud in ("points", "filled"):
            mine = found[(found["cloud"] == cloud) & (found["stabilisation"] == DEFAULT)]
            if len(mine) == 0 or math.isnan(h1):
                continue
            more = float(mine["noise"].mean()) / h1 - 1.0
            rows.append((f"{cloud}: noise above that of H1, mean", cells, more, TOLERANCE))
            if cloud == "points":
                worst = float(mine["against_H1"].max())
                rows.append((f"{cloud}: the same, worst seed", cells, worst, TOLERANCE))
            alive = float((~mine["survived"].astype(bool)).sum())
            rows.append((f"{cloud}: runs lost", cells, alive, 0.0))
            rows.append((f"{cloud}: runs folded", cells, float(has_folded(mine).sum()), 0.0))
        bare, smooth = _noise(found, "points", NONE), _noise(found, "points", DEFAULT)
        if not math.isnan(bare + smooth):
            rows.append(
                ("points: noise over that without stabilisation", cells, smooth / bare, SMOOTH)
            )
    frame = pd.DataFrame(rows, columns=["claim", "cells a metre", "measured", "at most"])
    frame["met"] = [
        "met" if measured <= limit else "not met"
        for measured, limit in zip(frame["measured"], frame["at most"], strict=True)
    ]
    return frame


def _noise(runs: pd.DataFrame, cloud: str, stabilisation: str) -> float:
    found = runs[(runs["cloud"] == cloud) & (runs["stabilisation"] == stabilisation)]
    return float(found["noise"].mean()) if len(found) else float("nan")
