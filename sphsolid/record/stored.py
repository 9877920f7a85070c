"""What a run's folder holds, read back: frames as snapshots that can be looked at."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.cell_shape import HEXAHEDRON, TETRAHEDRON
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh
from sphsolid.geometry.mesh_defects import boundary_facets
from sphsolid.paths import path_of
from sphsolid.record.placement import (
    NO_SECONDARY_GRADIENT,
    NoSecondaryGradient,
    SecondaryGradient,
)
from sphsolid.record.showing import look
from sphsolid.record.snapshot import PointField, at_vertices
from sphsolid.record.vtu import LAW_FIELDS, POINT_FIELDS

Array = NDArray[np.float64]
_SHAPES = {HEXAHEDRON.vtk: (HexMesh, HEXAHEDRON), TETRAHEDRON.vtk: (TetMesh, TETRAHEDRON)}
#: What every frame has; other fields are those of a user's own terms.
_USUAL = ("X", *POINT_FIELDS, *LAW_FIELDS)


@dataclass(frozen=True)
class StoredSnapshot:
    """A frame of a run's folder: positions in double precision, fields in single.

    ``X, x (N, 3)`` [m] at the vertices of ``mesh``, ``V (N,)`` [m^3] shares of its cells;
    ``points`` and ``cells`` are the fields of the file by name, at vertices and in cells.
    """

    time: float
    step: int
    mesh: Mesh
    x: Array
    V: Array
    cell_X: Array
    cell_V: Array
    points: dict[str, Array] = field(repr=False)
    cells: dict[str, Array] = field(repr=False)
    secondary: SecondaryGradient | NoSecondaryGradient = NO_SECONDARY_GRADIENT

    @property
    def X(self) -> Array:
        """Positions ``(N, 3)`` [m] of the undeformed body."""
        return self.mesh.vertices

    @property
    def further(self) -> dict[str, Array]:
        """Fields of a user's own terms ``(N, ...)``, by name."""
        return {name: each for name, each in self.points.items() if name not in _USUAL}

    def field(self, name: str) -> PointField:
        """A field of the file and its points; raises ``InputError`` for one that it lacks."""
        if name in self.points:
            return PointField(self.X, self.V, self.points[name])
        if name in self.cells:
            return PointField(self.cell_X, self.cell_V, self.cells[name])
        raise InputError(
            f"the frame has no field {name!r}; it has {', '.join([*self.points, *self.cells])}"
        )

    def at_vertices(self, name: str) -> Array:
        """A field at the primary points ``(N, ...)``; cell values are averaged by volume."""
        return at_vertices(self, name)

    def picture(self, field: str = "pressure", **options: Any) -> Any:
        """The deformed body in colour; see :meth:`~sphsolid.record.snapshot.Snapshot.picture`."""
        return look().picture(self, field, options)


def frame_files(folder: str | Path) -> list[tuple[float, Path]]:
    """Times [s] and files of the frames of a run's folder, by its collection.

    Raises ``InputError`` for a folder without frames.
    """
    place = path_of(folder)
    collection = place / "frames.pvd"
    require(place.is_dir(), f"there is no folder {place}")
    require(
        collection.is_file(),
        f"{place} has no frames to look at (there is no frames.pvd): run with "
        "output=RunFolder(...) and frames left on",
    )
    try:
        root = ElementTree.parse(collection).getroot()
        return [
            (float(each.attrib["timestep"]), place / each.attrib["file"])
            for each in root.iter("DataSet")
        ]
    except (ElementTree.ParseError, KeyError, ValueError) as damage:
        raise InputError(f"{collection} is not a collection of frames: {damage}") from damage


def read_frame(path: str | Path) -> StoredSnapshot:
    """A ``.vtu`` file that :func:`~sphsolid.record.vtu.write_vtu` made."""
    file = path_of(path)
    require(file.is_file(), f"there is no frame {file}")
    try:
        found = meshio.read(file, file_format="vtu")
        [block] = found.cells
        kind, shape = _SHAPES[block.type]
        X = np.asarray(found.point_data["X"], dtype=np.float64)
        time = float(found.field_data["TimeValue"][0])
        step = int(found.field_data["step"][0])
    except Exception as damage:
        raise InputError(f"{file} is no frame of a run, or is damaged: {damage!r}") from damage
    cells = np.asarray(block.data, dtype=np.int64)
    bare = kind(X, cells, {}, 1.0, is_lattice=False)
    V, centres = cell_volumes_and_centroids(bare)
    # The distance of vertices that fill the same volume.
    spacing = float(np.cbrt(np.sum(V) / max(1, len(X))))
    facets, cells_of = boundary_facets(str(file), X, cells, shape)
    mesh = kind(X, cells, {"boundary": facets[cells_of == 1]}, spacing, is_lattice=False)
    corners = cells.shape[1]
    return StoredSnapshot(
        time=time,
        step=step,
        mesh=mesh,
        x=np.asarray(found.points, dtype=np.float64),
        V=np.asarray(
            np.bincount(cells.ravel(), np.repeat(V / corners, corners), len(X)), dtype=np.float64
        ),
        cell_X=centres,
        cell_V=V,
        points={name: _shaped(each) for name, each in found.point_data.items()},
        cells={name: _shaped(each[0]) for name, each in found.cell_data.items()},
    )


def _shaped(values: Any) -> Array:
    made = np.asarray(values, dtype=np.float64)
    return made.reshape(-1, 3, 3) if made.ndim == 2 and made.shape[1] == 9 else made
