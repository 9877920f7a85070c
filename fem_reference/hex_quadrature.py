"""Reference-state arrays of eight-node hexahedra, taken from scikit-fem once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementHex1, MeshHex

from fem_reference.mesh import CORNER_OF_NODE
from sphsolid.errors import InputError
from sphsolid.scenes.hex_mesh import HexMesh

Array = NDArray[np.float64]
#: Polynomial degree that makes scikit-fem use 2x2x2 (2x2 on facets) Gauss points.
GAUSS_2 = 3


@dataclass(frozen=True)
class HexQuadrature:
    """Shape-function data of ``R`` distinct elements; ``R = 1`` when all ``E`` are congruent.

    ``cells (E, 8)`` nodes in the corner order of ``CORNERS``; at the 2x2x2 Gauss points
    ``gradients (R, 8 points, 8 nodes, 3)`` ``dN_a/dX`` [1/m] and ``weights (R, 8)`` ``w_g det
    dX/dxi`` [m^3]; ``centroid_gradients (R, 8, 3)`` [1/m]; ``corner_volumes (R, 8)`` ``integral
    of N_a dV`` [m^3], the row sums of the consistent mass matrix over ``rho0``; ``length (R,)``
    [m] the smallest singular value of ``dX/dxi`` (``xi`` in [0, 1]^3) over the Gauss points: the
    edge of a cube, the shortest edge of a brick, less than any edge of a slanted element.
    """

    cells: NDArray[np.uint32]
    gradients: Array
    weights: Array
    centroid_gradients: Array
    corner_volumes: Array
    length: Array

    @property
    def elements(self) -> int:
        """``E``."""
        return len(self.cells)

    @property
    def congruent(self) -> bool:
        """True when one set of gradients serves all elements."""
        return len(self.weights) == 1

    @property
    def volumes(self) -> Array:
        """Element volumes ``V_e (E,)`` [m^3]."""
        return np.broadcast_to(self.weights.sum(axis=1), self.elements).copy()

    def nodal_volumes(self, nodes: int) -> Array:
        """Row-sum lumped volumes ``V_a = sum_e integral N_a dV (N,)`` [m^3]; they sum to ``V``."""
        corner = np.broadcast_to(self.corner_volumes, self.cells.shape)
        volumes = np.bincount(self.cells.ravel(), weights=corner.ravel(), minlength=nodes)
        return volumes.astype(np.float64)


def hex_quadrature(mesh: HexMesh, sk: MeshHex) -> HexQuadrature:
    """Evaluate scikit-fem's trilinear basis of ``mesh`` (``sk`` is the same mesh).

    Raises ``InputError`` for an element whose reference map folds (``det dX/dxi <= 0``).
    """
    chosen = np.array([0]) if _congruent(mesh) else np.arange(len(mesh.cells))
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
    gradients = np.empty((*shape, 8, 3))
    centroid_gradients = np.empty((len(chosen), 8, 3))
    corner_volumes = np.empty((len(chosen), 8))
    for node, corner in enumerate(CORNER_OF_NODE):
        field = basis.basis[node][0]
        gradients[:, :, corner] = np.moveaxis(field.grad, 0, -1)
        corner_volumes[:, corner] = np.sum(np.asarray(field) * basis.dx, axis=1)
        centroid_gradients[:, corner] = np.moveaxis(centre.basis[node][0].grad[:, :, 0], 0, -1)
    tangents = np.moveaxis(basis.mapping.DF(basis.X, chosen), (0, 1), (-2, -1))
    # eigvalsh of the metric instead of an svd: several times faster on many small matrices.
    metric = np.swapaxes(tangents, -1, -2) @ tangents
    length = np.sqrt(np.linalg.eigvalsh(metric)[..., 0].min(axis=1))
    return HexQuadrature(
        cells=mesh.cells.astype(np.uint32),
        gradients=gradients,
        weights=np.ascontiguousarray(basis.dx),
        centroid_gradients=centroid_gradients,
        corner_volumes=corner_volumes,
        length=length,
    )


def _congruent(mesh: HexMesh) -> bool:
    """True when all cells are translations of the first, up to rounding.

    ``is_lattice`` alone does not say so: a body of several boxes rounds each to whole cells.
    """
    if not mesh.is_lattice:
        return False
    edges = mesh.vertices[mesh.cells] - mesh.vertices[mesh.cells[:, :1]]
    return bool(np.abs(edges - edges[0]).max() <= 1.0e-12 * mesh.spacing)
