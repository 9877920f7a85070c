"""What a user calls to look at results; what draws is loaded when it is asked for.

Figures are made without pyplot, so nothing needs a display.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sphsolid.errors import require

if TYPE_CHECKING:
    from sphsolid.look.animation import Animation
    from sphsolid.look.comparison import Comparison


def installed(module: str) -> bool:
    """Whether ``module`` can be imported, without doing so."""
    return importlib.util.find_spec(module) is not None


def require_matplotlib(what: str) -> None:
    """Raises ``InputError`` saying what to install where matplotlib is not."""
    require(
        installed("matplotlib") and installed("PIL"),
        f"{what} draws with matplotlib, which is not installed: pip install 'sphsolid[look]'",
    )


class Looking:
    """Draws what ``History.plot`` and ``Snapshot.picture`` ask for."""

    @property
    def can_draw(self) -> bool:
        """Whether matplotlib is installed."""
        return installed("matplotlib") and installed("PIL")

    def plot(self, history: Any, columns: Sequence[str], against: str) -> Any:
        """See :meth:`sphsolid.record.history.History.plot`."""
        require_matplotlib("history.plot()")
        from sphsolid.look.curves import plot_history

        return plot_history(history, columns, against=against)

    def picture(self, snapshot: Any, field: str, options: dict[str, Any]) -> Any:
        """See :meth:`sphsolid.record.snapshot.Snapshot.picture`."""
        require_matplotlib("snapshot.picture()")
        from sphsolid.look.pictures import picture_of

        return picture_of(snapshot, field, **options)


def compare(
    *runs: Any,
    field: str = "pressure",
    columns: Sequence[str] = (),
    labels: Sequence[str] = (),
    up: str = "",
) -> Comparison:
    """Runs beside each other: deformed bodies, histories, and a table of their differences.

    ``runs``: two or more of a simulation, a snapshot, or a run's folder, of either solver.  Bodies
    are drawn at one scale with one range of colours, ``field`` as means over cells, so that
    particles and elements are treated alike.  ``columns`` of the histories are drawn over each
    other, by default all that the runs share.  ``up``: the axis of the body that points up, chosen
    by its shape if left out.  In a notebook the result shows itself; ``.table`` is a table of
    pandas, ``.figure`` a figure, ``.save("folder")`` writes both.

    Raises ``InputError`` for fewer than two runs, for what is none, and where matplotlib is not
    installed.
    """
    require_matplotlib("compare()")
    from sphsolid.look.comparison import comparison

    require(
        not isinstance(labels, str),
        f"compare: labels = {labels!r} must be a list, one for each run",
    )
    columns = [columns] if isinstance(columns, str) else columns
    return comparison(runs, field=field, columns=columns, labels=labels, up=up)


def animate(
    folder: str | Path,
    *,
    field: str = "pressure",
    path: str | Path = "",
    per_second: float = 10.0,
    up: str = "",
) -> Animation:
    """The frames of a run's folder as a GIF, ``animation.gif`` there unless ``path`` says where.

    One scale, one range of colours; ``field`` as for ``snapshot.picture``.  The result is the path
    of the file, and shows itself in a notebook.  Raises ``InputError`` for a folder without
    frames, and where matplotlib or pillow is not installed.
    """
    require_matplotlib("animate()")
    require(
        not isinstance(per_second, str), f"animate: per_second = {per_second!r} must be a number"
    )
    from sphsolid.look.animation import animation_of

    return animation_of(folder, field=field, path=path, per_second=per_second, up=up)
