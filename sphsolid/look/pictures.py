"""One deformed body in colour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphsolid.errors import InputError
from sphsolid.look.colours import ColourRange, limits
from sphsolid.look.drawing import Drawing
from sphsolid.look.frame import take_shot
from sphsolid.look.panels import Layout, panel_figure
from sphsolid.look.side import side_of
from sphsolid.look.view import View

#: Paper for one body.
_PAPER = Layout(width=5.2, height=5.2, dpi=150)


def picture_of(
    snapshot: Any,
    field: str = "pressure",
    *,
    up: str = "",
    view: View | None = None,
    limits: tuple[float, float] | None = None,
    title: str = "",
    path: str | Path = "",
) -> Drawing:
    """The deformed body of a snapshot, coloured by ``field`` at its vertices.

    ``up``: the axis of the body that points up (``x``, ``y``, ``z``), or a ``view`` of
    ``sphsolid.look.view``; chosen by its shape if both are left out.  ``limits`` of the colours in
    SI units, else those of 99 % of the volume.  Where ``path`` is given the figure is written
    there, too.
    """
    shot = take_shot(snapshot, title, fields=[field])
    seen = side_of(snapshot.X, up=up) if view is None else view
    figure = panel_figure([[shot]], colours=_colours(shot, field, limits), view=seen, layout=_PAPER)
    if str(path):
        figure.save(path)
    return figure


def _colours(shot: Any, field: str, ends: tuple[float, float] | None) -> ColourRange:
    if ends is None:
        return limits([shot], field=field)
    try:
        low, high = map(float, ends)
    except (TypeError, ValueError):
        raise InputError(
            f"picture: limits = {ends!r} are not two numbers, the least and the largest value"
        ) from None
    values = shot.value(field)
    return ColourRange(field, low, high, (bool(values.min() < low), bool(values.max() > high)))
