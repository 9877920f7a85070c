"""Smoothing lengths: one for the whole cloud, or one a particle where the mesh is graded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.pairs.neighbours import PairList, pairs_of_lengths, pairs_within
from sphsolid.cloud.pairs.sight import Sight
from sphsolid.errors import require
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.integrals import local_spacing
from sphsolid.geometry.mesh import GridMesh, HexMesh, Mesh

Array = NDArray[np.float64]
#: Most that flat cells lengthen the spacing by: to reach the second neighbours sideways.
_FLAT = 1.1
#: Ratio of the longest to the shortest edge of a hexahedron from which it is flat.
FLAT = 1.4
#: Ratio from which it is much longer than wide: no round support serves it well.
LONG = 3.0
#: Mean number of neighbours that a support on long cells may hold where it spans the body.
MOST_NEIGHBOURS = 300
#: Ratio of the largest to the smallest local spacing from which lengths are local.
GRADED = 1.6


@dataclass(frozen=True)
class Uniform:
    """``h = h_over_dx dx`` everywhere; ``spacing`` [m] is ``dx``."""

    spacing: float
    h_over_dx: float

    @property
    def nominal(self) -> float:
        """``dx`` [m]."""
        return self.spacing

    def pairs(self, points: Array, particles: Array, support: float) -> PairList:
        """Particles within the support of every point."""
        return pairs_within(points, particles, support * self.h_over_dx * self.spacing)

    def of_pairs(self, points: Array, pairs: PairList) -> float | Array:
        """``h`` [m] of every pair."""
        return self.h_over_dx * self.spacing

    def spacings(self, points: Array) -> Array:
        """Spacing [m] around every point ``(R,)``."""
        return np.full(len(points), self.spacing)


@dataclass(frozen=True)
class Local:
    """``h_ab = h_over_dx (dx_a + dx_b) / 2``, ``dx_a (N,)`` [m] the spacing around a particle."""

    particles: Array
    spacing: Array
    h_over_dx: float
    sight: Sight

    @property
    def nominal(self) -> float:
        """Mean ``dx_a`` [m]."""
        return float(np.mean(self.spacing))

    def pairs(self, points: Array, particles: Array, support: float) -> PairList:
        """Particles within the support of every point; symmetric among the particles."""
        ratio = support * self.h_over_dx
        return pairs_of_lengths(
            points, particles, ratio * self.spacings(points), ratio * self.spacing
        )

    def of_pairs(self, points: Array, pairs: PairList) -> float | Array:
        """``h`` [m] of every pair ``(P,)``."""
        here = self.spacings(points)[pairs.row_of_pair]
        return np.asarray(0.5 * self.h_over_dx * (here + self.spacing[pairs.indices]))

    def spacings(self, points: Array) -> Array:
        """Spacing [m] around every point ``(R,)``: the mean of those of the four nearest seen."""
        if points is self.particles:
            return self.spacing
        return np.asarray(self.spacing[self.sight.nearest(points, 4)].mean(axis=1))


Lengths = Uniform | Local
#: Corners at both ends of the four edges along each axis of a hexahedron.
_SIDES = np.array(
    [
        [np.flatnonzero(CORNERS[:, axis] == 0), [
            int(np.flatnonzero((corner + np.eye(3, dtype=int)[axis] == CORNERS).all(axis=1))[0])
            for corner in CORNERS[CORNERS[:, axis] == 0]
        ]]
        for axis in range(3)
    ]
)  # fmt: skip


def _mean_edges(mesh: HexMesh) -> Array:
    """Mean length of the four edges along each axis of every cell ``(3, C)`` [m]."""
    corners = mesh.vertices[mesh.cells]
    edges = [
        np.linalg.norm(corners[:, _SIDES[axis, 1]] - corners[:, _SIDES[axis, 0]], axis=2)
        for axis in range(3)
    ]
    return np.array([edge.mean(axis=1) for edge in edges])


def elongation(mesh: Mesh) -> float:
    """Ratio of the longest to the shortest edge of a hexahedron, in the mean; 1 for other cells."""
    if not isinstance(mesh, HexMesh):
        return 1.0
    means = _mean_edges(mesh)
    return float(np.mean(np.max(means, axis=0) / np.min(means, axis=0)))


def has_flat_cells(mesh: Mesh) -> bool:
    """Whether :func:`elongation` is more than :data:`FLAT`.

    The cube of the cells' volume is then too small a measure of their width.
    """
    return elongation(mesh) > FLAT


def refuse_long_cells(mesh: Mesh, lengths: Lengths, support: float, pairs: PairList) -> None:
    """Raise ``InputError`` where long cells make everybody the neighbour of nearly everybody.

    ``pairs`` within ``support`` smoothing lengths, asked before anything is made of them.
    """
    mean = pairs.pairs / max(1, pairs.rows)
    if mean <= MOST_NEIGHBOURS:
        return
    reach = support * lengths.h_over_dx * lengths.nominal
    thickness = float(np.min(np.ptp(mesh.vertices, axis=0)))
    ratio = elongation(mesh)
    require(
        2.0 * reach < thickness or ratio <= LONG,
        f"the longest edge of a cell is {ratio:.2g} times its shortest in the mean: a support that "
        f"serves it, {2.0 * reach:.4g} m wide, spans the whole body, {thickness:.4g} m thick, and "
        f"holds {mean:.0f} neighbours, allowed are {MOST_NEIGHBOURS}; mesh with edges within a "
        "factor of 2 of each other",
    )


def widest_spacing(mesh: Mesh) -> Array:
    """Spacing around each vertex ``(N,)`` [m] in the direction where it is widest.

    Of a hexahedron the longest of its three mean edges, of a tetrahedron that of its cube: a
    support has to reach neighbours on all sides of flat cells too.
    """
    if not isinstance(mesh, HexMesh):
        return local_spacing(mesh)
    means = _mean_edges(mesh)
    longest = np.max(means, axis=0)
    # Flat cells see many neighbours above and below and must see the second ones sideways.
    longest *= np.clip(0.5 + 0.5 * longest / np.min(means, axis=0), 1.0, _FLAT)
    total, count = np.zeros((2, len(mesh.vertices)))
    for corner in mesh.cells.T:
        total += np.bincount(corner, weights=longest, minlength=len(total))
        count += np.bincount(corner, minlength=len(count))
    return np.asarray(total / count)


def lengths_of(mesh: Mesh, h_over_dx: float) -> Lengths:
    """``Uniform`` unless the spacing of the mesh varies by more than :data:`GRADED`.

    On a disordered grid ``dx`` is its widest edge.  On flat hexahedra of any other kind it is the
    mean of what ``widest_spacing`` gives.  The support must reach second neighbours along every
    axis, or there is hardly a gradient that sums by parts.
    """
    if mesh.is_lattice:
        return Uniform(mesh.spacing, h_over_dx)
    spacing = widest_spacing(mesh)
    if np.max(spacing) <= GRADED * np.min(spacing):
        widest = mesh.widest
        if isinstance(mesh, HexMesh) and not isinstance(mesh, GridMesh) and has_flat_cells(mesh):
            widest = max(widest, float(np.mean(spacing)))
        return Uniform(widest, h_over_dx)
    return Local(mesh.vertices, spacing, h_over_dx, Sight.within(mesh))
