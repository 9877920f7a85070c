"""Cells that the positions turn inside out, and points that are no particles.

The Jacobian that a method evolves or takes at its own points can stay near one while the body
between them folds.  Here it is that of the map of each cell from its reference corners to where
they are now, ``J = det(dx/dX)``: of hexahedra the trilinear map at its 2 x 2 x 2 Gauss points, of
tetrahedra the linear one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh, Mesh
from sphsolid.record.per_mesh import PerMesh
from sphsolid.record.placement import NoSecondaryGradient, Placed

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Least shape ``6 sqrt(2) V / l^3`` (``l`` the root mean square edge; regular 1, a sixth of a cube
#: 0.66) of a tetrahedron that is judged.  The height of a flat one is a small part of its edges:
#: points of a sound body pass through it, and nothing is folded.  Of a cloud with jitter 0.4 a
#: fifth is flatter, of a mesh of tetrahedra 2 %; in the twisted column of such a cloud, which is
#: sound, cells of shape 0.4 turn and none above.
LEAST_SHAPE = 0.5
#: Of a mesh that is flat everywhere, such as thin layers, this share of its median shape: there the
#: height of a cell is the distance of two layers, which a sound body keeps.
_OF_MEDIAN = 0.8
#: Cells worked on at once.
_BLOCK = 1024
#: Distance of a Gauss point from the nearer end, over the edge.
_GAUSS = 0.5 - 0.5 / np.sqrt(3.0)
_SIX_ROOT_TWO = 6.0 * np.sqrt(2.0)


@dataclass(frozen=True)
class InsideOut:
    """``share`` of the cells (or points) with ``det(dx/dX) <= 0`` somewhere, ``smallest`` of it."""

    share: float
    smallest: float


NOTHING_JUDGED = InsideOut(0.0, 1.0)


def inside_out(snapshot: Placed) -> InsideOut:
    """Share of the cells inside out and the smallest determinant, of ``snapshot.mesh``.

    Particles are judged by the cells between them; tetrahedra flatter than :data:`LEAST_SHAPE`
    are left out, but in a mesh that is flat everywhere.
    """
    cells = _CELLS(snapshot.mesh)
    if cells.corners.shape[1] == 0:
        return NOTHING_JUDGED
    J = cells.jacobians(snapshot.x)
    return InsideOut(float(np.mean(np.any(J <= 0.0, axis=0))), float(np.min(J)))


def inside_out_secondary(snapshot: Placed) -> InsideOut:
    """The same at the secondary particles of SPH, by ``F_q = sum_a x_a (x) G_a(X_q)``.

    Nothing is inside out where a method has none.
    """
    secondary = snapshot.secondary
    if isinstance(secondary, NoSecondaryGradient) or len(secondary.F) == 0:
        return NOTHING_JUDGED
    J = _determinant(*secondary.F.transpose(2, 1, 0))
    return InsideOut(float(np.mean(J <= 0.0)), float(np.min(J)))


@dataclass(frozen=True)
class _Cells:
    """``corners (k, C)`` of the cells that are judged, those of hexahedra in the order of a grid,
    and ``reference (g, C)`` [m^3] Jacobians.
    """

    corners: Indices
    reference: Array

    def jacobians(self, x: Array) -> Array:
        """``det(dx/dX) (g, C)`` at the points of each cell."""
        return _jacobians(x, self.corners) / self.reference


def gauss_jacobians(mesh: HexMesh, x: Array) -> tuple[Array, Array]:
    """``det(dX/dxi) (8, C)`` [m^3] and ``det(dx/dX) (8, C)`` at 2 x 2 x 2 Gauss points.

    ``x (N, 3)`` [m] are positions of the vertices.  Every point weighs an eighth.
    """
    cells = _CELLS(mesh)
    return cells.reference, cells.jacobians(x)


def _cells(mesh: Mesh) -> _Cells:
    X = mesh.vertices
    if isinstance(mesh, HexMesh):
        corners = mesh.cells.T[_GRID]
    else:
        corners = mesh.cells.T
        shape = _shape(X, corners)
        corners = corners[:, shape >= min(LEAST_SHAPE, _OF_MEDIAN * float(np.median(shape)))]
    corners = np.ascontiguousarray(corners)
    return _Cells(corners, _jacobians(X, corners))


def _shape(X: Array, corners: Indices) -> Array:
    edges = X[corners[[0, 0, 0, 1, 1, 2]]] - X[corners[[1, 2, 3, 2, 3, 3]]]
    edge = np.sqrt(np.mean(np.sum(edges**2, axis=2), axis=0))
    volume = np.abs(_jacobians(X, corners)[0]) / 6.0
    return np.asarray(_SIX_ROOT_TWO * volume / edge**3)


def _jacobians(x: Array, corners: Indices) -> Array:
    """Of the maps from reference coordinates ``(g, C)`` [m^3]."""
    components = np.ascontiguousarray(x.T)
    of_block = _of_tetrahedra if len(corners) == 4 else _of_hexahedra
    # Blocks small enough that what is made on the way stays in the cache.
    blocks = [
        of_block(np.take(components, corners[:, first : first + _BLOCK], axis=1))
        for first in range(0, max(1, corners.shape[1]), _BLOCK)
    ]
    return np.concatenate(blocks, axis=1)


def _of_tetrahedra(at: Array) -> Array:
    return _determinant(*(at[:, k] - at[:, 0] for k in (1, 2, 3)))[None]


def _of_hexahedra(at: Array) -> Array:
    # Corners on a grid (3, i, j, k, C): a slope along one axis is bilinear in the other two.
    grid = at.reshape(3, 2, 2, 2, -1)
    a = _at_gauss(_at_gauss(grid[:, 1] - grid[:, 0], 1), 2)[:, None]
    b = _at_gauss(_at_gauss(grid[:, :, 1] - grid[:, :, 0], 1), 2)[:, :, None]
    c = _at_gauss(_at_gauss(grid[:, :, :, 1] - grid[:, :, :, 0], 1), 2)[:, :, :, None]
    return _determinant(a, b, c).reshape(8, -1)


#: Corner of a hexahedron at each place of a grid, the last axis first.
_GRID = np.lexsort(CORNERS.T[::-1])


def _at_gauss(ends: Array, axis: int) -> Array:
    """Linear between the two ``ends`` along ``axis``, at the two Gauss points."""
    found = np.empty_like(ends)
    low, high = (np.moveaxis(ends, axis, 0)[end] for end in (0, 1))
    step = _GAUSS * (high - low)
    np.add(low, step, out=np.moveaxis(found, axis, 0)[0])
    np.subtract(high, step, out=np.moveaxis(found, axis, 0)[1])
    return found


def _determinant(a: Array, b: Array, c: Array) -> Array:
    """``a . (b x c)`` of vectors ``(3, ...)``."""
    return np.asarray(
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


_CELLS = PerMesh(_cells)
