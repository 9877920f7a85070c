"""Reference-state arrays of eight-node hexahedra, taken from scikit-fem once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementHex1, MeshHex

from fem_reference.mesh import CORNER_OF_NODE
from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]
#: Polynomial degree that makes scikit-fem use 2x2x2 (2x2 on facets) Gauss points.
GAUSS_2 = 3


@dataclass(frozen=True)
class HexQuadrature:
    """Reference-state data of ``R`` distinct elements; ``R = 1`` when all ``E`` are congruent.

    ``cells (E, 8)`` nodes in the corner order of ``CORNERS``; ``edges (3,)`` [m] of the brick that
    all elements are, empty otherwise; ``element_volumes (R,)`` [m^3] by the 2x2x2 Gauss points;
    ``centroid_gradients (R, 8, 3)`` ``dN_a/dX`` [1/m]; ``corner_volumes (R, 8)`` ``integral of N_a
    dV`` [m^3], the row sums of the consistent mass matrix over ``rho0``; ``length (R,)`` [m] the
    smallest singular value of ``dX/dxi`` (``xi`` in [0, 1]^3) over the Gauss points: the edge of a
    cube, the shortest edge of a brick, less than any edge of a slanted element.
    """

    cells: NDArray[np.uint32]
    edges: Array
    element_volumes: Array
    centroid_gradients: Array
    corner_volumes: Array
    length: Array

    @property
    def elements(self) -> int:
        """``E``."""
        return len(self.cells)

    @property
    def congruent(self) -> bool:
        """True when all elements are the same brick."""
        return len(self.edges) > 0

    @property
    def volumes(self) -> Array:
        """Element volumes ``V_e (E,)`` [m^3]."""
        return np.broadcast_to(self.element_volumes, self.elements).copy()

    def nodal_volumes(self, nodes: int) -> Array:
        """Row-sum lumped volumes ``V_a = sum_e integral N_a dV (N,)`` [m^3]; they sum to ``V``."""
        corner = np.broadcast_to(self.corner_volumes, self.cells.shape)
        volumes = np.bincount(self.cells.ravel(), weights=corner.ravel(), minlength=nodes)
        return volumes.astype(np.float64)


def hex_quadrature(mesh: HexMesh, sk: MeshHex) -> HexQuadrature:
    """Evaluate scikit-fem's trilinear basis of ``mesh`` (``sk`` is the same mesh).

    Raises ``InputError`` for an element whose reference map folds (``det dX/dxi <= 0``).
    """
    edges = brick_edges(mesh)
    chosen = np.array([0]) if len(edges) else np.arange(len(mesh.cells))
    basis = Basis(sk, ElementHex1(), intorder=GAUSS_2, elements=chosen)
    centre = Basis(
        sk, ElementHex1(), quadrature=(np.full((3, 1), 0.5), np.ones(1)), elements=chosen
    )
    shape = (len(chosen), basis.X.shape[1])
    determinant = np.broadcast_to(basis.mapping.detDF(basis.X, chosen), shape)
    if determinant.min() <= 0.0:
        element = int(chosen[np.argmin(determinant.min(axis=1))])
        raise InputError(
            f"element {element} with vertices {mesh.cells[element].tolist()} is folded in the "
            "undeformed body (det dX/dxi <= 0); reduce the jitter or repair the mesh"
        )
    centroid_gradients = np.empty((len(chosen), 8, 3))
    corner_volumes = np.empty((len(chosen), 8))
    for node, corner in enumerate(CORNER_OF_NODE):
        field = basis.basis[node][0]
        corner_volumes[:, corner] = np.sum(np.asarray(field) * basis.dx, axis=1)
        centroid_gradients[:, corner] = np.moveaxis(centre.basis[node][0].grad[:, :, 0], 0, -1)
    tangents = np.moveaxis(basis.mapping.DF(basis.X, chosen), (0, 1), (-2, -1))
    # eigvalsh of the metric instead of an svd: several times faster on many small matrices.
    metric = np.swapaxes(tangents, -1, -2) @ tangents
    length = np.sqrt(np.linalg.eigvalsh(metric)[..., 0].min(axis=1))
    return HexQuadrature(
        cells=mesh.cells.astype(np.uint32),
        edges=edges,
        element_volumes=basis.dx.sum(axis=1),
        centroid_gradients=centroid_gradients,
        corner_volumes=corner_volumes,
        length=length,
    )


def brick_edges(mesh: HexMesh) -> Array:
    """Edges ``(3,)`` [m] of the brick that all cells are, up to rounding; empty where they differ.

    ``is_lattice`` alone does not say so: a body of several boxes rounds each to whole cells.
    """
    if not mesh.is_lattice:
        return np.empty(0)
    corners = mesh.vertices[mesh.cells] - mesh.vertices[mesh.cells[:, :1]]
    edges = np.array([corners[0, 1, 0], corners[0, 3, 1], corners[0, 4, 2]])
    equal = np.abs(corners - CORNERS * edges).max() <= 1.0e-12 * mesh.spacing
    return edges if equal else np.empty(0)
