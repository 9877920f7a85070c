"""The figure of a sweep: histories over each other, and the last value over what was varied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from sphsolid.look.columns import split
from sphsolid.look.curves import label
from sphsolid.look.drawing import Drawing
from sphsolid.look.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, style

# Any: which names matplotlib's types allow differs between its versions.
_LINES: tuple[Any, ...] = ("-", "--", ":", "-.")
_MARKERS = "osD^vP*X"
#: Yellow is hard to see as a line.
_COLOURS = (ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE, BLACK)
#: Longer values of a setting are numbered, and written out below the panels.
_LONGEST = 14
Members = Sequence[tuple[Mapping[str, str], Mapping[str, Sequence[float]]]]


def sweep_figure(members: Members, column: str) -> Drawing:
    """``column`` over time for every member, and its last value over the last setting.

    Colours stand for the values of the settings before the last, line styles for the last.
    Settings that all members share are left out.
    """
    names = [name for name in members[0][0] if len({values[name] for values, _ in members}) > 1]
    *before, last = names or list(members[0][0])[-1:] or [""]
    groups = list(dict.fromkeys(_group(values, before) for values, _ in members))
    steps = list(dict.fromkeys(values.get(last, "") for values, _ in members))
    name, unit = split(column)
    short = _short(steps)
    written_out = [f"{a}: {b}" for a, b in zip(short, steps, strict=True) if a != b]
    with style():
        below = 0.2 * (len(written_out) + (len(groups) if len(groups) > 1 else 0))
        figure = Drawing(figsize=(9.0, 3.9 + below), layout="constrained")
        left, right = figure.subplots(1, 2)
        for values, history in members:
            g, s = groups.index(_group(values, before)), steps.index(values.get(last, ""))
            left.plot(
                history["time [s]"], history[column], color=_COLOURS[g % len(_COLOURS)],
                linestyle=_LINES[s % len(_LINES)], linewidth=1.0,
            )  # fmt: skip
        for g, group in enumerate(groups):
            chosen = [(values, h) for values, h in members if _group(values, before) == group]
            at = [steps.index(values.get(last, "")) for values, _ in chosen]
            right.plot(
                at, [h[column][-1] for _, h in chosen], label=group,
                color=_COLOURS[g % len(_COLOURS)], marker=_MARKERS[g % len(_MARKERS)],
            )  # fmt: skip
        label(left, "time [s]", name, unit)
        label(right, last.rpartition(".")[2] or "case", f"{name} at the end", unit)
        right.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4), useMathText=True)
        right.set_xticks(np.arange(len(steps)), short)
        if len(steps) > 1:
            _line_styles(left, last, short)
        handles, labels = right.get_legend_handles_labels() if len(groups) > 1 else ([], [])
        labels = [*labels, *written_out]
        if labels:
            handles = [*handles, *(Line2D([], [], linestyle="none") for _ in written_out)]
            # As many columns as the longest label leaves room for.
            across = max(1, min(len(labels), 110 // (8 + max(map(len, labels)))))
            figure.legend(handles, labels, loc="outside lower center", ncols=across)
    return figure


def _short(values: Sequence[str]) -> list[str]:
    """The values themselves, or ``(1)``, ``(2)`` where they are too long for a tick."""
    if all(len(value) <= _LONGEST for value in values):
        return list(values)
    return [f"({k + 1})" for k in range(len(values))]


def _group(values: Mapping[str, str], names: Sequence[str]) -> str:
    return ", ".join(f"{name.rpartition('.')[2]} = {values[name]}" for name in names)


def _line_styles(axes: Any, last: str, steps: Sequence[str]) -> None:
    """Which line is which value of the last setting, over the panel: it covers no curve there."""
    handles = [
        Line2D([], [], color="0.2", linewidth=1.0, linestyle=_LINES[s % len(_LINES)])
        for s in range(len(steps))
    ]
    axes.legend(
        handles, steps, title=last.rpartition(".")[2], ncols=min(6, len(steps)),
        loc="lower left", bbox_to_anchor=(0.0, 1.0), title_fontsize=8.0,
    )  # fmt: skip
