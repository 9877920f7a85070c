"""Defects of vertices and cells that no particle body can be made with, each said in one line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import HEXAHEDRON, CellShape
from sphsolid.geometry.facets import cell_facets, same_vertices, turns
from sphsolid.geometry.near_contact import NEAR, near_vertices

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Vertices closer than this share of the size of the body are one point given twice.
COINCIDENT = 1.0e-9
#: A cell whose Jacobian is below this share of the cube of its longest extent has no volume.
FLAT = 1.0e-9
#: Local corners of the mirror image of a cell, by its number of corners.
_MIRRORED = {4: [1, 0, 2, 3], 8: [4, 5, 6, 7, 0, 1, 2, 3]}


def place(points: Array) -> str:
    """The mean of some points ``(n, 3)`` [m], for a message."""
    x, y, z = np.asarray(points).reshape(-1, 3).mean(axis=0).tolist()
    return f"X = ({x:.6g}, {y:.6g}, {z:.6g}) m"


def refuse_bad_numbers(file: str, points: Array, cells: Indices) -> None:
    """Raises ``InputError`` for a vertex that does not exist, is used twice, or is not finite."""
    outside = ((cells < 0) | (cells >= len(points))).any(axis=1)
    if outside.any():
        raise InputError(
            f"{file}: {outside.sum()} cells, the first of them number {_first(outside)}, use "
            f"vertices that the file does not define (it has {len(points)}); "
            "the file is damaged: write it again"
        )
    ordered = np.sort(cells, axis=1)
    twice = (np.diff(ordered, axis=1) == 0).any(axis=1)
    if twice.any():
        first = _first(twice)
        raise InputError(
            f"{file}: {twice.sum()} cells, the first of them number {first} at "
            f"{place(points[cells[first]])}, use a vertex twice (a wedge written as a "
            "hexahedron?); only full tetrahedra or hexahedra can be read"
        )
    used = np.unique(cells)
    lost = ~np.isfinite(points[used]).all(axis=1)
    if lost.any():
        vertex = int(used[_first(lost)])
        raise InputError(
            f"{file}: {lost.sum()} vertices, the first of them number {vertex}, have coordinates "
            f"that are not finite: {points[vertex].tolist()}; write the file again"
        )


def refuse_duplicates(file: str, vertices: Array, cells: Indices, shape: CellShape) -> None:
    """Raises ``InputError`` for coincident vertices, or cells of the same vertices.

    Vertices that only round-off keeps apart coincide
    (:mod:`~sphsolid.geometry.near_contact`).
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    pairs = cKDTree(vertices).query_pairs(COINCIDENT * size, output_type="ndarray")
    if len(pairs):
        _refuse_touching(file, vertices, pairs, "lie on the same point")
    near = near_vertices(vertices, cell_facets(cells, shape))
    if len(near.pairs):
        _refuse_touching(
            file, vertices, near.pairs,
            f"lie within {near.gap:.3g} m of each other, less than {NEAR:g} of the edges there",
        )  # fmt: skip
    number = same_vertices(cells)
    if number.max(initial=-1) + 1 < len(cells):
        order = np.argsort(number, kind="stable")
        again = np.flatnonzero(np.diff(number[order]) == 0)
        first = int(order[again].min())
        raise InputError(
            f"{file}: {len(again)} cells are there twice, the first of them number {first} at "
            f"{place(vertices[cells[first]])}; a volume is in two groups, or was meshed twice: "
            "remove the copies"
        )


def _refuse_touching(file: str, vertices: Array, pairs: Indices, how: str) -> None:
    a, b = pairs[np.lexsort(pairs.T[::-1])][0].tolist()
    raise InputError(
        f"{file}: {len(pairs)} pairs of vertices {how}, the first at "
        f"{place(vertices[a])} (vertices {a} and {b}): parts that touch there are not "
        "joined; fragment the geometry before meshing, or merge the vertices (Gmsh: "
        "Coherence Mesh; Abaqus: merge mesh; ParaView: Clean to Grid)"
    )


def right_handed(file: str, vertices: Array, cells: Indices, shape: CellShape) -> Indices:
    """The cells with positive Jacobians, all of them mirrored if the file is left-handed.

    Raises ``InputError`` for flat cells and where only some cells are inverted.
    """
    corners = vertices[cells]
    size = np.ptp(corners, axis=1).max(axis=1)
    jacobian = np.stack(
        [
            np.linalg.det(np.einsum("ecd,ck->edk", corners, point.slopes))
            for point in shape.cell_rule
        ]
    )
    flat = (np.abs(jacobian) <= FLAT * size**3).any(axis=0)
    if flat.any():
        raise InputError(
            f"{file}: {flat.sum()} cells are flat (no volume), the first of them number "
            f"{_first(flat)} at {place(corners[_first(flat)])}; remove them, or mesh again with "
            "optimisation"
        )
    if np.all(jacobian < 0.0):
        return np.asarray(cells[:, _MIRRORED[shape.corners]])
    inverted = (jacobian <= 0.0).any(axis=0)
    if inverted.any():
        first = _first(inverted)
        raise InputError(
            f"{file}: {inverted.sum()} of {len(cells)} cells are inverted, the first of them "
            f"number {first} at {place(corners[first])} (smallest Jacobian "
            f"{jacobian[:, first].min():.3g} m^3); mesh again, or turn these cells round"
        )
    return cells


def boundary_facets(
    file: str, vertices: Array, cells: Indices, shape: CellShape
) -> tuple[Indices, Indices]:
    """All facets ``(C n, m)``, outward, and how many cells have each ``(C n,)``: 1 or 2.

    Raises ``InputError`` for a facet of more than two cells, of two cells on the same side of it,
    or of two hexahedra that join its vertices in different orders.
    """
    facets = cell_facets(cells, shape)
    number = same_vertices(facets)
    cells_of = np.bincount(number)[number]
    if cells_of.max() > 2:
        first = _first(cells_of > 2)
        raise InputError(
            f"{file}: {len(np.unique(number[cells_of > 2]))} facets belong to more than two "
            f"cells, the first at {place(vertices[facets[first]])} to {cells_of[first]}; cells "
            "overlap there: mesh the body again"
        )
    order = np.argsort(number, kind="stable")
    shared = order[cells_of[order] == 2].reshape(-1, 2)
    (sense, opposite), (other, its) = (turns(facets[side]) for side in shared.T)
    wrong = (sense == other) | (opposite != its)
    if wrong.any():
        a, b = (shared[_first(wrong)] // len(shape.facets)).tolist()
        what = (
            "hexahedra that do not agree on the edges of a facet"
            if shape is HEXAHEDRON and (opposite != its)[_first(wrong)]
            else "cells on the same side of their common facet: they overlap"
        )
        raise InputError(
            f"{file}: {wrong.sum()} pairs of {what}; the first are cells {a} and {b} at "
            f"{place(vertices[facets[shared[_first(wrong)]]])}; mesh the body again"
        )
    return facets, cells_of


def _first(mask: np.bool_ | NDArray[np.bool_]) -> int:
    return int(np.argmax(mask))
