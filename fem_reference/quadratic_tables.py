"""Reference-state arrays of 27-node hexahedra: lumped volumes, corner mass, step of the element."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import coo_matrix, csr_matrix

from fem_reference.dilatation import Dilatation
from fem_reference.grid_mass import NoGrid
from fem_reference.mesh import scikit_fem_mesh
from fem_reference.quadratic_mesh import NODES, quadratic_mesh, trilinear
from fem_reference.triquadratic import PLACES, WEIGHTS
from sphsolid.continuum.wave_speed import moduli_at_rest, reference_p_wave_speed
from sphsolid.errors import InputError
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh
from sphsolid.scenes import Box

Array = NDArray[np.float64]
#: Gauss points ``(27, 3)`` in the unit cube, the first coordinate runs fastest.
POINTS = np.array([(a, b, c) for c, b, a in itertools.product(PLACES, repeat=3)])
#: Centres of the eighths of the unit cube ``(8, 3)``.
PART_CENTRES = np.array(
    [(a, b, c) for c, b, a in itertools.product((0.25, 0.75), repeat=3)]
)
#: Simpson weights of the 27 nodes of the unit cube.
_SIMPSON = np.einsum("k,j,i->kji", *[np.array([1.0, 4.0, 1.0]) / 6.0] * 3).ravel()


def quadratic_gradients(points: Array) -> Array:
    """``dN_n/dxi (p, 27, 3)`` of the triquadratic shapes at ``points (p, 3)``."""
    s = points[:, :, None]
    at = np.array([0.0, 0.5, 1.0])
    other = np.array([[0.5, 1.0], [0.0, 1.0], [0.0, 0.5]])
    scale = (at - other[:, 0]) * (at - other[:, 1])
    value = (s - other[:, 0]) * (s - other[:, 1]) / scale
    slope = (2.0 * s - other.sum(axis=1)) / scale
    index = np.rint(2.0 * NODES).astype(int)
    gradient = np.ones((len(points), 27, 3))
    for axis, direction in itertools.product(range(3), repeat=2):
        factor = slope if axis == direction else value
        gradient[:, :, direction] *= factor[:, axis, index[:, axis]]
    return gradient


def trilinear_tangents(mesh: HexMesh, points: Array) -> Array:
    """``dX/dxi (E, p, 3, 3)`` of every cell at ``points (p, 3)``."""
    side = np.where(CORNERS == 1, 1.0, -1.0)
    factor = np.where(CORNERS == 1, points[:, None, :], 1.0 - points[:, None, :])
    slopes = np.stack(
        [side[:, a] * np.prod(np.delete(factor, a, axis=2), axis=2) for a in range(3)], axis=2
    )
    return np.asarray(np.einsum("eci,pck->epik", mesh.vertices[mesh.cells], slopes))


def simpson_volumes(mesh: HexMesh, cells: NDArray[Any], nodes: int) -> Array:
    """``V_n = sum_e w_n det dX/dxi(n) (N,)`` [m^3]; they sum to the volume of the body exactly.

    Raises ``InputError`` for an element whose reference map folds at a node.
    """
    determinant = np.linalg.det(trilinear_tangents(mesh, NODES))
    if determinant.min() <= 0.0:
        element = int(np.argmin(determinant.min(axis=1)))
        raise InputError(
            f"element {element} with vertices {mesh.cells[element].tolist()} is folded in the "
            "undeformed body (det dX/dxi <= 0); reduce the jitter or repair the mesh"
        )
    share = (_SIMPSON * determinant).ravel()
    return np.bincount(cells.ravel(), weights=share, minlength=nodes).astype(np.float64)


def corner_mass(mesh: HexMesh) -> csr_matrix:
    """``M_ab = integral N_a N_b dV (Nc, Nc)`` [m^3] of the trilinear shapes."""
    N = trilinear(POINTS)
    share = WEIGHTS * np.linalg.det(trilinear_tangents(mesh, POINTS))
    entries = np.einsum("ep,pa,pb->eab", share, N, N)
    rows = np.broadcast_to(mesh.cells[:, :, None], entries.shape)
    columns = np.broadcast_to(mesh.cells[:, None, :], entries.shape)
    size = len(mesh.vertices)
    matrix = coo_matrix((entries.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
    assembled = matrix.tocsr()
    assembled.sort_indices()
    return assembled


def step_share(material: Any, dilatation: Dilatation) -> float:
    """``2 c_p / (omega d)``: share of ``d / c_p`` that is a stable step, ``d`` the node distance.

    ``omega`` is the highest frequency of a free, undeformed block of 2x2x2 cubes, whose corners are
    its fastest part as they are of larger blocks: 4x4x4 cubes have the same to two per cent.
    """
    mesh = Box().mesh(0.5)
    nodes = quadratic_mesh(mesh, scikit_fem_mesh(mesh))
    size = 3 * len(nodes.parts.vertices)
    B = _strain_operator() / 0.5
    share = WEIGHTS / 8.0
    trace = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    deviator = np.eye(6) - np.outer(trace, trace) / 3.0
    mu, kappa = moduli_at_rest(material)
    element = 2.0 * mu * np.einsum("p,prn,rs,psm->nm", share, B, deviator, B)
    moments = np.einsum("p,pa,r,prn->an", share, trilinear(POINTS), trace, B)
    K, divergence = np.zeros((size, size)), np.zeros((len(mesh.vertices), size))
    for cell, corners in zip(nodes.cells.astype(int), mesh.cells, strict=True):
        dofs = (3 * cell[:, None] + np.arange(3)).ravel()
        K[np.ix_(dofs, dofs)] += element
        divergence[np.ix_(corners, dofs)] += moments
    solve = dilatation.solver(corner_mass(mesh), NoGrid())
    projected = np.stack([solve(column) for column in divergence.T], axis=1)
    K += kappa * divergence.T @ projected
    volumes = simpson_volumes(mesh, nodes.cells, size // 3)
    root = np.repeat(np.sqrt(material.density * volumes), 3)
    top = [size - 1, size - 1]
    highest = eigh(K / np.outer(root, root), eigvals_only=True, subset_by_index=top)[0]
    stable = 2.0 * reference_p_wave_speed(material) / (math.sqrt(highest) * 0.25)
    # Three digits, downwards: the last ones depend on the library, and the step must not.
    return math.floor(1.0e3 * stable) / 1.0e3


def _strain_operator() -> Array:
    """Six strains (shears over sqrt 2) of the unit cube at its points: ``(27, 6, 81)``."""
    B = np.zeros((27, 6, 81))
    gradient = quadratic_gradients(POINTS)
    for row, (i, k) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        if i == k:
            B[:, row, i::3] = gradient[:, :, k]
        else:
            B[:, row, i::3] = gradient[:, :, k] / math.sqrt(2.0)
            B[:, row, k::3] = gradient[:, :, i] / math.sqrt(2.0)
    return B
