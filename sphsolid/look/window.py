"""The frames of a run in a window of pyvista, with a slider over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from sphsolid.errors import require
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.look.doors import installed
from sphsolid.look.scalars import values_at_vertices
from sphsolid.paths import path_of
from sphsolid.record.stored import StoredSnapshot, frame_files, read_frame

_VTK_HEXAHEDRON, _VTK_TETRA = 12, 10


def require_pyvista(what: str) -> None:
    """Raises ``InputError`` saying what to install where pyvista is not."""
    require(
        installed("pyvista"),
        f"{what} needs pyvista, which is not installed: pip install 'sphsolid[render]'",
    )


def grid_of(snapshot: StoredSnapshot, field: str) -> Any:
    """The deformed body as an unstructured grid of pyvista, with ``field`` at its points."""
    import pyvista

    cells = snapshot.mesh.cells
    kind = _VTK_HEXAHEDRON if snapshot.mesh.shape is HEXAHEDRON else _VTK_TETRA
    grid = pyvista.UnstructuredGrid({kind: cells}, np.asarray(snapshot.x))
    grid.point_data[field] = values_at_vertices(snapshot, field)
    return grid


def show_window(folder: str | Path, *, field: str = "pressure") -> None:
    """Open a window on the frames of a run's folder; raises ``InputError`` without pyvista."""
    require_pyvista("a window")
    import pyvista

    frames = [read_frame(file) for _, file in frame_files(path_of(folder))]
    require(len(frames) > 0, f"{folder} has no frames yet")
    grids = [grid_of(frame, field) for frame in frames]
    values = np.concatenate([grid.point_data[field] for grid in grids])
    ends = [float(np.percentile(values, share)) for share in (1.0, 99.0)]
    plotter = pyvista.Plotter()

    def show(value: float) -> None:
        k = round(value)
        plotter.add_mesh(grids[k], scalars=field, clim=ends, show_edges=True, name="body")
        plotter.add_text(f"t = {frames[k].time:.4g} s", name="time", font_size=10)

    show(len(grids) - 1)
    if len(grids) > 1:
        plotter.add_slider_widget(show, [0, len(grids) - 1], value=len(grids) - 1, title="record")
    plotter.show()
