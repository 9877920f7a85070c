"""Free vibration and pulse: the cases, their tables, and what they say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from studies.harness.cases import Case, Row
from studies.report.plotting import BLUE, GREEN, ORANGE, VERMILION, panels, save_figure
from studies.stability.hard_case_methods import DEFAULTS, FEM, FEW, Method

VIBRATION_NU, PULSE_NU = (0.3, 0.495), (0.0, 0.495)
#: Energy that a mode must keep for ten periods, and largest error of its frequency.
LEAST_LEFT, MOST_OFF = 0.98, 0.02
#: A pulse may be off by this many times what it is with B-bar elements.
AS_ELEMENTS = 1.25
VIBRATION_COLUMNS = (
    "method", "nu", "cells", "survived", "reason", "energy_left", "damping_ratio", "omega",
    "omega_reference", "omega_finest", "frequency_error", "steps", "wall_s",
)  # fmt: skip
PULSE_COLUMNS = (
    "method", "nu", "cells", "survived", "reason", "energy_left", "error", "lag", "width",
    "width_reference", "steps", "wall_s",
)  # fmt: skip
_COLOURS = dict(zip((method.name for method in FEW), (BLUE, ORANGE, VERMILION, GREEN), strict=True))
YES, PARTLY, NO, UNKNOWN = "reproduced", "reproduced in part", "not reproduced", "not run"


def _case(kind: str, method: Method, nu: float, cells: int, cost: float) -> Case:
    arguments = {"method": method.arguments(), "poisson_ratio": nu, "cells": cells}
    name = f"{kind}, nu {nu:g}, 1/{cells}: {method.name}"
    return Case(name, f"studies.stability.wave_runs:{kind}", arguments, cost)


def wave_cases(quick: bool) -> list[Case]:
    """The mode of the block on 1/8 and 1/12, and the pulse; coarse and two methods in short."""
    listed = []
    methods = (DEFAULTS, FEM) if quick else FEW
    for nu in (0.3,) if quick else VIBRATION_NU:
        stiff = 4.0 if nu > 0.4 else 1.0
        for method in methods:
            listed.append(_case("vibration", method, nu, 4 if quick else 8, 4.0 * stiff))
        for method in () if quick else (DEFAULTS, FEM):
            listed.append(_case("vibration", method, nu, 12, 12.0 * stiff))
    for nu in PULSE_NU[:1] if quick else PULSE_NU:
        listed += [_case("pulse", method, nu, 10, 1.0) for method in methods]
    return listed


def wave_tables(rows: list[Row]) -> dict[str, pd.DataFrame]:
    """``vibration`` and ``pulse``, a row a run."""
    return {
        part: pd.DataFrame([row for row in rows if row.get("part") == part], columns=[*columns])
        for part, columns in (("vibration", VIBRATION_COLUMNS), ("pulse", PULSE_COLUMNS))
    }


#: Where a bar is cut, with its value above it.
_TALLEST = 125.0


def vibration_figure(table: pd.DataFrame, out: Path) -> Path:
    """Energy left after ten periods, and frequency error: a bar a method, a group a case."""
    groups = list(dict.fromkeys(zip(table["nu"], table["cells"], strict=True)))
    figure, axes = panels(1, 2, width=3.6, height=2.9)
    measures = (("energy_left", "energy left after ten periods [%]", 100.0),
                ("frequency_error", "frequency error [%]", 100.0))  # fmt: skip
    for ax, (column, label, scale) in zip(axes[0], measures, strict=True):
        for shift, (name, colour) in enumerate(_COLOURS.items()):
            part = table[(table["method"] == name) & (table["survived"] == True)]  # noqa: E712
            if not len(part):
                continue
            at = [groups.index(key) for key in zip(part["nu"], part["cells"], strict=True)]
            place = np.array(at) + 0.2 * (shift - 1.5)
            height = scale * part[column].to_numpy()
            ax.bar(place, np.minimum(height, _TALLEST), width=0.19, color=colour, label=name)
            for x, value in zip(place, height, strict=True):
                if value > _TALLEST:
                    # A bar that grew a millionfold would leave nothing of the others.
                    ax.annotate(f"{value:.0e}", (x, _TALLEST), ha="center", va="bottom", fontsize=7)
        ax.set_xticks(range(len(groups)), [f"nu {nu:g}\n1/{cells}" for nu, cells in groups])
        ax.set_ylabel(label)
        ax.axhline(0.0, color="black", linewidth=0.6)
        ax.grid(visible=False, axis="x")
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2)
    return save_figure(figure, out / "vibration")


def vibration_keeps_its_energy(tables: dict[str, pd.DataFrame]) -> tuple[str, str]:
    """Reproduced: the defaults keep ``LEAST_LEFT`` of the energy, and the frequency."""
    table = tables["vibration"]
    ours = table[table["method"] == DEFAULTS.name]
    if not len(ours):
        return UNKNOWN, "no vibration was run with the defaults"
    kept = (ours["energy_left"] >= LEAST_LEFT) & (ours["frequency_error"].abs() <= MOST_OFF)
    said = "; ".join(
        f"nu {row.nu:g} on 1/{row.cells}: {row.energy_left:.1%} left, damping ratio "
        f"{row.damping_ratio:.1e}, frequency {row.frequency_error:+.1%}"
        for row in ours.itertuples()
    )
    return _three(int(kept.sum()), len(ours)), said + _beside(
        table, lambda row: f"{row['energy_left']:.1%} left, frequency {row['frequency_error']:+.1%}"
    )


def short_waves_arrive(tables: dict[str, pd.DataFrame]) -> tuple[str, str]:
    """Reproduced: a pulse of three spacings is as near to the exact one as with B-bar elements."""
    table = tables["pulse"]
    ours = table[table["method"] == DEFAULTS.name]
    theirs = table[table["method"] == FEM.name].set_index("nu")["error"]
    ours = ours[ours["nu"].isin(theirs.index)]
    if not len(ours):
        return UNKNOWN, "no pulse was run with the defaults and with B-bar elements"
    near = [row.error <= AS_ELEMENTS * theirs[row.nu] for row in ours.itertuples()]
    said = "; ".join(
        f"nu {row.nu:g}: off by {row.error:.0%} ({theirs[row.nu]:.0%} with B-bar elements), "
        f"{row.energy_left:.0%} of the energy left, {row.lag:.1f} spacings late"
        for row in ours.itertuples()
    )
    return _three(sum(near), len(near)), said


def _beside(table: pd.DataFrame, said) -> str:  # type: ignore[no-untyped-def]
    theirs = table[table["method"] == FEM.name]
    parts = [f"nu {row['nu']:g} on 1/{row['cells']} {said(row)}" for _, row in theirs.iterrows()]
    return f"; B-bar elements: {'; '.join(parts)}" if parts else ""


def _three(part: int, whole: int) -> str:
    return YES if part == whole else PARTLY if part else NO


WAVE_CLAIMS = (
    ("a free vibration keeps its energy and its frequency with the defaults",
     vibration_keeps_its_energy),
    ("a pulse three spacings wide arrives as it does with B-bar elements", short_waves_arrive),
)  # fmt: skip


def wave_verdicts(tables: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """One row a claim, as in ``verdicts``."""
    rows = [(claim, *decide(tables)) for claim, decide in WAVE_CLAIMS]
    return pd.DataFrame(rows, columns=["claim", "verdict", "decided by"])
