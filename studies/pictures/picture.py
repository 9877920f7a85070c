"""Pictures of a study: which frames they show, and how they are drawn from what was kept.

At the end of a run :func:`keep_frames` takes the frames that the pictures need out of the folder
of the workers and keeps them beside the tables: float32, of each only the faces that are seen and
the field that is drawn.  Pictures are drawn from that file, also in a fresh clone, and refuse
where it is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sphsolid.look.colours import ColourRange, limits
from sphsolid.look.frame import Absent, Frame, HasDiverged, Kept, Shot
from sphsolid.look.panels import PAGE, SIDE, SURFACE, WHOLE, Layout, panel_figure
from sphsolid.look.scalars import CELL
from sphsolid.look.surface import FINEST, Surface, seen_faces
from sphsolid.look.view import Around, View
from studies.engine.results import Results, Tables
from studies.pictures.frame_file import KeptFrames, write_frames
from studies.pictures.shots import ShotFolder

#: The file beside the tables.
FRAMES = "frames.npz"


@dataclass(frozen=True)
class Panel:
    """The frame of the run ``key`` at ``time`` [s] under the heading ``label``.

    Without ``sets_colours`` its values do not count for the range of the colours.
    """

    label: str
    key: str
    time: float
    sets_colours: bool = True


@dataclass(frozen=True)
class Percentile:
    """Colours of the bar up to this percentile by volume (see :func:`colours.limits`)."""

    share: float = 99.0


#: A grid of what is to be shown; all rows have one length.
Plan = Sequence[Sequence[Panel | Absent]]


@dataclass(frozen=True)
class Picture:
    """Panels side by side; ``plan`` says from the tables of a run which frames they show."""

    plan: Callable[[Tables], Plan]
    field: str = CELL + "pressure"
    colours: ColourRange | Percentile = Percentile()
    view: View = SIDE
    window: Around = WHOLE
    drawing: Surface = SURFACE
    layout: Layout = PAGE

    def panels(self, tables: Tables) -> Iterator[Panel]:
        """What is to be shown, without the empty panels."""
        for row in self.plan(tables):
            yield from (panel for panel in row if isinstance(panel, Panel))

    def is_worth_drawing(self, tables: Tables) -> bool:
        """Whether more than half of its panels were run."""
        return 2 * len(list(self.panels(tables))) > sum(map(len, self.plan(tables)))

    def draw(self, results: Results) -> Figure:
        """The figure of a study, from the frames kept beside its tables."""
        return self.figure(KeptFrames(results.out / FRAMES), results.tables)

    def figure(self, frames: KeptFrames | ShotFolder, tables: Tables) -> Figure:
        """The figure; raises ``InputError`` where a frame is missing."""
        plan = self.plan(tables)
        grid = [[_shown(panel, frames) for panel in row] for row in plan]
        colours = self.colours
        if isinstance(colours, Percentile):
            seen = [
                frame
                for panels, row in zip(plan, grid, strict=True)
                for panel, frame in zip(panels, row, strict=True)
                if isinstance(panel, Panel) and panel.sets_colours
            ]
            colours = limits(seen, field=self.field, percentile=colours.share)
        return panel_figure(
            grid, colours=colours, view=self.view, window=self.window, drawing=self.drawing,
            layout=self.layout,
        )  # fmt: skip


def _shown(panel: Panel | Absent, frames: KeptFrames | ShotFolder) -> Frame:
    if isinstance(panel, Absent):
        return panel
    found = frames.load(panel.key, panel.time)
    if isinstance(found, HasDiverged):
        return HasDiverged(panel.label, panel.time, found.diverged_at)
    return found.named(panel.label)


def keep_frames(
    path: Path, folder: ShotFolder, pictures: Sequence[Picture], tables: Tables
) -> None:
    """Keep in ``path`` the frames of ``folder`` that the pictures show.

    Raises ``InputError`` where one is missing; no older file is then left either, since its frames
    do not belong to these tables.
    """
    path.unlink(missing_ok=True)
    wanted: dict[tuple[str, float], list[Picture]] = {}
    for picture in pictures:
        for panel in picture.panels(tables):
            wanted.setdefault((panel.key, panel.time), []).append(picture)
    frames = [(key, _needed(folder.load(key, at), by)) for (key, at), by in wanted.items()]
    if frames:
        write_frames(path, frames)


def _needed(frame: Kept, pictures: Sequence[Picture]) -> Kept:
    if not isinstance(frame, Shot):
        return frame
    nothing, views = np.zeros(len(frame.x)), {p.view for p in pictures}
    faces = [seen_faces(frame, view, nothing, pieces=FINEST).seen for view in views]
    return frame.only(np.any(faces, axis=0), sorted({p.field for p in pictures}))


def keeping(pictures: Sequence[Picture]) -> Callable[[Path, Tables], None]:
    """What a :class:`~studies.engine.study.Study` does at the end of a run: keep their frames."""

    def keep(out: Path, tables: Tables) -> None:
        keep_frames(out / FRAMES, ShotFolder(out / "shots"), pictures, tables)

    return keep
