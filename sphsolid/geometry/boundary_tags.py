"""Names of the parts of a boundary: surface cells and node sets of a file matched with facets."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.cell_shape import CellShape
from sphsolid.geometry.facets import same_vertices
from sphsolid.geometry.file_content import SURFACE_CORNERS, Block
from sphsolid.geometry.mesh_defects import place
from sphsolid.geometry.node_set_faces import NodeSetFaces

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: The tag of whatever part of the boundary has no other: the first of these that is free.
REST = ("boundary", "untagged")


def tagged_faces(
    file: str,
    vertices: Array,
    facets: tuple[Indices, Indices],
    shape: CellShape,
    tags: Mapping[str, tuple[Block, ...]],
    node_sets: Mapping[str, Indices],
) -> dict[str, Indices]:
    """Tag -> outward boundary facets ``(f, m)``; every boundary facet has exactly one tag.

    ``facets``: those of all cells, and how many cells have each.  A surface cell stands for the
    facet of the same vertices.  A node set tags the boundary facets it stands for
    (:class:`~sphsolid.geometry.node_set_faces.NodeSetFaces`), if no surface cell has named them;
    one without such a facet, with a vertex inside the body, or with all vertices of the boundary
    is no part of the boundary and is passed over.
    What is left is tagged ``REST``.  Raises ``InputError`` for a tag without facets, one that is
    not on the boundary, and two that share a facet.
    """
    loops, cells_of = facets
    boundary = loops[cells_of == 1]
    wanted = {name: _loops(file, name, blocks, shape) for name, blocks in tags.items()}
    for name, tagged in wanted.items():
        if len(tagged) == 0:
            used = sorted(other for other, its in wanted.items() if len(its))
            raise InputError(
                f"{file}: tag {name!r} has no facets; tags with facets are {used}. Put its "
                "surfaces into the group and save again (Gmsh: without Mesh.SaveAll, which drops "
                "the groups), or remove the name"
            )
    number = same_vertices(np.concatenate([boundary, loops[cells_of != 1], *wanted.values()]))
    size = int(number.max()) + 1
    kind = np.zeros(size, dtype=np.int8)  # of each facet: 0 no cell's, 1 of the boundary, 2 inside
    kind[number[len(boundary) : len(loops)]] = 2
    kind[number[: len(boundary)]] = 1
    owner = np.full(size, -1)
    names = list(wanted)
    start = len(loops)
    for k, (name, tagged) in enumerate(wanted.items()):
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
        taken = owner[mine] >= 0
        if taken.any():
            first = owner[mine[np.argmax(taken)]]
            shared = owner[mine] == first
            raise _overlap(
                file, names[first], name, int(shared.sum()), vertices[tagged[shared][0]]
            )
        owner[mine] = k
    owners = owner[number[: len(boundary)]]
    _add_node_sets(file, vertices, boundary, node_sets, names, owners)
    faces = {name: boundary[owners == k] for k, name in enumerate(names)}
    if np.any(owners < 0):
        free = [name for name in REST if name not in faces]
        require(
            len(free) > 0,
            f"{file}: part of the boundary has no tag and both {REST} are taken; rename one",
        )
        faces[free[0]] = boundary[owners < 0]
    return faces


def _add_node_sets(
    file: str,
    vertices: Array,
    boundary: Indices,
    node_sets: Mapping[str, Indices],
    names: list[str],
    owners: Indices,
) -> None:
    """Give facets without a tag (``owners`` below zero) to the node sets; extends ``names``."""
    if not node_sets:
        return
    outer = np.zeros(len(vertices), dtype=bool)
    outer[boundary] = True
    all_of_them = int(outer.sum())
    named = owners >= 0
    taken_names = set(names)
    faces = NodeSetFaces(vertices, boundary)
    for name, given in node_sets.items():
        nodes = np.unique(given)
        if name in taken_names or not outer[nodes].all() or len(nodes) == all_of_them:
            continue
        mine = faces.of(nodes)
        mine = mine[~named[mine]]
        if len(mine) == 0:
            continue
        taken = mine[owners[mine] >= 0]
        if len(taken):
            shared = taken[owners[taken] == owners[taken[0]]]
            other = names[owners[taken[0]]]
            raise _overlap(file, other, name, len(shared), vertices[boundary[shared[0]]])
        owners[mine] = len(names)
        names.append(name)
        taken_names.add(name)


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


def _overlap(file: str, one: str, other: str, count: int, corners: Array) -> InputError:
    return InputError(
        f"{file}: tags {one!r} and {other!r} share {count} facets, the first at {place(corners)}; "
        "a facet can have one tag: take it out of one of them, or make a third of what they share"
    )
