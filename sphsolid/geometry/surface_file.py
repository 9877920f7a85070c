"""Facets and their names out of a surface file, as they stand there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.closed_surface import halves
from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.file_content import SURFACE_CORNERS, FileContent
from sphsolid.geometry.meshio_reading import read_gmsh, read_guarded, read_vtu

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Tag of the triangles that have no name.
UNNAMED = "surface"
#: STL repeats each vertex in every triangle, rounded to single precision.
_STL_MERGE = 1.0e-6
_PLAIN = {".stl": meshio.stl.read, ".ply": meshio.ply.read, ".obj": meshio.obj.read}
_TAGGED = {".msh": read_gmsh, ".vtu": read_vtu}


@dataclass(frozen=True)
class Facets:
    """``points (n, 3)`` in units of the file; ``faces`` name -> ``(f, 3)`` or ``(f, 4)``.

    ``merge``: how close two vertices are one, over the size of the surface.
    """

    points: Array
    faces: dict[str, Indices]
    merge: float


def read_facets(path: Path) -> Facets:
    """Triangles and quadrilaterals of ``.stl``, ``.ply``, ``.obj``, ``.msh``, ``.vtu``.

    Raises ``InputError`` for a file that is missing, of another kind, cannot be read, or holds no
    facets, second-order ones or one facet under two names.
    """
    require(path.is_file(), f"{path}: there is no such file")
    kind = path.suffix.lower()
    if kind in _TAGGED:
        return _with_names(path, _TAGGED[kind](path))
    if kind not in _PLAIN:
        raise InputError(
            f"{path} is of kind {kind or 'unknown'}; a surface is read from "
            f"{', '.join(sorted({*_PLAIN, *_TAGGED}))}"
        )
    mesh = read_guarded(_PLAIN[kind], path, kind[1:].upper())
    loops = [np.asarray(b.data) for b in mesh.cells if b.type in ("triangle", "quad")]
    require(
        sum(len(loop) for loop in loops) > 0,
        f"{path} holds no triangles; save the surface as a mesh of triangles",
    )
    return Facets(
        np.asarray(mesh.points, dtype=np.float64).reshape(-1, 3),
        {UNNAMED: np.concatenate([halves(loop) for loop in loops])},
        _STL_MERGE if kind == ".stl" else 0.0,
    )


def _with_names(path: Path, content: FileContent) -> Facets:
    blocks = [block for block in content.cells if block.kind in SURFACE_CORNERS]
    require(
        sum(len(block.nodes) for block in blocks) > 0,
        f"{path} holds no surface, only {content.kinds()}; save the triangles of the boundary too",
    )
    triangles = np.concatenate([halves(block.corners) for block in blocks])
    number = same_vertices(triangles)
    # Gmsh 2.2 repeats a facet in each of its groups.
    _, first = np.unique(number, return_index=True)
    triangles = triangles[np.sort(first)]
    faces: dict[str, Indices] = {}
    free = np.ones(len(triangles), dtype=bool)
    for name, parts in content.tags.items():
        require(
            sum(len(block.nodes) for block in parts) > 0,
            f"{path}: the surface {name!r} is declared and has no facets; remove it, or mesh it",
        )
        named = np.concatenate([halves(block.corners) for block in parts])
        number = same_vertices(np.concatenate([triangles, named]))
        member = np.isin(number[: len(triangles)], number[len(triangles) :])
        require(
            bool(np.all(free[member])),
            f"{path}: {np.sum(~free[member])} facets of {name!r} belong to another name too; give "
            "each facet one name",
        )
        faces[name] = triangles[member]
        free &= ~member
    if np.any(free):
        faces[UNNAMED] = np.concatenate([faces.get(UNNAMED, triangles[:0]), triangles[free]])
    return Facets(content.points, faces, 0.0)
