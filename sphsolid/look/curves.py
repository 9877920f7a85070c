"""Histories as curves: a panel for each unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sphsolid.errors import require
from sphsolid.look.columns import chosen, families, shortened, split
from sphsolid.look.drawing import Drawing
from sphsolid.look.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, style

_LINES = ("-", "--", ":", "-.")
#: Yellow is hard to see as a line.
_COLOURS = (BLACK, ORANGE, SKY, GREEN, VERMILION, BLUE, PURPLE)
#: Inches of a panel.
_WIDTH, _HEIGHT = 4.6, 2.6


def plot_history(history: Any, columns: Sequence[str], *, against: str = "time [s]") -> Drawing:
    """See :meth:`sphsolid.record.history.History.plot`."""
    require(
        len(history.table) > 0,
        "history.plot(): the history has no rows; run with every=... and record=[...]",
    )
    names = [str(name) for name in history.table.columns]
    [x] = chosen([against], names)[:1]
    wanted = [name for name in chosen(columns, names) if name != x]
    require(
        len(wanted) > 0,
        "history.plot(): there is nothing but times; run with record=[Energy(), Probe(...)]",
    )
    groups = families(wanted)
    with style():
        figure, axes = _panels(len(groups))
        for ax, (unit, group) in zip(axes, groups, strict=True):
            shared, rest = shortened([split(name)[0] for name in group])
            for number, (name, short) in enumerate(zip(group, rest, strict=True)):
                ax.plot(
                    history[x], history[name], label=short.replace("_", " "),
                    color=_COLOURS[number % len(_COLOURS)], marker=_marker(history[x]),
                    linestyle=_LINES[number // len(_COLOURS) % len(_LINES)],
                )  # fmt: skip
            label(ax, x, shared, unit)
            if len(group) > 1:
                # Beside the panel: it covers no curve there.
                ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def overlay(
    histories: Mapping[str, Any], columns: Sequence[str], figure: Any, *, against: str = "time [s]"
) -> None:
    """The same columns of several histories over each other, a panel a column, in ``figure``."""
    count = len(columns)
    across = min(3, count)
    with style():
        grid = figure.subplots(-(-count // across), across, squeeze=False)
        for ax in grid.ravel()[count:]:
            ax.set_axis_off()
        for ax, column in zip(grid.ravel(), columns, strict=False):
            for number, (run, history) in enumerate(histories.items()):
                if column in history.table:
                    ax.plot(
                        history[against], history[column], label=run,
                        color=_COLOURS[number % len(_COLOURS)],
                        linestyle=_LINES[number % len(_LINES)],
                        marker=_marker(history[against]),
                    )  # fmt: skip
            name, unit = split(column)
            label(ax, against, name, unit)
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(3, len(labels)))


def label(ax: Any, against: str, name: str, unit: str) -> None:
    """Words and units on both axes."""
    time, its = split(against)
    ax.set_xlabel(f"{_words(time)} [{its}]" if its else _words(time))
    said = {"": "[-]"}.get(unit, f"[{unit}]")
    ax.set_ylabel(f"{_words(name)} {said}" if name else said)
    ax.ticklabel_format(axis="both", style="sci", scilimits=(-3, 4), useMathText=True)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _marker(x: Any) -> str:
    """Few records are shown as points, too."""
    return "o" if len(np.atleast_1d(x)) <= 12 else ""


def _panels(count: int) -> tuple[Drawing, list[Any]]:
    across = 1 if count == 1 else 2
    down = -(-count // across)
    figure = Drawing(figsize=(_WIDTH * across, _HEIGHT * down), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False).ravel()
    for ax in grid[count:]:
        ax.set_axis_off()
    return figure, list(grid[:count])
