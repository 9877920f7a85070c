"""Names of the parts of a boundary: surface cells and sets of a file matched with facets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.cell_shape import CellShape
from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block, NamedSet
from sphsolid.geometry.mesh_defects import place
from sphsolid.geometry.named_sets import Owners

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: The tag of whatever part of the boundary has no other: the first of these that is free.
REST = ("boundary", "untagged")


@dataclass(frozen=True)
class Tags:
    """``faces``: tag -> facets ``(f, m)``; ``unusable``: name that is no tag -> why not.

    ``notes``: what a user should hear of the names that are no tags.
    """

    faces: dict[str, Indices]
    unusable: dict[str, str]
    notes: tuple[str, ...]


def tagged_faces(
    file: str,
    vertices: Array,
    facets: tuple[Indices, Indices],
    shape: CellShape,
    tags: Mapping[str, tuple[Block, ...]],
    sets: Sequence[NamedSet] = (),
) -> Tags:
    """Tag -> outward boundary facets ``(f, m)``; every boundary facet has exactly one tag.

    ``facets``: those of all cells, and how many cells have each.  A surface cell stands for the
    facet of the same vertices.  Of ``sets`` that overlap some become tags
    (:class:`~sphsolid.geometry.named_sets.Owners`).  What is left is tagged ``REST``.  Raises
    ``InputError`` for facets that are none of the boundary, a name without facets, and two
    ``tags`` that share a facet.
    """
    loops, cells_of = facets
    boundary = loops[cells_of == 1]
    of_facets = [each for each in sets if each.points is None]
    names = [*tags, *(each.name for each in of_facets)]
    blocks = [*tags.values(), *(each.facets for each in of_facets)]
    wanted = [_loops(file, name, its, shape) for name, its in zip(names, blocks, strict=True)]
    rows = _rows(file, vertices, facets, names, wanted)
    owners = Owners(file, vertices, boundary)
    for name, mine in zip(tags, rows, strict=False):
        if len(shared := owners.shared_with(mine)):
            other = owners.names[owners.of[shared[0]]]
            raise InputError(
                f"{file}: tags {other!r} and {name!r} share {len(shared)} facets, the first at "
                f"{place(vertices[boundary[shared[0]]])}; a facet can have one tag: take it out of "
                "one of them, or make a third of what they share"
            )
        owners.give(name, mine)
    owners.settle(sets, dict(zip(map(id, of_facets), rows[len(tags) :], strict=True)))
    faces = owners.faces()
    if np.any(owners.of < 0):
        free = [name for name in REST if name not in faces and name not in owners.unusable]
        require(
            len(free) > 0,
            f"{file}: part of the boundary has no tag and both {REST} are taken; rename one",
        )
        faces[free[0]] = boundary[owners.of < 0]
    return Tags(faces, owners.unusable, owners.notes())


def _rows(
    file: str,
    vertices: Array,
    facets: tuple[Indices, Indices],
    names: list[str],
    wanted: list[Indices],
) -> list[Indices]:
    """Where the facets of each name stand in the boundary."""
    for name, tagged in zip(names, wanted, strict=True):
        if len(tagged) == 0:
            used = sorted(other for other, its in zip(names, wanted, strict=True) if len(its))
            raise InputError(
                f"{file}: tag {name!r} has no facets; tags with facets are {used}. Put its "
                "surfaces into the group and save again (Gmsh: without Mesh.SaveAll, which drops "
                "the groups), or remove the name"
            )
    loops, cells_of = facets
    boundary = loops[cells_of == 1]
    number = same_vertices(np.concatenate([boundary, loops[cells_of != 1], *wanted]))
    size = int(number.max()) + 1
    kind = np.zeros(size, dtype=np.int8)  # of each facet: 0 no cell's, 1 of the boundary, 2 inside
    kind[number[len(boundary) : len(loops)]] = 2
    kind[number[: len(boundary)]] = 1
    row = np.full(size, -1)
    row[number[: len(boundary)]] = np.arange(len(boundary))
    found = []
    start = len(loops)
    for name, tagged in zip(names, wanted, strict=True):
        mine = number[start : start + len(tagged)]
        start += len(tagged)
        if np.any(kind[mine] != 1):
            first = int(np.argmax(kind[mine] != 1))
            inside = int((kind[mine] == 2).sum())
            corners = tagged[first][tagged[first] >= 0]
            where = f", the first at {place(vertices[corners])}" if len(corners) else ""
            raise InputError(
                f"{file}: tag {name!r}: {(kind[mine] != 1).sum()} of its {len(tagged)} facets are "
                f"not on the boundary of the body ({inside} lie between two cells, "
                f"{len(tagged) - inside - (kind[mine] == 1).sum()} are no facet of any){where}; "
                f"the tags are {sorted(names)}. Keep only surfaces of the outside in it"
            )
        found.append(row[mine])
    return found


def _loops(file: str, name: str, blocks: tuple[Block, ...], shape: CellShape) -> Indices:
    """The surface cells of a tag, each once."""
    size = shape.facets.shape[1]
    for block in blocks:
        require(
            SURFACE_CORNERS[block.kind] == size,
            f"{file}: tag {name!r} has {len(block.nodes)} cells of kind {block.kind} and the body "
            f"is made of cells of kind {shape.name}, whose facets are of kind {shape.vtk_facet}; "
            "mesh surfaces and body together",
        )
    rows = np.concatenate([np.zeros((0, size), np.int64), *(block.corners for block in blocks)])
    _, first = np.unique(same_vertices(rows), return_index=True)
    return np.asarray(rows[np.sort(first)])
