"""Figures of frames side by side: methods over times, one scale, one view, one colour bar.

Panels are placed by hand, in inches: they have equal axes and all the same scale, headings are
measured before columns are set, so nothing overlaps however narrow the body is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from sphsolid.errors import require
from sphsolid.look.colours import ColourRange
from sphsolid.look.drawing import Drawing
from sphsolid.look.frame import Absent, Frame, Shot
from sphsolid.look.headings import Grid, headings, lines, time_stamp
from sphsolid.look.style import style
from sphsolid.look.surface import Surface
from sphsolid.look.view import Around, View, Window, angled_view

_TEXT = 9.0
#: Height [inch] of a line of text, and what is left free around a panel and over its heading.
_LINE, _PAD, _OVER = 0.165, 0.1, 0.07
#: Room [inch] for the bar of colours and for the bar of length.
_RIGHT, _BOTTOM = 0.85, 0.38
#: What a panel says whose positions are judged folded, and the plate it stands on.
FOLDED = "folded"
_PLATE = {"facecolor": "white", "edgecolor": "0.3", "linewidth": 0.5, "boxstyle": "round,pad=0.25"}


@dataclass(frozen=True)
class Layout:
    """Paper: at most ``width`` and ``height`` [inch]; the panels are as large as that allows."""

    width: float = 7.2
    height: float = 8.5
    dpi: int = 200


class Sheet:
    """A figure with a fixed layout that can show one grid of frames after the other.

    ``grid`` is the one that the layout is made for: the shape and the headings.
    """

    def __init__(
        self,
        grid: Grid,
        *,
        colours: ColourRange,
        view: View,
        window: Window,
        drawing: Surface,
        layout: Layout,
    ) -> None:
        """Place panels, headings, colour bar and the bar of length."""
        self.colours, self.view, self.window, self.drawing = colours, view, window, drawing
        rows, columns = len(grid), len(grid[0])
        words = headings(grid)
        left = _PAD + 1.6 * _LINE * lines(words.rows)
        top = _PAD + _LINE * lines(words.columns)
        above = _LINE * lines(words.panels) + (_OVER if lines(words.panels) else 0.0)
        gap = 0.08 + above
        per_metre = min(
            (layout.width - left - _RIGHT - columns * _PAD) / (columns * window.width),
            (layout.height - top - _BOTTOM - above - (rows - 1) * gap) / (rows * window.height),
        )
        require(
            per_metre > 0.0,
            f"picture: {rows} x {columns} panels do not fit on {layout.width} x {layout.height} "
            "inch; give a larger Layout or fewer panels",
        )
        w, h = window.width * per_metre, window.height * per_metre
        with style():
            self.figure = Drawing(figsize=(1.0, 1.0), dpi=layout.dpi)
            # Headings beside tall rows turn with them: a row is at least as high as its heading.
            slot = max(h, self._widest(words.rows))
            pitch = max(w, self._widest([*words.columns, *words.panels])) + _PAD
            rise = slot + gap
            body = (rows - 1) * rise + slot + above
            # The bar of colours and its title need some height, whatever the panels have.
            self._width, self._height = (
                left + columns * pitch + _RIGHT, max(top + body + _BOTTOM, 1.6)
            )  # fmt: skip
            self.figure.set_size_inches(self._width, self._height)
            self._page = self._axes_at(0.0, 0.0, self._width, self._height)
            self._page.set(xlim=(0.0, self._width), ylim=(0.0, self._height))
            head = self._height - top
            middles = [head - above - 0.5 * slot - i * rise for i in range(rows)]
            centres = [left + (j + 0.5) * pitch for j in range(columns)]
            self._panels = [
                self._axes_at(x - 0.5 * w, y - 0.5 * h, w, h) for y in middles for x in centres
            ]
            self._titles = [
                self._text(x, y + 0.5 * h + _OVER, va="baseline") for y in middles for x in centres
            ]
            self._columns = [self._text(x, head + 0.05, va="baseline") for x in centres]
            self._rows = [self._text(0.6 * left, y, va="center", rotation=90) for y in middles]
            long = min(2.6, max(0.8, 0.8 * body), self._height - 0.85)
            bar = self._axes_at(
                self._width - _RIGHT + 0.18, 0.5 * (self._height - long) - 0.14, 0.12, long
            )
            bar.set_axis_on()
            colours.draw_bar(self.figure, bar)
            self._length_bar(centres[0], _BOTTOM - 0.12, 0.75 * w, per_metre)

    def show(self, grid: Grid) -> None:
        """Draw these frames in the place of those before."""
        words = headings(grid)
        with style():
            for axes, frame in zip(self._panels, flat(grid), strict=True):
                for artist in (*axes.collections, *axes.texts):
                    artist.remove()
                self._fill(axes, frame)
            for artists, texts in (
                (self._titles, words.panels), (self._columns, words.columns),
                (self._rows, words.rows),
            ):  # fmt: skip
                for artist, text in zip(artists, texts, strict=False):
                    artist.set_text(text)

    def _fill(self, axes: Any, frame: Frame) -> None:
        middle = {"transform": axes.transAxes, "ha": "center", "va": "center", "size": 8.0}
        seen = self.view.project(frame.x) if isinstance(frame, Shot) else np.zeros((1, 3))
        across, upward = self.window.limits(seen)
        axes.set(xlim=across, ylim=upward)
        axes.set_aspect("equal", adjustable="box")
        if not isinstance(frame, Shot):
            axes.text(0.5, 0.5, _why_empty(frame), color="0.35", **middle)
            return
        scale = self.colours.scale()
        self.drawing.draw(axes, frame, self.view, scale, self.colours.field)
        if frame.folded:
            # Whatever the colours say: they are of a body that is none any more.
            axes.text(0.5, 0.5, FOLDED, weight="bold", bbox=_PLATE, **middle)

    def _axes_at(self, x: float, y: float, w: float, h: float) -> Any:
        """Axes without frame, in inches from the lower left corner."""
        width, height = self._width, self._height
        axes = self.figure.add_axes((x / width, y / height, w / width, h / height))
        axes.set_axis_off()
        return axes

    def _text(self, x: float, y: float, **words: Any) -> Any:
        return self._page.text(x, y, "", ha="center", size=_TEXT, **words)

    def _widest(self, texts: Any) -> float:
        """Width [inch] of the widest heading."""
        widths = [0.0]
        for text in filter(None, texts):
            artist = self.figure.text(0.0, 0.0, text, size=_TEXT)
            widths.append(artist.get_window_extent().width / self.figure.dpi)
            artist.remove()
        return max(widths)

    def _length_bar(self, middle: float, y: float, most: float, per_metre: float) -> None:
        """A bar of a round length, at most ``most`` [inch]: the scale of all panels."""
        power = 10.0 ** np.floor(np.log10(most / per_metre))
        round_ones = (m * power for m in (5.0, 2.0, 1.0))
        length = next(m for m in round_ones if m * per_metre <= most * (1.0 + 1e-9))
        a, b = middle - 0.5 * length * per_metre, middle + 0.5 * length * per_metre
        ticks = [y - 0.03, y + 0.03, y, y, y + 0.03, y - 0.03]
        self._page.plot([a, a, a, b, b, b], ticks, color="0.2", linewidth=0.8)
        self._page.text(middle, y - 0.06, f"{length:g} m", ha="center", va="top", size=8.0)


#: Defaults are immutable objects, so one serves all figures.
SIDE, WHOLE, SURFACE, PAGE = angled_view(), Around(), Surface(), Layout()


def panel_figure(
    grid: Grid,
    *,
    colours: ColourRange,
    view: View = SIDE,
    window: Around = WHOLE,
    drawing: Surface = SURFACE,
    layout: Layout = PAGE,
) -> Drawing:
    """Frames in rows and columns, ``grid[i][j]`` in row ``i``, column ``j``.

    Rows of methods over columns of times, or the other way round, get their headings at the
    edges; any other grid gets a heading over each panel.  Save with ``figure.savefig``.
    Raises ``InputError`` for a grid that is empty or not rectangular, or has nothing to draw.
    """
    check_grid(grid)
    positions = [frame.x for frame in flat(grid) if isinstance(frame, Shot)]
    sheet = Sheet(
        grid, colours=colours, view=view, window=window.of(positions, view), drawing=drawing,
        layout=layout,
    )  # fmt: skip
    sheet.show(grid)
    return sheet.figure


def check_grid(grid: Grid) -> None:
    """Raise ``InputError`` unless the grid has rows of one length, at least one."""
    lengths = {len(row) for row in grid}
    require(
        len(grid) > 0 and len(lengths) == 1 and 0 not in lengths,
        f"picture: rows of panels have lengths {[len(row) for row in grid]}; give at least one row "
        "and all of one length, Absent(...) where there is no frame",
    )


def flat(grid: Grid) -> Iterator[Frame]:
    """All frames, row after row."""
    return (frame for row in grid for frame in row)


def _why_empty(frame: Frame) -> str:
    if isinstance(frame, Absent):
        return frame.reason
    return f"diverged\nat {time_stamp(frame.diverged_at, frame.diverged_at)[4:]}"  # type: ignore[union-attr]
