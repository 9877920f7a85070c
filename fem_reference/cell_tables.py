"""Cells whose fields are all nodal, as tables: shapes, gradients and weights at their points.

``N_a(X_q)`` is the same for every cell; ``dN_a/dX`` and the weight are stored once where all cells
are the same brick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from skfem import ElementTetP1, MeshHex, MeshTet

from fem_reference.hex_quadrature import brick_edges, hex_quadrature
from fem_reference.load_shapes import LoadShapes, trilinear_shapes
from fem_reference.mesh import scikit_fem_mesh, scikit_fem_tetrahedra
from fem_reference.tetrahedra import tetrahedra
from sphsolid.geometry.cell_shape import HEXAHEDRON, TETRAHEDRON
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh, hexahedra

Array = NDArray[np.float64]


class Tables(NamedTuple):
    """What kernels read: ``nodes (E, n)``, ``N (Q, n)``, ``G (R, Q, n, 3)`` [1/m], ``w (R, Q)``.

    ``w`` [m^3]; ``R`` is one where all cells are congruent, otherwise ``E``.
    """

    nodes: NDArray[np.uint32]
    N: Array
    G: Array
    w: Array


@dataclass(frozen=True)
class CellTables:
    """Tables of all cells of ``mesh``, lumped volumes ``V (N,)`` [m^3] and the shortest length.

    ``start, entries``: node ``a`` owns ``entries[start[a]:start[a + 1]]``, rows ``n e + corner`` of
    the values of the cells; ``length`` [m] is what a wave has to cross in a step.
    """

    mesh: Mesh
    sk: MeshHex | MeshTet
    tables: Tables
    V: Array
    length: float
    load_shapes: LoadShapes
    start: NDArray[np.uint32]
    entries: NDArray[np.uint32]

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.tables.nodes)


class CellKind(Protocol):
    """Which cells a mixed method fills the body with."""

    @property
    def name(self) -> str:
        """Plural, for file names."""
        ...

    def meshes(self, mesh: Mesh, what: str) -> tuple[Any, Any]:
        """``mesh`` in these cells, and the same in scikit-fem; ``what`` asks for them."""
        ...

    def tables(self, mesh: Mesh) -> CellTables:
        """Tables on the vertices of ``mesh``."""
        ...


@dataclass(frozen=True)
class Tetrahedra:
    """Linear tetrahedra, one point each; hexahedra are split into six."""

    @property
    def name(self) -> str:
        """``tetrahedra``."""
        return "tetrahedra"

    def meshes(self, mesh: Mesh, what: str) -> tuple[TetMesh, MeshTet]:
        """Hexahedra split into six; raises ``InputError`` for a flat cell."""
        made = tetrahedra(mesh)
        return made, scikit_fem_tetrahedra(made)

    def tables(self, mesh: Mesh) -> CellTables:
        """``length`` is the smallest altitude; raises ``InputError`` for a flat cell."""
        made, sk = self.meshes(mesh, "cells = Tetrahedra()")
        rule = TETRAHEDRON.cell_rule
        tangent = np.einsum("eai,ak->eik", made.vertices[made.cells], rule[0].slopes)
        G = rule[0].slopes @ np.linalg.inv(tangent)
        w = rule[0].weight * np.linalg.det(tangent)
        tables = Tables(
            made.cells.astype(np.uint32), np.full((1, 4), 0.25), np.ascontiguousarray(G[:, None]),
            w[:, None],
        )  # fmt: skip
        length = float(1.0 / np.linalg.norm(G, axis=2).max())
        shapes = LoadShapes(ElementTetP1(), 2, np.arange(len(made.vertices)))
        return _with_nodes(made, sk, tables, length, shapes)


@dataclass(frozen=True)
class Hexahedra:
    """Trilinear hexahedra with 2x2x2 Gauss points."""

    @property
    def name(self) -> str:
        """``hexahedra``."""
        return "hexahedra"

    def meshes(self, mesh: Mesh, what: str) -> tuple[HexMesh, MeshHex]:
        """The mesh itself; raises ``InputError`` where it has other cells."""
        made = hexahedra(mesh, what)
        return made, scikit_fem_mesh(made)

    def tables(self, mesh: Mesh) -> CellTables:
        """``length`` is the smallest stretch of the reference maps, the edge of a cube."""
        made, sk = self.meshes(mesh, "cells = Hexahedra()")
        quadrature = hex_quadrature(made, sk)
        rule = HEXAHEDRON.cell_rule
        chosen = made.cells[:1] if len(brick_edges(made)) else made.cells
        slopes = np.stack([point.slopes for point in rule])
        tangent = np.einsum("eai,qak->eqik", made.vertices[chosen], slopes)
        G = np.ascontiguousarray(slopes @ np.linalg.inv(tangent))
        w = np.linalg.det(tangent) * np.array([point.weight for point in rule])
        N = np.stack([point.N for point in rule])
        tables = Tables(made.cells.astype(np.uint32), N, G, w)
        length = float(quadrature.length.min())
        return _with_nodes(made, sk, tables, length, trilinear_shapes(sk))


def _with_nodes(
    mesh: Mesh, sk: MeshHex | MeshTet, tables: Tables, length: float, shapes: LoadShapes
) -> CellTables:
    nodes = len(mesh.vertices)
    of_corner = np.broadcast_to(tables.w @ tables.N, tables.nodes.shape).ravel()
    V = np.bincount(tables.nodes.ravel(), weights=of_corner, minlength=nodes).astype(np.float64)
    start = np.zeros(nodes + 1, dtype=np.uint32)
    np.cumsum(np.bincount(tables.nodes.ravel(), minlength=nodes), out=start[1:])
    entries = np.argsort(tables.nodes.ravel(), kind="stable").astype(np.uint32)
    return CellTables(mesh, sk, tables, V, length, shapes, start, entries)
