"""Tables of the report: what is compared, a column a method."""

from __future__ import annotations

import pandas as pd

from studies.pareto.iso_error import DECIDED, NEITHER, OPEN, UNSURE, medians
from studies.pareto.methods import front
from studies.pareto.problems import CUBE, PROBLEMS


def decided_rows(compared: pd.DataFrame) -> pd.DataFrame:
    """Comparisons that came to something."""
    shown = compared[~compared["outcome"].isin((NEITHER, OPEN, UNSURE))]
    return shown.assign(scene=shown["scene"].map(_title))


def of_each(by_name: pd.DataFrame) -> pd.DataFrame:
    """Methods of which a cost can be compared, from the lowest median to the highest."""
    return by_name[by_name["decided"] > 0].sort_values("median", kind="stable")


def by_error(alone: pd.DataFrame) -> pd.DataFrame:
    """A row per scene, nu, measure and error, a column per method of the front: CPU over FEM's."""
    shown = _of_front(alone[alone["outcome"].isin((*DECIDED, OPEN))])
    sign = {"at most": "≤ ", "at least": "≥ ", "both bounds": "? "}
    said = [
        f"{sign.get(bound, '')}{ratio:.2g}"
        for bound, ratio in zip(shown["bound"], shown["cpu_ratio"], strict=True)
    ]
    wide = _wide(shown.assign(value=said), ["scene", "nu", "measure", "asked"])
    return wide.rename(columns={"measure": "of", "asked": "error"})


def by_scene(alone: pd.DataFrame) -> pd.DataFrame:
    """A row per scene and nu, a column per method of the front: the median of its CPU ratios."""
    found = _of_front(medians(alone, by=("scene", "nu", "method")))
    known = found[found["decided"] > 0]
    return _wide(known.assign(value=known["median"]), ["scene", "nu"])


def at_cost(errors: pd.DataFrame) -> pd.DataFrame:
    """A row per scene, nu, measure and lattice of B-bar elements, a column per method."""
    shown = errors.assign(value=errors["error"])
    wide = _wide(shown, ["scene", "nu", "measure", "cells", "cpu_s_per_s"])
    return wide.rename(columns={"measure": "of", "cells": "1/h", "cpu_s_per_s": "CPU s/s"})


def _title(scene: str) -> str:
    return PROBLEMS[scene].title


def _of_front(frame: pd.DataFrame) -> pd.DataFrame:
    names = [method.name for nu in PROBLEMS[CUBE].nus for method in front(nu)]
    return frame[frame["method"].isin(names)]


def _wide(frame: pd.DataFrame, index: list[str]) -> pd.DataFrame:
    """``value`` by method, in the order of the problems and in that in which methods come first."""
    order = {name: place for place, name in enumerate(PROBLEMS)}
    sorted_frame = frame.sort_values("scene", key=lambda scene: scene.map(order), kind="stable")
    named = sorted_frame.assign(scene=sorted_frame["scene"].map(_title))
    wide = named.pivot(index=index, columns="method", values="value")
    rows = named[index].drop_duplicates()
    columns = list(dict.fromkeys(named["method"]))
    return wide.reindex(pd.MultiIndex.from_frame(rows))[columns].reset_index()
