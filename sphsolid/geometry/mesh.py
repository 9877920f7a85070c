"""Meshes as plain arrays: what both solvers discretise a body with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import HEXAHEDRON, TETRAHEDRON, CellShape

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
AnyMesh = TypeVar("AnyMesh", bound="Mesh")


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A view of ``array`` through which nobody writes."""
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True)
class Mesh:
    """Vertices, cells of one shape and tagged outward boundary facets.

    ``vertices (N, 3)`` [m]; ``cells (C, k)`` in the corner order of ``shape``; ``faces`` name ->
    ``(f, m)`` vertex loops, counter-clockwise seen from outside; ``spacing`` [m] the nominal
    distance of neighbouring vertices; ``is_lattice`` True when the vertices sit on a regular
    axis-aligned grid of that spacing (per axis up to rounding to whole cells), those of separate
    parts perhaps each on its own.  ``unusable``: names of a mesh file that are no tag -> why, in
    the words of the refusal.
    """

    vertices: Array
    cells: Indices
    faces: dict[str, Indices]
    spacing: float
    is_lattice: bool
    unusable: dict[str, str] = field(default_factory=dict, kw_only=True)

    @property
    def shape(self) -> CellShape:
        """Shape of the cells."""
        raise NotImplementedError

    @property
    def widest(self) -> float:
        """Length [m] that a support of one size counts: ``spacing`` unless a mesh knows better."""
        return self.spacing

    def face(self, name: str) -> Indices:
        """Facets of a tag; raises ``InputError`` naming the tags there are, or why it is none."""
        if name in self.unusable and name not in self.faces:
            raise InputError(f"{self.unusable[name]}; the tags are {sorted(self.faces)}")
        if name not in self.faces or len(self.faces[name]) == 0:
            raise InputError(
                f"boundary tag {name!r} is unknown or empty; the body has {sorted(self.faces)}"
            )
        return self.faces[name]

    def face_particles(self, name: str) -> Indices:
        """Sorted vertices of a tag."""
        return np.unique(self.face(name))

    @property
    def boundary(self) -> Indices:
        """All boundary facets ``(f, m)``."""
        return np.concatenate([self.faces[name] for name in sorted(self.faces)])

    @property
    def filling(self) -> Array:
        """Volume a cell stands for, over its own ``(C,)``: one where cells fill the body."""
        return np.ones(len(self.cells))

    @property
    def fits_outline(self) -> bool:
        """Whether the boundary facets are those of the cells, or follow them only nearly."""
        return True

    @property
    def corner_filling(self) -> Array:
        """The same for the part of each corner ``(C, k)``, over ``int N_a dV`` of the cell."""
        return np.broadcast_to(self.filling[:, None], self.cells.shape)


@dataclass(frozen=True)
class HexMesh(Mesh):
    """Eight-node hexahedra, trilinear, with quadrilateral facets ``(f, 4)``."""

    @property
    def shape(self) -> CellShape:
        """:data:`~sphsolid.geometry.cell_shape.HEXAHEDRON`."""
        return HEXAHEDRON


@dataclass(frozen=True)
class GridMesh(HexMesh):
    """Hexahedra between the planes of a grid, disordered or not.

    ``elongation``: the longest edge of the grid over the shortest, which is ``spacing``.  They
    differ where the sides of a body are no multiples of one length.
    """

    elongation: float

    @property
    def widest(self) -> float:
        """The longest edge of the grid [m]."""
        return self.elongation * self.spacing


def copied(mesh: AnyMesh) -> AnyMesh:
    """The mesh with arrays of its own: for a caller who may do with them what he likes."""
    return _with_arrays(mesh, np.copy)


def protected(mesh: AnyMesh) -> AnyMesh:
    """The mesh through views that nobody can write to."""
    return _with_arrays(mesh, read_only)


def _with_arrays(mesh: AnyMesh, change: Callable[[NDArray[Any]], NDArray[Any]]) -> AnyMesh:
    made: dict[str, Any] = {}
    for each in fields(mesh):
        value = getattr(mesh, each.name)
        if isinstance(value, np.ndarray):
            made[each.name] = change(value)
        elif each.name == "faces":
            made[each.name] = {name: change(array) for name, array in value.items()}
    return replace(mesh, **made)


def hexahedra(mesh: Mesh, what: str) -> HexMesh:
    """The mesh itself; raises ``InputError`` when ``what`` needs hexahedra and these are not."""
    if not isinstance(mesh, HexMesh):
        raise InputError(
            f"{what} needs hexahedra and the body is meshed with cells of type "
            f"{mesh.shape.name}; give a mesh of hexahedra, or an option made for it"
        )
    return mesh


@dataclass(frozen=True)
class TetMesh(Mesh):
    """Four-node tetrahedra, linear, with triangular facets ``(f, 3)``."""

    @property
    def shape(self) -> CellShape:
        """:data:`~sphsolid.geometry.cell_shape.TETRAHEDRON`."""
        return TETRAHEDRON
