"""The tables of the study, made from the rows of its cases."""

from __future__ import annotations

import math
from itertools import pairwise

import pandas as pd

from studies.clouds.cases import RECOVERED
from studies.harness.cases import Row
from studies.harness.results import Tables

SETTING = ["cloud", "operator", "formulation", "scene", "family"]
_ERROR = [
    *SETTING, "variant", "field", "component", "h", "particles", "steps", "error", "step_ms",
]  # fmt: skip
_SET_UP = [
    "particles", "secondary", "neighbours", "least_neighbours", "h_min_over_dx", "change",
    "iterations", "C0", "C1", "D0", "SBP", "volume", "setup_s",
]  # fmt: skip
_CONSERVED = [
    "shape", "cloud", "operator", "formulation", "outcome", "steps", "linear_drift",
    "angular_drift", *_SET_UP, "step_ms", "why",
]  # fmt: skip
_LEDGER = [
    "cloud", "operator", "integrator", "h", "particles", "steps", "dt", "dt_over_stable", "rest",
]  # fmt: skip
_SPECTRUM = [
    "cloud", "operator", "h", "particles", "h_min_over_dx", "decades_at_default", "strict",
    "slow", "fast", "refused",
]  # fmt: skip
_LEVEL = [
    *SETTING, "variant", "h", "particles", "p_x", "P_xx", "error_p", "error_P", "slope_p",
    "slope_P", "mean_slope_P",
]  # fmt: skip


def tables(rows: list[Row]) -> Tables:
    """``table``: an error a row; ``levels``: errors and slopes; and the other kinds of rows."""

    def of(kind: str, columns: list[str]) -> pd.DataFrame:
        return pd.DataFrame([row for row in rows if row["kind"] == kind], columns=columns)

    errors = of("error", _ERROR)
    return {
        "table": errors,
        "levels": levels(errors),
        "setup": of("set-up", ["cloud", "operator", "variant", "h", *_SET_UP]),
        "conservation": of("conservation", _CONSERVED),
        "ledger": with_slopes(of("ledger", _LEDGER)),
        "spectrum": of("spectrum", _SPECTRUM),
        "lost": of("lost", [*SETTING, "variant", "h", "steps", "why"]),
    }


def unvaried(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows without a ``variant``: an empty text is read back from CSV as nothing."""
    return frame[frame["variant"].isna() | (frame["variant"] == "")]


def recovered(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows with recovered stress and nothing else varied."""
    return frame[frame["variant"] == RECOVERED]


def levels(errors: pd.DataFrame) -> pd.DataFrame:
    """One row a level of every setting: largest errors, slopes from the level before.

    ``slope_p`` and ``slope_P``: that of the worst component; ``mean_slope_P`` that of the root
    mean square of all stress components.  ``nan`` on the first level.
    """
    rows = []
    settings = [*SETTING, "variant"]
    for key, group in errors.groupby(settings, sort=False, dropna=False):
        by_level = {
            float(h): part.set_index(part["field"] + "_" + part["component"])["error"]
            for h, part in group.groupby("h")
        }
        sizes = group.groupby("h")["particles"].first()
        spacings = sorted(by_level, reverse=True)
        slopes = {spacings[0]: (math.nan, math.nan, math.nan)}
        for coarse, fine in pairwise(spacings):
            slopes[fine] = _slopes(by_level[coarse], by_level[fine], coarse / fine)
        for h in spacings:
            error = by_level[h]
            momentum = error.index.str.startswith("p_")
            slope_p, slope_P, mean_slope_P = slopes[h]
            rows.append(
                dict(zip(settings, key, strict=True))
                | {
                    "h": h,
                    "particles": int(sizes[h]),
                    "p_x": error["p_x"],
                    "P_xx": error["P_xx"],
                    "error_p": error[momentum].max(),
                    "error_P": error[~momentum].max(),
                    "slope_p": slope_p,
                    "slope_P": slope_P,
                    "mean_slope_P": mean_slope_P,
                }
            )
    return pd.DataFrame(rows, columns=_LEVEL)


def _slopes(coarse: pd.Series, fine: pd.Series, ratio: float) -> tuple[float, float, float]:
    """Worst of momentum, worst of stress, and of the mean stress."""
    by_component = (coarse / fine).map(math.log) / math.log(ratio)
    momentum = by_component.index.str.startswith("p_")
    mean = [math.sqrt(float((part[~momentum] ** 2).mean())) for part in (coarse, fine)]
    return (
        float(by_component[momentum].min()),
        float(by_component[~momentum].min()),
        math.log(mean[0] / mean[1]) / math.log(ratio),
    )


def with_slopes(ledger: pd.DataFrame) -> pd.DataFrame:
    """The ledger with the power of ``dt`` at which the rest fell from the row before."""
    slope = []
    for (_, before), (_, row) in pairwise(
        [(0, pd.Series(dtype=object)), *ledger.iterrows()]
    ):
        same = len(before) > 0 and all(
            before[name] == row[name] for name in ("cloud", "operator", "integrator", "h")
        )
        slope.append(
            math.log(before["rest"] / row["rest"]) / math.log(before["dt"] / row["dt"])
            if same and row["rest"] > 0.0
            else math.nan
        )
    return ledger.assign(slope=slope)


def summary(tables: Tables) -> str:
    """Errors and slopes of every level of the default formulation, without the variants."""
    frame = tables["levels"]
    if len(frame) == 0:
        return "no errors were measured"
    frame = unvaried(frame).drop(columns=["variant", "mean_slope_P"])
    return frame.to_string(index=False, float_format=lambda value: f"{value:.3g}")
