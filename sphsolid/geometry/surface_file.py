"""Facets and their names out of a surface file, as they stand there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.closed_surface import halves
from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.file_content import SURFACE_CORNERS, FileContent
from sphsolid.geometry.gmsh_reading import read_gmsh
from sphsolid.geometry.meshio_reading import read_guarded
from sphsolid.geometry.obj_reading import read_obj
from sphsolid.geometry.stl_reading import read_stl
from sphsolid.geometry.vtu_reading import read_vtu

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Tag of the triangles that have no name.
UNNAMED = "surface"
#: STL repeats each vertex in every triangle, rounded to single precision.
_STL_MERGE = 1.0e-6
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
    if kind not in _READERS:
        raise InputError(
            f"{path} is of kind {kind or 'unknown'}; a surface is read from "
            f"{', '.join(sorted({*_READERS, *_TAGGED}))}"
        )
    points, named = _READERS[kind](path)
    require(
        sum(len(loops) for loops in named.values()) > 0,
        f"{path} holds no triangles; save the surface as a mesh of triangles",
    )
    return Facets(points, named, _STL_MERGE if kind == ".stl" else 0.0)


def _stl(path: Path) -> tuple[Array, dict[str, Indices]]:
    """The names of several solids are those of the faces; one alone names nothing."""
    solids = read_stl(path)
    named: dict[str, list[Indices]] = {}
    start = 0
    for name, corners in solids:
        rows = start + np.arange(3 * len(corners), dtype=np.int64).reshape(-1, 3)
        start += 3 * len(corners)
        named.setdefault(name if len(solids) > 1 and name else UNNAMED, []).append(rows)
    points = np.concatenate([np.zeros((0, 3)), *(corners.reshape(-1, 3) for _, corners in solids)])
    return points, {name: np.concatenate(rows) for name, rows in named.items()}


def _obj(path: Path) -> tuple[Array, dict[str, Indices]]:
    points, loops = read_obj(path)
    return points, {UNNAMED: np.concatenate([halves(rows) for rows in loops])}


def _ply(path: Path) -> tuple[Array, dict[str, Indices]]:
    require(
        not path.read_bytes().startswith((b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff")),
        f"{path} begins with a byte order mark, which is not read; save it without (as ASCII)",
    )
    mesh = read_guarded(meshio.ply.read, path, "PLY")
    blocks = [block for block in mesh.cells if len(block.data)]
    strange = sorted({block.type for block in blocks} - {"triangle", "quad"})
    require(
        not strange,
        f"{path} holds facets of kind {', '.join(strange)}; save the surface with triangles only",
    )
    loops = [halves(np.asarray(block.data)) for block in blocks]
    points = np.asarray(mesh.points, dtype=np.float64)
    require(
        points.ndim == 2 and points.shape[1] == 3,
        f"{path} has vertices of {points.shape[1:]} coordinates; three are wanted",
    )
    return points, {UNNAMED: np.concatenate([np.zeros((0, 3), np.int64), *loops])}


_READERS: dict[str, Callable[[Path], tuple[Array, dict[str, Indices]]]] = {
    ".stl": _stl,
    ".ply": _ply,
    ".obj": _obj,
}


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
