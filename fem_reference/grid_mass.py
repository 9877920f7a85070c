"""The mass matrix of trilinear shapes on a grid, as a product of tridiagonal ones.

On a box of equal bricks ``M = M_x (x) M_y (x) M_z`` with ``M_x = h/6 tridiag(1, 4, 1)`` and 2 in
its corners, so ``M^-1 r`` is three passes of the tridiagonal algorithm, each over all lines along
one axis.  Lines are independent: the bits do not depend on the number of threads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.hex_quadrature import brick_edges
from sphsolid.compiled import kernel, prange
from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoGrid:
    """The vertices are no full grid."""


@dataclass(frozen=True)
class Grid:
    """For each axis vertex numbers ``lines (L, n)``, ``pivots (n,)`` [m] and ``off = h/6`` [m]."""

    lines: tuple[NDArray[np.uint32], ...]
    pivots: tuple[Array, ...]
    off: tuple[float, ...]

    def solve(self, moments: Array) -> Array:
        """``M^-1 moments`` for ``moments (Nc,)`` [m^3]."""
        values = moments.copy()
        for lines, pivots, off in zip(self.lines, self.pivots, self.off, strict=True):
            _solve_lines(lines, pivots, off, values)
        return values


def grid_of(mesh: HexMesh) -> Grid | NoGrid:
    """The grid that the vertices of ``mesh`` are, if its cells are all the bricks of a box."""
    edges = brick_edges(mesh)
    if len(edges) == 0:
        return NoGrid()
    place = np.rint((mesh.vertices - mesh.vertices.min(axis=0)) / edges).astype(np.int64)
    shape = place.max(axis=0) + 1
    if np.prod(shape) != len(place) or np.prod(shape - 1) != len(mesh.cells):
        return NoGrid()
    number = np.empty(shape, dtype=np.uint32)
    number[tuple(place.T)] = np.arange(len(place))
    lines = tuple(
        np.ascontiguousarray(np.moveaxis(number, axis, -1).reshape(-1, shape[axis]))
        for axis in range(3)
    )
    pivots = tuple(_pivots(int(shape[axis]), edges[axis] / 6.0) for axis in range(3))
    return Grid(lines, pivots, tuple(float(edge) / 6.0 for edge in edges))


def _pivots(n: int, off: float) -> Array:
    """Pivots of the elimination of ``off tridiag(1, 4, 1)`` with 2 in the corners."""
    diagonal = np.full(n, 4.0 * off)
    diagonal[[0, -1]] = 2.0 * off
    for k in range(1, n):
        diagonal[k] -= off * off / diagonal[k - 1]
    return diagonal


@kernel
def _solve_lines(lines, pivots, off, values):  # type: ignore[no-untyped-def]
    """Overwrite ``values (Nc,)`` by the solution along every line."""
    last = lines.shape[1] - 1
    for row in prange(lines.shape[0]):
        line = lines[row]
        before = values[line[0]]
        for k in range(1, last + 1):
            before = values[line[k]] - off / pivots[k - 1] * before
            values[line[k]] = before
        after = values[line[last]] / pivots[last]
        values[line[last]] = after
        for k in range(last - 1, -1, -1):
            after = (values[line[k]] - off * after) / pivots[k]
            values[line[k]] = after
