"""Bodies from mesh files: Gmsh ``.msh``, VTK ``.vtu``, Abaqus ``.inp``."""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.abaqus_reading import read_abaqus
from sphsolid.geometry.body import AsMeshed, Spacing
from sphsolid.geometry.boundary_tags import tagged_faces
from sphsolid.geometry.cell_shape import HEXAHEDRON, CellShape
from sphsolid.geometry.file_content import (
    BODY_CELLS,
    LINES_AND_POINTS,
    SURFACE_CORNERS,
    Block,
    FileContent,
)
from sphsolid.geometry.gmsh_reading import read_gmsh
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import HexMesh, TetMesh, copied
from sphsolid.geometry.mesh_defects import (
    boundary_facets,
    refuse_bad_numbers,
    refuse_duplicates,
    right_handed,
)
from sphsolid.geometry.overlap import refuse_overlap
from sphsolid.geometry.units import Unit, metres
from sphsolid.geometry.vtu_reading import read_vtu
from sphsolid.paths import path_of

Indices = NDArray[np.int64]

READERS: dict[str, Callable[[Path], FileContent]] = {
    ".msh": read_gmsh,
    ".vtu": read_vtu,
    ".inp": read_abaqus,
}


@dataclass(frozen=True)
class Reading:
    """A mesh, and what of its file is not in it.

    ``unused_vertices`` belong to no cell of the body, ``midside_vertices`` to second-order cells
    of which only the corners are taken.  ``left_handed``: the cells of the file were inverted,
    all of them, and have been mirrored.  ``notes``: what else of the file is not read.
    """

    mesh: HexMesh | TetMesh
    unused_vertices: int
    midside_vertices: int
    left_handed: bool
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class MeshFile:
    """A body as meshed in a file: its vertices are the particles.

    ``path``: Gmsh ``.msh`` (2.2 or 4.1, text or binary), VTK ``.vtu`` or Abaqus ``.inp``, with
    tetrahedra or hexahedra, one kind.  Of second-order cells the corners are taken, so that a
    curved edge becomes a straight one.  ``unit``: what a coordinate of one means, one of
    :data:`~sphsolid.geometry.units.UNITS` or metres as a number.

    Tags of the boundary are

    * the physical surfaces of Gmsh;
    * the integer arrays on the surface cells of a VTU file
      (:func:`~sphsolid.geometry.vtu_reading.read_vtu`);
    * the surfaces, element sets and node sets of Abaqus
      (:func:`~sphsolid.geometry.abaqus_reading.read_abaqus`).

    Facets without a tag are tagged ``boundary``.  Tags may not overlap.  Of overlapping sets of
    Abaqus one is a tag, and the others are refused when they are asked for
    (:mod:`~sphsolid.geometry.named_sets`).
    """

    path: str | Path
    unit: Unit = "m"

    def __post_init__(self) -> None:
        """Refuse an unknown unit or file name extension."""
        require(
            path_of(self.path).suffix.lower() in READERS,
            f"mesh file {self.path}: allowed extensions are {sorted(READERS)}; convert it "
            "(gmsh FILE -save -o NAME.msh, meshio convert)",
        )
        metres(self.unit, f"mesh file {self.path}")

    @property
    def metres(self) -> float:
        """Metres to a unit of the file."""
        return metres(self.unit, f"mesh file {self.path}")

    def read(self) -> Reading:
        """The mesh and what was left out of it; raises ``InputError`` for any defect.

        Warns of what the file says of the body beside its mesh, and is not read.
        """
        path = path_of(self.path)
        require(path.exists(), f"mesh file {path} does not exist (looked in {path.absolute()})")
        require(path.is_file(), f"mesh file {path} is not a file")
        stamp = path.stat()
        kept = _read(path, self.metres, stamp.st_mtime_ns, stamp.st_size)
        # What is kept is read again by the next simulation, so nobody else may write to it.
        return replace(kept, mesh=copied(kept.mesh))

    def mesh(self, spacing: Spacing) -> HexMesh | TetMesh:
        """The mesh of the file; raises ``InputError`` for a spacing, which the file has itself.

        Its nominal spacing is the edge of a cube of the mean volume of its hexahedra, or of six
        of its tetrahedra; see also :func:`~sphsolid.geometry.integrals.local_spacing`.
        """
        if not isinstance(spacing, AsMeshed):
            raise InputError(
                f"spacing = {spacing} m was given and the mesh file {self.path} has its own; leave "
                "the spacing out, or mesh the body anew at that size"
            )
        return self.read().mesh

    @property
    def volume(self) -> float:
        """Volume of the cells [m^3]."""
        return math.fsum(cell_volumes_and_centroids(self.read().mesh)[0])


# A simulation asks for the mesh, its volume and the plan one after the other.
@functools.lru_cache(maxsize=2)
def _read(path: Path, metres: float, modified: int, size: int) -> Reading:
    require(size > 0, f"{path} is empty")
    found = reading(str(path), READERS[path.suffix.lower()](path), metres)
    for note in found.notes:
        warnings.warn(note, stacklevel=4)
    return found


def reading(file: str, content: FileContent, metres: float) -> Reading:
    """The mesh of what a file says; raises ``InputError`` for any defect, naming ``file``."""
    points = content.points
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{file}: points have {points.shape[1:]} coordinates; allowed are three")
    points = metres * points.astype(float)
    shape, blocks = _body(file, content)
    cells = np.concatenate([block.nodes[:, : shape.corners] for block in blocks])
    refuse_bad_numbers(file, points, cells)

    used = np.unique(cells)
    in_cells = np.unique(np.concatenate([block.nodes.ravel() for block in blocks]))
    renumber = np.full(len(points) + 1, -1)
    renumber[used] = np.arange(len(used))
    vertices, given = points[used], renumber[cells]
    refuse_duplicates(file, vertices, given, shape)
    cells = right_handed(file, vertices, given, shape)
    tags = tagged_faces(
        file,
        vertices,
        boundary_facets(file, vertices, cells, shape),
        shape,
        {name: _of_body(blocks, renumber) for name, blocks in content.tags.items()},
        [
            replace(
                each,
                facets=_of_body(each.facets, renumber),
                points=None if each.points is None else _kept(renumber[each.points]),
            )
            for each in content.sets
        ],
    )
    kind = HexMesh if shape is HEXAHEDRON else TetMesh
    cube = 1.0 if shape is HEXAHEDRON else 6.0
    mesh = kind(vertices, cells, tags.faces, 1.0, is_lattice=False, unusable=tags.unusable)
    refuse_overlap(file, mesh)
    volume = math.fsum(cell_volumes_and_centroids(mesh)[0])
    return Reading(
        replace(mesh, spacing=math.cbrt(cube * volume / len(cells))),
        unused_vertices=len(points) - len(in_cells),
        midside_vertices=len(in_cells) - len(used),
        left_handed=cells is not given,
        notes=(*content.notes, *tags.notes),
    )


def _body(file: str, content: FileContent) -> tuple[CellShape, list[Block]]:
    """The shape of the cells of the body, and their blocks."""
    filled = [block for block in content.cells if len(block.nodes)]
    known = (*BODY_CELLS, *SURFACE_CORNERS, *LINES_AND_POINTS)
    strange = sorted({block.kind for block in filled} - set(known))
    require(
        not strange,
        f"{file} holds cells of kind {', '.join(strange)} (in all: {content.kinds()}); allowed "
        "are tetrahedra or hexahedra of first or second order: mesh again with one of them",
    )
    blocks = [block for block in filled if block.kind in BODY_CELLS]
    require(
        len(blocks) > 0,
        f"{file} has no cells of a volume ({content.kinds()}): {content.way_out}",
    )
    shapes = [BODY_CELLS[block.kind] for block in blocks]
    require(
        all(shape is shapes[0] for shape in shapes),
        f"{file} mixes tetrahedra and hexahedra ({content.kinds()}); allowed is one kind",
    )
    return shapes[0], blocks


def _of_body(blocks: tuple[Block, ...], renumber: Indices) -> tuple[Block, ...]:
    """Surface cells by vertices of the body; a vertex that is none of the body becomes -1."""
    last = len(renumber) - 1
    return tuple(
        Block(
            block.kind,
            renumber[np.where((block.nodes >= 0) & (block.nodes < last), block.nodes, last)],
        )
        for block in blocks
    )


def _kept(nodes: Indices) -> Indices:
    return np.asarray(nodes[nodes >= 0])
