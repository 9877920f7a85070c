"""VTU files, read through meshio."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from sphsolid.errors import require
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block, FileContent, Indices
from sphsolid.geometry.meshio_reading import blocks_of, by_number, index, read_guarded
from sphsolid.geometry.unread_features import VTU_REASONS, refuse_vtu_features

#: Arrays that number surfaces; the first of these that a VTU file has is taken before any other.
TAG_ARRAYS = ("gmsh:physical", "tag", "tags", "boundary", "facet", "CellEntityIds", "medit:ref")
#: Integer arrays that never name a part of the boundary.
_NEVER_TAGS = (
    "gmsh:geometrical", "vtkOriginalCellIds", "GlobalIds", "vtkGhostType", "vtkGhostLevels",
)  # fmt: skip
#: Arrays by which VTK marks cells that are there a second time or not at all, what their values
#: other than hidden mean, and the bits of a point that say that it is hidden.
_GHOSTS = (
    ("vtkGhostType", "duplicate, refined or at an inner edge", 2),
    ("vtkGhostLevels", "of another piece", 0),
)


def read_vtu(path: Path) -> FileContent:
    """VTK ``.vtu``: integer arrays on the surface cells are the tags.

    An array of zeros and ones is a tag of the array's name; one with other values numbers tags,
    which are called by their number, where zero and negative are no tag.  Raises ``InputError``
    if several arrays number tags and none has one of the names ``TAG_ARRAYS``.
    """
    data = path.read_bytes()
    require(b"<VTKFile" in data, f"{path} is not a VTK XML file: it has no <VTKFile>")
    require(
        b"</VTKFile>" in data,
        f"{path} is truncated: it does not end with </VTKFile>; copy or save it again",
    )
    refuse_vtu_features(path, data)
    pieces = re.findall(rb"<Piece\b[^>]*>", data)
    # meshio keeps the cells of the last piece and says nothing.
    require(
        len(pieces) <= 1,
        f"{path} has {len(pieces)} pieces; only one can be read: merge them before writing "
        "(ParaView: Merge Blocks)",
    )
    mesh = read_guarded(meshio.vtu.read, path, "VTU", VTU_REASONS)
    polyhedra = sum(len(b.data) for b in mesh.cells if b.type.startswith("polyhedron"))
    require(
        polyhedra == 0,
        f"{path} holds {polyhedra} polyhedra, which are not read: mesh the body with tetrahedra or "
        "hexahedra (ParaView: Tetrahedralize)",
    )
    count = sum(len(block.data) for block in mesh.cells)
    declared = re.search(rb"""NumberOfCells\s*=\s*["']\s*(\d+)""", pieces[0]) if pieces else None
    require(
        declared is None or int(declared.group(1)) == count,
        f"{path} holds cells of kinds that cannot be read (voxels, polyhedra, ...); allowed are "
        f"tetrahedra or hexahedra and their facets",
    )
    _refuse_ghosts(path, mesh)
    tags: dict[str, list[Block]] = {}
    for name, array in _tag_arrays(path, mesh).items():
        for k, block in enumerate(mesh.cells):
            if block.type in SURFACE_CORNERS:
                for number, rows in by_number(array[k]):
                    nodes = index(block.data[rows])
                    tags.setdefault(name or str(number), []).append(Block(block.type, nodes))
    return FileContent(
        mesh.points, blocks_of(mesh), {name: tuple(blocks) for name, blocks in tags.items()}
    )


def _refuse_ghosts(path: Path, mesh: Any) -> None:
    """Raises ``InputError`` for cells or points that the file marks as none of the body."""
    for name, of_cells, of_points in _GHOSTS:
        values = [np.asarray(array).ravel() for array in mesh.cell_data.get(name, [])]
        marked = int(sum(np.count_nonzero(array) for array in values))
        hidden = int(sum(np.count_nonzero(array.astype(np.int64) & 32) for array in values))
        require(
            marked == 0,
            f"{path}: {marked} cells are ghosts by the array {name!r} ({hidden} hidden, the others "
            f"{of_cells}), and a body has none; save the mesh without them (ParaView: Threshold "
            f"on {name} from 0 to 0), or without the array if they are cells of the body",
        )
        points = np.asarray(mesh.point_data.get(name, [])).ravel().astype(np.int64)
        marked = int(np.count_nonzero(points & of_points))
        require(
            marked == 0,
            f"{path}: {marked} points are hidden by the array {name!r}, and the cells around them "
            "with them; save the mesh without these cells, or without the array",
        )


def _tag_arrays(path: Path, mesh: Any) -> dict[str, list[Indices]]:
    """Arrays by the name of their tag; an array that numbers tags under no name."""
    surface = [k for k, block in enumerate(mesh.cells) if block.type in SURFACE_CORNERS]
    numbering, named = [], {}
    for name, array in mesh.cell_data.items():
        values = [array[k] for k in surface]
        if name in _NEVER_TAGS or any(v.ndim != 1 or v.dtype.kind not in "iub" for v in values):
            continue
        found = set(np.concatenate([np.zeros(0, dtype=int), *values]).tolist())
        if found - {0, 1}:
            numbering.append(name)
        elif 1 in found:
            named[name] = array
    chosen = [name for name in TAG_ARRAYS if name in numbering][:1] or numbering
    require(
        len(chosen) <= 1,
        f"{path}: each of the arrays {chosen} may number the tags of the boundary; "
        f"keep one, or name it {TAG_ARRAYS[1]!r}",
    )
    for name in chosen:
        named[""] = mesh.cell_data[name]
    return named
