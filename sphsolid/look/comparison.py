"""Runs beside each other: bodies, histories, and a table of differences."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sphsolid.errors import require
from sphsolid.look.colours import limits
from sphsolid.look.columns import OWN, chosen
from sphsolid.look.curves import overlay
from sphsolid.look.drawing import Drawing
from sphsolid.look.frame import take_shot
from sphsolid.look.panels import Layout, panel_figure
from sphsolid.look.runs import Run, run_of
from sphsolid.look.scalars import CELL, scalar
from sphsolid.look.side import side_of
from sphsolid.paths import path_of

#: Most columns that are drawn when nobody chooses.
MOST = 6
_WIDTH = 9.0


@dataclass(frozen=True)
class Comparison:
    """``table``: a row for each quantity, a column for each run, and how far each is off the first.

    ``bodies`` the deformed bodies, ``histories`` the curves (None where the runs share none).
    """

    table: pd.DataFrame
    bodies: Drawing
    histories: Drawing | None

    @property
    def figure(self) -> Drawing:
        """The bodies side by side."""
        return self.bodies

    def save(self, folder: str | Path) -> Path:
        """Write ``bodies.png``, ``histories.png`` and ``table.csv`` into ``folder``."""
        place = path_of(folder)
        place.mkdir(parents=True, exist_ok=True)
        self.bodies.save(place / "bodies.png")
        if self.histories is not None:
            self.histories.save(place / "histories.png")
        self.table.to_csv(place / "table.csv")
        return place

    def _repr_html_(self) -> str:
        drawn = [each for each in (self.bodies, self.histories) if each is not None]
        images = [
            f'<img src="data:image/png;base64,{base64.b64encode(each.png()).decode()}"/>'
            for each in drawn
        ]
        return "<br/>".join([*images, self.table.to_html(float_format=lambda v: f"{v:.5g}")])

    def __str__(self) -> str:
        return str(self.table.to_string(float_format=lambda v: f"{v:.5g}"))


def comparison(
    given: Sequence[Any], *, field: str, columns: Sequence[str], labels: Sequence[str], up: str
) -> Comparison:
    """See :func:`sphsolid.look.compare`."""
    require(len(given) >= 2, f"compare: {len(given)} runs were given; it takes two or more")
    runs = [run_of(each) for each in given]
    names = _labels(runs, labels)
    shown = CELL + field if scalar(field, runs[0].snapshot.further).is_of_law else field
    grid = [
        [take_shot(run.snapshot, _folded_over(name), fields=[shown])
         for run, name in zip(runs, names, strict=True)]
    ]  # fmt: skip
    view = side_of(runs[0].snapshot.X, up=up)
    layout = Layout(width=max(_WIDTH, 2.6 * len(runs)), height=5.5, dpi=150)
    bodies = panel_figure(grid, colours=limits(grid, field=shown), view=view, layout=layout)
    drawn = _shared(runs, columns)
    return Comparison(_table(runs, names), bodies, _histories(runs, names, drawn))


def _labels(runs: Sequence[Run], labels: Sequence[str]) -> list[str]:
    require(
        len(labels) in (0, len(runs)),
        f"compare: {len(labels)} labels for {len(runs)} runs; give one for each, or none",
    )
    names = list(labels) or _without_scene([run.label for run in runs])
    return [
        name if names.count(name) == 1 else f"{name} ({k + 1})" for k, name in enumerate(names)
    ]


def _without_scene(names: Sequence[str]) -> list[str]:
    """Names of simulations begin with their scene: left out where it is the same."""
    low, high = min(names), max(names)
    cut = next((k for k, (a, b) in enumerate(zip(low, high, strict=False)) if a != b), 0)
    has_end = cut and all(name[cut] in "-_" for name in names if len(name) > cut)
    return [name[cut + 1 :] for name in names] if has_end else list(names)


def _folded_over(name: str, width: int = 26) -> str:
    """A long name on several lines, broken where a word ends."""
    lines = [""]
    for part in name.replace("-", "- ").replace("_", "_ ").split(" "):
        if lines[-1] and len(lines[-1] + part) > width:
            lines.append("")
        lines[-1] += part if part.endswith(("-", "_")) or lines[-1].endswith(("-", "_")) else (
            f" {part}" if lines[-1] else part
        )  # fmt: skip
    return "\n".join(lines)


def _shared(runs: Sequence[Run], columns: Sequence[str]) -> list[str]:
    tables = [[str(name) for name in run.history.table.columns] for run in runs]
    shared = [name for name in tables[0] if all(name in table for table in tables)]
    if not columns:
        return [name for name in shared if name not in OWN][:MOST]
    return chosen(columns, shared)


def _histories(
    runs: Sequence[Run], names: Sequence[str], columns: Sequence[str]
) -> Drawing | None:
    if not columns:
        return None
    down = -(-len(columns) // 3)
    figure = Drawing(figsize=(_WIDTH, 2.5 * down + 0.4), layout="constrained")
    pairs = zip(names, (run.history for run in runs), strict=True)
    overlay(dict(pairs), columns, figure)
    return figure


def _table(runs: Sequence[Run], names: Sequence[str]) -> pd.DataFrame:
    rows: dict[str, list[float]] = {}
    for row in (_of_body(run.snapshot) for run in runs):
        for name, value in row.items():
            rows.setdefault(name, []).append(value)
    for column in _all_shared(runs):
        rows[f"{column}, at the end"] = [float(run.history[column][-1]) for run in runs]
    first, *others = names
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(names))
    for name in others:
        table[f"{name} - {first}"] = table[name] - table[first]
    for run, name in zip(runs[1:], others, strict=True):
        table[f"largest over time, {name}"] = [
            _largest(runs[0], run, row.removesuffix(", at the end")) for row in table.index
        ]
    table.index.name = "quantity"
    return table


def _all_shared(runs: Sequence[Run]) -> list[str]:
    tables = [list(run.history.table.columns) for run in runs]
    return [c for c in tables[0] if c not in OWN and all(c in table for table in tables)]


def _of_body(snapshot: Any) -> dict[str, float]:
    """What a body is known by: extents of its fields, whatever the method."""
    u = np.linalg.norm(snapshot.field("u").values, axis=1)
    found = {
        "time [s]": float(snapshot.time),
        "points [-]": float(len(snapshot.X)),
        "largest displacement [m]": float(u.max()),
    }
    for name, unit in (("pressure", "Pa"), ("von_mises", "Pa"), ("J", "-")):
        values = snapshot.field(name).values
        if name != "von_mises":
            found[f"least {name} [{unit}]"] = float(values.min())
        found[f"largest {name} [{unit}]"] = float(values.max())
    return found


def _largest(first: Run, other: Run, column: str) -> float:
    """Largest difference of a column at the records that both have; nan for what is no column."""
    a, b = first.history.table, other.history.table
    if column not in a or column not in b:
        return float("nan")
    time = first.history["time [s]"]
    place = np.searchsorted(other.history["time [s]"], time * (1.0 - 1e-9))
    inside = place < len(b)
    same = np.zeros(len(time), dtype=bool)
    same[inside] = np.isclose(other.history["time [s]"][place[inside]], time[inside], rtol=1e-6)
    if not same.any():
        return float("nan")
    return float(np.max(np.abs(first.history[column][same] - other.history[column][place[same]])))
