"""``sphsolid view``: what a run's folder shows, as files, or in a window where pyvista is."""

from __future__ import annotations

from pathlib import Path

from sphsolid.errors import require
from sphsolid.look import animate
from sphsolid.look.doors import require_matplotlib
from sphsolid.look.window import show_window
from sphsolid.record import read_history, read_run
from sphsolid.record.stored import frame_files, read_frame


def view(folder: Path, *, field: str, window: bool) -> list[str]:
    """Lines to print; the pictures are written beside the run."""
    about = read_run(folder)
    lines = [
        f"{about['name']}: {about['status']}, t = {about.get('time_s', 0.0):.4g} of "
        f"{about['until_s']:.4g} s, {about.get('step', 0)} steps",
        f"positions: {about.get('positions', {}).get('verdict', 'not judged yet')}",
    ]
    if window:
        show_window(folder, field=field)
        return lines
    require_matplotlib("sphsolid view")
    frames = frame_files(folder) if (folder / "frames.pvd").is_file() else []
    made = []
    if frames:
        read_frame(frames[-1][1]).picture(field, path=folder / f"{field}.png")
        made.append(f"{field}.png")
    history = folder / "history.csv"
    if history.is_file():
        found = read_history(history)
        if len(found.table.columns) > 2 and len(found.table) > 1:
            found.plot().save(folder / "history.png")
            made.append("history.png")
    if len(frames) > 1:
        made.append(animate(folder, field=field).path.name)
    require(len(made) > 0, f"{folder} has neither frames nor two records: nothing to look at")
    return [*lines, f"wrote {', '.join(made)} to {folder}"]
