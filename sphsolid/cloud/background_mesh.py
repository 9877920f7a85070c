"""Integrals over the background mesh that give particles their volume and boundary area.

With trilinear shape functions ``N_a`` on isoparametric hexahedra,

    V_a = int N_a dV,      A_a N_a = int_boundary N_a n dA,

so ``sum V_a`` is the volume of the mesh, ``sum A_a N_a = 0`` and
``sum A_a N_a (x) X_a = V I`` hold to round-off.  2x2x2 (2x2) Gauss points integrate both exactly.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.scenes.hex_mesh import CORNERS, HexMesh

Array = NDArray[np.float64]
_GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


def _trilinear(point: tuple[float, float, float]) -> tuple[Array, Array]:
    """Shape functions ``(8,)`` and reference gradients ``(8, 3)`` at a point of [0, 1]^3."""
    factor = np.where(CORNERS == 1, point, 1.0 - np.asarray(point))
    slope = np.where(CORNERS == 1, 1.0, -1.0)
    gradient = np.empty((8, 3))
    for d in range(3):
        others = [k for k in range(3) if k != d]
        gradient[:, d] = slope[:, d] * factor[:, others[0]] * factor[:, others[1]]
    return np.prod(factor, axis=1), gradient


def vertex_volumes(mesh: HexMesh) -> Array:
    """``V_a (N,)`` [m^3]; raises ``InputError`` for an inverted or flat cell."""
    corners = mesh.vertices[mesh.cells]
    volume = np.zeros(len(mesh.vertices))
    for point in itertools.product(_GAUSS, repeat=3):
        shape, gradient = _trilinear(point)
        jacobian = np.linalg.det(np.einsum("ecd,ck->edk", corners, gradient))
        if np.any(jacobian <= 0.0):
            cell = int(np.argmin(jacobian))
            raise InputError(
                f"cell {cell} of the background mesh is inverted or flat (Jacobian "
                f"{jacobian[cell]:.3g} m^3 near X = {corners[cell].mean(axis=0).tolist()} m); "
                "reduce the jitter or repair the mesh"
            )
        for c in range(8):
            volume += np.bincount(
                mesh.cells[:, c], weights=jacobian * shape[c] / 8.0, minlength=len(volume)
            )
    return volume


def cell_volumes_and_centroids(mesh: HexMesh) -> tuple[Array, Array]:
    """Cell volumes ``(C,)`` [m^3] and true centroids ``int X dV / V (C, 3)`` [m]."""
    corners = mesh.vertices[mesh.cells]
    volume = np.zeros(len(corners))
    moment = np.zeros((len(corners), 3))
    for point in itertools.product(_GAUSS, repeat=3):
        shape, gradient = _trilinear(point)
        jacobian = np.linalg.det(np.einsum("ecd,ck->edk", corners, gradient)) / 8.0
        volume += jacobian
        moment += jacobian[:, None] * np.einsum("ecd,c->ed", corners, shape)
    return volume, moment / volume[:, None]


def area_vectors(mesh: HexMesh, quads: NDArray[np.int64]) -> Array:
    """``A_a N_a (N, 3)`` [m^2] of the given boundary quadrilaterals, outward; zero elsewhere."""
    corners = mesh.vertices[quads]
    reference = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    sign = np.where(reference == 1.0, 1.0, -1.0)
    area = np.zeros((len(mesh.vertices), 3))
    for point in itertools.product(_GAUSS, repeat=2):
        factor = np.where(reference == 1.0, point, 1.0 - np.asarray(point))
        shape = factor[:, 0] * factor[:, 1]
        tangent_1 = np.einsum("fcd,c->fd", corners, sign[:, 0] * factor[:, 1])
        tangent_2 = np.einsum("fcd,c->fd", corners, sign[:, 1] * factor[:, 0])
        vector = np.cross(tangent_1, tangent_2) / 4.0
        for c in range(4):
            for d in range(3):
                area[:, d] += np.bincount(
                    quads[:, c], weights=shape[c] * vector[:, d], minlength=len(area)
                )
    return area


def layers_from_boundary(mesh: HexMesh) -> NDArray[np.int64]:
    """Number of cells between a vertex and the boundary ``(N,)``; 0 on the boundary."""
    unreached = np.iinfo(np.int64).max
    layer = np.full(len(mesh.vertices), unreached)
    layer[np.unique(mesh.boundary)] = 0
    depth = 0
    while np.any(layer == unreached):
        touched = np.any(layer[mesh.cells] == depth, axis=1)
        reached = np.unique(mesh.cells[touched])
        fresh = reached[layer[reached] == unreached]
        if len(fresh) == 0:
            break
        depth += 1
        layer[fresh] = depth
    return layer
