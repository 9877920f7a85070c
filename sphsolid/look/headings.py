"""What is written over and beside the panels of a grid: labels of methods and time stamps.

What all panels of a row or column share is said once, at its head; otherwise over each panel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

from sphsolid.look.frame import Frame

Grid = Sequence[Sequence[Frame]]


@dataclass(frozen=True)
class Headings:
    """Texts at the left of the rows, over the columns, over all panels; empty where not used."""

    rows: Sequence[str]
    columns: Sequence[str]
    panels: Sequence[str]


def headings(grid: Grid) -> Headings:
    """Rows of one method and columns of one time, or the other way round, or each panel."""
    latest = max(frame.time for row in grid for frame in row)
    times = [[time_stamp(frame.time, latest) for frame in row] for row in grid]
    labels = [[frame.label for frame in row] for row in grid]
    count = len(grid) * len(grid[0])
    for beside, over in ((labels, times), (times, labels)) if count > 1 else ():
        if all(len(set(texts)) == 1 for texts in (*beside, *zip(*over, strict=True))):
            return Headings([row[0] for row in beside], over[0], [""] * count)
    pairs = zip(chain(*labels), chain(*times), strict=True)
    return Headings([], [], ["\n".join(filter(None, pair)) for pair in pairs])


def lines(texts: Sequence[str]) -> int:
    """Most lines of text that one of them has."""
    return max((1 + text.count("\n") for text in texts if text), default=0)


def time_stamp(time: float, latest: float) -> str:
    """``t = 30 ms``, in the unit that suits the ``latest`` time [s] of all."""
    if latest >= 1.0:
        return f"t = {time:.4g} s"
    if latest >= 1e-3 or latest <= 0.0:
        return f"t = {1e3 * time:.4g} ms"
    return f"t = {1e6 * time:.4g} µs"
