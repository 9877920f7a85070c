"""Figures of frames side by side: methods over times, one scale, one view, one colour bar.

Panels are placed by hand, in inches: they have equal axes and all the same scale, headings are
measured before columns are set, so nothing overlaps however narrow the body is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sphsolid.errors import require
from studies.pictures.colours import ColourRange
from studies.pictures.headings import Grid, headings, time_stamp
from studies.pictures.shots import Absent, Frame, Lost, Shot
from studies.pictures.surface import Drawing, Surface
from studies.pictures.view import Around, View, Window, angled_view
from studies.report.plotting import style

_TEXT = 9.0
#: Height [inch] of a line of text.
_LINE = 0.165
_PAD = 0.1
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
        drawing: Drawing,
        layout: Layout,
    ) -> None:
        """Place panels, headings, colour bar and the bar of length."""
        self.colours, self.view, self.window, self.drawing = colours, view, window, drawing
        self._scale = colours.scale()
        rows, columns = len(grid), len(grid[0])
        with style():
            self.figure = Figure(figsize=(1.0, 1.0), dpi=layout.dpi)
            FigureCanvasAgg(self.figure)
            words = headings(grid)
            left = _PAD + (_LINE * 1.6 * words.lines("rows") if words.rows else 0.0)
            top = _PAD + _LINE * words.lines("columns")
            above = _LINE * words.lines("panels") + (0.07 if words.every_panel()[0] else 0.0)
            right, bottom = 0.85, 0.38
            gap = 0.08 + above
            widest = max((self._width(text) for text in words.over_columns()), default=0.0)
            per_metre = min(
                (layout.width - left - right - columns * _PAD) / (columns * window.width),
                (layout.height - top - bottom - above - (rows - 1) * gap) / (rows * window.height),
            )
            require(
                per_metre > 0.0,
                f"picture: {rows} x {columns} panels do not fit on {layout.width} x "
                f"{layout.height} inch; give a larger Layout or fewer panels",
            )
            w, h = window.width * per_metre, window.height * per_metre
            # Headings beside tall rows turn with them: a row is at least as high as its heading.
            tallest = max((self._width(text) for text in words.rows), default=0.0)
            slot = max(h, tallest)
            pitch, rise = max(w, widest) + _PAD, slot + gap
            body = (rows - 1) * rise + slot + above
            # The bar and its title need some height, whatever the panels have.
            total = max(top + body + bottom, 1.6)
            full = left + columns * pitch + right
            self.figure.set_size_inches(full, total)
            self._size = (full, total)
            self._axes = np.empty((rows, columns), dtype=object)
            self._titles = np.empty((rows, columns), dtype=object)
            for i in range(rows):
                base = total - top - above - 0.5 * (slot + h) - i * rise
                for j in range(columns):
                    start = left + j * pitch + 0.5 * (pitch - w)
                    axes = self._add(start, base, w, h)
                    axes.set_axis_off()
                    self._axes[i, j] = axes
                    self._titles[i, j] = self._text(start + 0.5 * w, base + h + 0.07, va="baseline")
            middles = [left + (j + 0.5) * pitch for j in range(columns)]
            self._columns = [self._text(m, total - top + 0.05, va="baseline") for m in middles]
            self._rows = [
                self._text(0.6 * left, total - top - above - 0.5 * slot - i * rise, rotation=90)
                for i in range(rows)
            ]
            long = min(2.6, max(0.8, 0.8 * body), total - 0.85)
            bar = self._add(full - right + 0.18, 0.5 * (total - long) - 0.14, 0.12, long)
            colours.draw_bar(self.figure, bar)
            self._length_bar(left + 0.5 * (pitch - w), bottom - 0.12, w, per_metre)

    def show(self, grid: Grid) -> None:
        """Draw these frames in the place of those before."""
        words = headings(grid)
        with style():
            for axes, title, frame, text in zip(
                self._axes.flat, self._titles.flat, flat(grid), words.every_panel(), strict=True
            ):
                for artist in (*axes.collections, *axes.texts):
                    artist.remove()
                title.set_text(text)
                self._fill(axes, frame)
            for text, artist in zip(words.rows, self._rows, strict=False):
                artist.set_text(text)
            for text, artist in zip(words.columns, self._columns, strict=False):
                artist.set_text(text)

    def _fill(self, axes: Any, frame: Frame) -> None:
        seen = self.view.project(frame.x) if isinstance(frame, Shot) else np.zeros((1, 3))
        across, upward = self.window.limits(seen)
        axes.set(xlim=across, ylim=upward)
        axes.set_aspect("equal", adjustable="box")
        if isinstance(frame, Shot):
            self.drawing.draw(axes, frame, self.view, self._scale, self.colours.field)
            if frame.folded:
                # Whatever the colours say: they are of a body that is none any more.
                axes.text(0.5, 0.5, FOLDED, transform=axes.transAxes, ha="center", va="center",
                          size=8.0, weight="bold", bbox=_PLATE)  # fmt: skip
            return
        axes.text(
            0.5,
            0.5,
            _why_empty(frame),
            transform=axes.transAxes,
            ha="center",
            va="center",
            color="0.35",
            size=8.0,
        )

    def _add(self, x: float, y: float, w: float, h: float) -> Any:
        full, total = self._size
        return self.figure.add_axes((x / full, y / total, w / full, h / total))

    def _text(self, x: float, y: float, **words: Any) -> Any:
        full, total = self._size
        given: dict[str, Any] = {"ha": "center", "va": "center", "size": _TEXT} | words
        return self.figure.text(x / full, y / total, "", **given)

    def _width(self, text: str) -> float:
        """Width [inch] that a heading takes."""
        artist = self.figure.text(0.0, 0.0, text, size=_TEXT)
        extent = artist.get_window_extent(self.figure.canvas.get_renderer())  # type: ignore[attr-defined]
        artist.remove()
        return float(extent.width / self.figure.dpi)

    def _length_bar(self, x: float, y: float, w: float, per_metre: float) -> None:
        """A bar of a round length under the first panel: the scale of all of them."""
        most = 0.75 * w / per_metre
        power = 10.0 ** np.floor(np.log10(most))
        length = next(m * power for m in (5.0, 2.0, 1.0) if m * power <= most * (1.0 + 1e-9))
        full, total = self._size
        size = length * per_metre
        start = x + 0.5 * (w - size)
        axes = self._add(start, y - 0.03, size, 0.06)
        axes.set_axis_off()
        axes.set(xlim=(0.0, 1.0), ylim=(-1.0, 1.0))
        axes.plot([0, 0, 0, 1, 1, 1], [-1, 1, 0, 0, 1, -1], color="0.2", lw=0.8, clip_on=False)
        self.figure.text(
            (start + 0.5 * size) / full,
            (y - 0.06) / total,
            f"{length:g} m",
            ha="center",
            va="top",
            size=8.0,
        )


#: Defaults are immutable objects, so one serves all figures.
SIDE, WHOLE, SURFACE, PAGE = angled_view(), Around(), Surface(), Layout()


def panel_figure(
    grid: Grid,
    *,
    colours: ColourRange,
    view: View = SIDE,
    window: Window | Around = WHOLE,
    drawing: Drawing = SURFACE,
    layout: Layout = PAGE,
) -> Figure:
    """Frames in rows and columns, ``grid[i][j]`` in row ``i``, column ``j``.

    Rows of methods over columns of times, or the other way round, get their headings at the
    edges; any other grid gets a heading over each panel.  Save with ``plotting.save_figure``.
    Raises ``InputError`` for a grid that is empty or not rectangular, or has nothing to draw.
    """
    check_grid(grid)
    shots = [frame for frame in flat(grid) if isinstance(frame, Shot)]
    sheet = Sheet(
        grid,
        colours=colours,
        view=view,
        window=window.of([shot.x for shot in shots], view),
        drawing=drawing,
        layout=layout,
    )
    sheet.show(grid)
    return sheet.figure


def by_label_and_time(frames: Sequence[Frame]) -> list[list[Frame]]:
    """A grid of a row a label, a column a time, labels in order of appearance, times ascending.

    Where there is no frame the panel says so.
    """
    labels = list(dict.fromkeys(frame.label for frame in frames))
    times = sorted({float(f"{frame.time:.6g}") for frame in frames})
    known = {(frame.label, float(f"{frame.time:.6g}")): frame for frame in frames}
    return [[known.get((a, t), Absent(label=a, time=t)) for t in times] for a in labels]


def turned(grid: Grid) -> list[list[Frame]]:
    """Rows as columns."""
    return [list(column) for column in zip(*grid, strict=True)]


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


def _why_empty(frame: Lost | Absent) -> str:
    if isinstance(frame, Absent):
        return frame.reason
    return f"solution lost\nat {time_stamp(frame.lost_at, frame.lost_at)[4:]}"
