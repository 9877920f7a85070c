"""What is written over and beside the panels of a grid: method labels and time stamps.

What all panels of a row or column share is said once, at its head; otherwise over each panel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from studies.pictures.shots import Frame

Grid = Sequence[Sequence[Frame]]


@dataclass(frozen=True)
class Headings:
    """Texts at the left of the rows, over the columns, over the panels; empty where not used."""

    rows: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    panels: tuple[tuple[str, ...], ...] = ()

    def lines(self, part: str) -> int:
        """Most lines of text in a part (``rows``, ``columns``, ``panels``)."""
        given = self.every_panel() if part == "panels" else getattr(self, part)
        return max((1 + text.count("\n") for text in given if text), default=0)

    def over_columns(self) -> list[str]:
        """All texts that have to fit the width of a column."""
        return [*self.columns, *self.every_panel()]

    def every_panel(self) -> list[str]:
        """Texts over the panels, row after row."""
        return [text for row in self.panels for text in row]


def headings(grid: Grid) -> Headings:
    """Rows of one method and columns of one time, or the other way round, or each panel."""
    latest = max(frame.time for row in grid for frame in row)
    times = [[time_stamp(frame.time, latest) for frame in row] for row in grid]
    labels = [[frame.label for frame in row] for row in grid]
    blank = tuple(tuple("" for _ in row) for row in grid)
    if len(grid) * len(grid[0]) > 1:
        for beside, over in ((labels, times), (times, labels)):
            rows, columns = [set(row) for row in beside], [set(c) for c in _turned(over)]
            if all(len(texts) == 1 for texts in (*rows, *columns)):
                heads = tuple(row[0] for row in beside)
                return Headings(heads if any(heads) else (), tuple(over[0]), blank)
    both = tuple(
        tuple("\n".join(filter(None, pair)) for pair in zip(*row, strict=True))
        for row in zip(labels, times, strict=True)
    )
    return Headings(panels=both)


def time_stamp(time: float, latest: float) -> str:
    """``t = 30 ms``, in the unit that suits the ``latest`` time [s] of all."""
    if latest >= 1.0:
        return f"t = {time:.4g} s"
    if latest >= 1e-3 or latest <= 0.0:
        return f"t = {1e3 * time:.4g} ms"
    return f"t = {1e6 * time:.4g} µs"


def _turned(grid: list[list[str]]) -> Iterator[tuple[str, ...]]:
    return zip(*grid, strict=True)
