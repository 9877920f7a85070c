"""Frames of bodies as a GIF: one scale and one palette; the same frames give the same bytes."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from sphsolid.errors import require
from sphsolid.look.colours import ColourRange, limits
from sphsolid.look.frame import Frame, Shot, take_shot
from sphsolid.look.panels import SIDE, SURFACE, WHOLE, Layout, Sheet, check_grid, flat
from sphsolid.look.side import side_of
from sphsolid.look.surface import Surface
from sphsolid.look.view import Around, View
from sphsolid.paths import path_of
from sphsolid.record.atomic import atomic
from sphsolid.record.stored import frame_files, read_frame

#: Small: a GIF is to be looked at in a browser.
SMALL = Layout(width=4.0, height=4.5, dpi=95)


@dataclass(frozen=True)
class Animation:
    """A GIF on disk; it is its path, and shows itself in a notebook."""

    path: Path
    pictures: int

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.path.read_bytes()).decode()
        return f'<img src="data:image/gif;base64,{data}"/>'


def animation_of(
    folder: str | Path, *, field: str, path: str | Path, per_second: float, up: str
) -> Animation:
    """See :func:`sphsolid.look.animate`."""
    place = path_of(folder)
    shots = []
    for _, file in frame_files(place):
        snapshot = read_frame(file)
        shots.append(take_shot(snapshot, "", fields=[field]))
    require(len(shots) > 0, f"{place} has no frames yet")
    target = path_of(path) if str(path) else place / "animation.gif"
    require(target.suffix == ".gif", f"animate: {target.name!r} does not end in .gif")
    require(target.parent.is_dir(), f"animate: the folder {target.parent} does not exist")
    view = side_of(snapshot.X, up=up)
    colours = limits(shots, field=field)
    write_gif(shots, target, colours=colours, view=view, per_second=per_second)
    return Animation(target, len(shots))


def write_gif(
    frames: Sequence[Shot] | Sequence[Sequence[Frame]],
    path: Path,
    *,
    colours: ColourRange,
    view: View = SIDE,
    window: Around = WHOLE,
    drawing: Surface = SURFACE,
    layout: Layout = SMALL,
    per_second: float = 10.0,
    hold: float = 1.0,
) -> Path:
    """Write a GIF of ``frames`` in order; each a frame, or a row of them for several methods.

    One scale, window and layout for all; the last picture stays ``hold`` [s], then it starts
    again.  Pictures that are equal pixel by pixel are shown as one, for longer.  Raises
    ``InputError`` when there is nothing to show.
    """
    require(len(frames) > 0, "write_gif: there are no frames")
    require(
        0.0 < per_second <= 50.0,
        f"write_gif: per_second = {per_second} is outside (0, 50], what browsers show",
    )
    rows = [[frame] if isinstance(frame, Frame) else list(frame) for frame in frames]
    check_grid(rows)
    positions = [frame.x for frame in flat(rows) if isinstance(frame, Shot)]
    sheet = Sheet(
        rows[-1:], colours=colours, view=view, window=window.of(positions, view),
        drawing=drawing, layout=layout,
    )  # fmt: skip
    palette = _palette(colours)
    # No dithering: it would flicker, and not compress.
    pictures = [
        _picture(sheet, row).quantize(palette=palette, dither=Image.Dither.NONE) for row in rows
    ]
    durations = [round(1e3 / per_second)] * len(pictures)
    durations[-1] += round(1e3 * hold)
    buffer = io.BytesIO()
    pictures[0].save(
        buffer, format="GIF", save_all=True, append_images=pictures[1:], duration=durations,
        loop=0, optimize=False,
    )  # fmt: skip
    with atomic(path) as part:
        part.write_bytes(buffer.getvalue())
    return path


def _picture(sheet: Sheet, row: Sequence[Frame]) -> Image.Image:
    sheet.show([row])
    canvas: Any = sheet.figure.canvas
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def _palette(colours: ColourRange) -> Image.Image:
    """200 colours for all pictures: the bar's in four shades, and greys for text and lines.

    Made from the colours and not from the pictures: the bar keeps its steps, white stays white.
    """
    values = np.linspace(colours.low, colours.high, 43)
    bar = colours.scale().to_rgba(values)[:, :3]
    shades = [shade * bar for shade in (1.0, 0.9, 0.78, 0.55)]
    greys = np.repeat(np.linspace(0.0, 1.0, 28)[:, None], 3, axis=1)
    entries = np.rint(255.0 * np.concatenate([*shades, greys])).astype(int)
    palette = Image.new("P", (1, 1))
    palette.putpalette(entries.ravel().tolist())
    return palette
