"""Snapshots as VTU files, runs as PVD collections: what ParaView and meshio read."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.paths import path_of
from sphsolid.record.atomic import atomic
from sphsolid.record.snapshot import Snapshot

#: Fields of a file; ``X`` lets a reader go back to the undeformed body.
POINT_FIELDS = ("u", "v", "p")
LAW_FIELDS = ("F", "J", "P", "cauchy", "pressure", "von_mises")
_GRID = b"<UnstructuredGrid>"


def write_vtu(snapshot: Snapshot, path: str | Path) -> None:
    """Write the background mesh at its present positions with all fields.

    Positions, now and in the reference, are written in double precision: in single precision those
    of a small body far from the origin would fall together.  All other fields are single.
    Points: ``X, u`` [m], ``v`` [m/s], ``p`` [kg/(m^2 s)], three components each.  ``F``, ``P`` and
    ``cauchy`` [Pa] (nine components, row by row), ``J``, ``pressure`` and ``von_mises`` [Pa] stand
    where the method evaluates the law: at the points for particles, in the cells for finite
    elements.  Fields of a user's own terms stand at the points.  Field data ``TimeValue`` [s],
    ``step`` and ``pressure_is_positive_in_tension``, 1: the sign of ``pressure``, for whoever has
    only the file.  The file is whole or not there; an older one is replaced.  Raises
    ``InputError`` for another suffix than ``.vtu`` or a folder that does not exist.
    """
    target = path_of(path)
    if target.suffix != ".vtu":
        raise InputError(f"{target.name!r} does not end in .vtu, the one format that is written")
    if not target.parent.is_dir():
        raise InputError(f"cannot write {target}: the folder {target.parent} does not exist")
    points = {name: snapshot.field(name).values for name in POINT_FIELDS}
    law = {name: snapshot.field(name).values for name in LAW_FIELDS}
    at_points = snapshot.field(LAW_FIELDS[0]).is_at(snapshot.X)
    if at_points:
        points |= law
    points |= snapshot.further
    mesh = meshio.Mesh(
        np.ascontiguousarray(snapshot.x),
        # meshio and VTK number the corners of a cell as ``cell_shape`` does.
        [(snapshot.mesh.shape.vtk, snapshot.mesh.cells)],
        point_data={"X": np.ascontiguousarray(snapshot.X)}
        | {name: _single(values) for name, values in points.items()},
        cell_data={} if at_points else {name: [_single(values)] for name, values in law.items()},
    )
    with atomic(target) as part:
        # zlib would save 40 % of the file and take six times as long: ten steps of a large run.
        meshio.write(part, mesh, file_format="vtu", compression=None)
        text = part.read_bytes()
        part.write_bytes(text.replace(_GRID, _GRID + _field_data(snapshot), 1))


def write_pvd(frames: list[tuple[float, str]], path: Path) -> None:
    """Write a collection of ``(time [s], file relative to the collection)``."""
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="0.1">',
        "  <Collection>",
        *(
            f'    <DataSet timestep="{float(time)!r}" group="" part="0" file={quoteattr(name)}/>'
            for time, name in frames
        ),
        "  </Collection>",
        "</VTKFile>",
    ]
    with atomic(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _single(values: NDArray[np.float64]) -> NDArray[np.float32]:
    flat = values.reshape(len(values), -1) if values.ndim > 1 else values
    # A field on its way to divergence may exceed single precision: infinite there, no warning.
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(flat, dtype=np.float32)


def _field_data(snapshot: Snapshot) -> bytes:
    """ParaView takes the time of a file from ``TimeValue``; meshio reads it but writes none."""

    def array(name: str, kind: str, value: str) -> str:
        return (
            f'<DataArray type="{kind}" Name="{name}" NumberOfTuples="1" format="ascii">'
            f"{value}</DataArray>"
        )

    time = array("TimeValue", "Float64", repr(float(snapshot.time)))
    step = array("step", "Int64", str(int(snapshot.step)))
    sign = array("pressure_is_positive_in_tension", "Int64", "1")
    return f"<FieldData>{time}{step}{sign}</FieldData>".encode()
