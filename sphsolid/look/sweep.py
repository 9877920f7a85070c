"""The figure of a sweep: histories over each other, and the last value over what was varied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sphsolid.look.columns import split
from sphsolid.look.curves import label
from sphsolid.look.drawing import Drawing
from sphsolid.look.style import PALETTE, style

_LINES, _MARKERS = ("-", "--", ":", "-."), "osD^vP*X"
Members = Sequence[tuple[Mapping[str, str], Mapping[str, Sequence[float]]]]


def sweep_figure(members: Members, column: str) -> Drawing:
    """``column`` over time for every member, and its last value over the last setting.

    Colours stand for the values of the settings before the last, line styles for the last.
    """
    names = list(members[0][0])
    *before, last = names or [""]
    groups = list(dict.fromkeys(_group(values, before) for values, _ in members))
    steps = list(dict.fromkeys(values.get(last, "") for values, _ in members))
    name, unit = split(column)
    with style():
        figure = Drawing(figsize=(9.0, 3.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        for values, history in members:
            g, s = groups.index(_group(values, before)), steps.index(values.get(last, ""))
            left.plot(
                history["time [s]"], history[column], color=PALETTE[(g + 1) % len(PALETTE)],
                linestyle=_LINES[s % len(_LINES)], linewidth=1.0,
                label=", ".join(f"{key.rpartition('.')[2]} = {v}" for key, v in values.items()),
            )  # fmt: skip
        for g, group in enumerate(groups):
            chosen = [(values, h) for values, h in members if _group(values, before) == group]
            at = [steps.index(values.get(last, "")) for values, _ in chosen]
            right.plot(
                at, [h[column][-1] for _, h in chosen], label=group,
                color=PALETTE[(g + 1) % len(PALETTE)], marker=_MARKERS[g % len(_MARKERS)],
            )  # fmt: skip
        label(left, "time [s]", name, unit)
        label(right, last.rpartition(".")[2] or "case", f"{name} at the end", unit)
        right.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4), useMathText=True)
        right.set_xticks(np.arange(len(steps)), steps)
        _legends(figure, left, right, members, groups)
    return figure


def _group(values: Mapping[str, str], names: Sequence[str]) -> str:
    return ", ".join(f"{name.rpartition('.')[2]} = {values[name]}" for name in names)


def _legends(figure: Any, left: Any, right: Any, members: Members, groups: Sequence[str]) -> None:
    if len(groups) > 1:
        handles, labels = right.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))
    elif len(members) > 1:
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))
