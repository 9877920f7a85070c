"""A block with a round hole through it, of hexahedra that follow the hole.

Seen along Z the mesh is a ring of cells: spokes run from the hole to the sides of the block, and
layers go around, thin at the hole and thicker outwards.  So there is no lattice, and both solvers
see a curved boundary.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.geometry.affordable import check_affordable
from sphsolid.geometry.blocks import checked_box
from sphsolid.geometry.body import Spacing, chosen
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.geometry.given import Triple
from sphsolid.geometry.mesh import HexMesh
from sphsolid.protocols import number

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Widest hole over the shorter side of the block: beyond it the cells beside it are flat.
WIDEST = 0.8


@dataclass(frozen=True)
class HoledBlock:
    """Axis-aligned block with a hole of ``radius`` [m] along Z through its middle.

    Faces ``X- X+ Y- Y+ Z- Z+`` and ``hole``.  Particles or nodes are ``spacing`` apart on the sides
    and closer at the hole.  Raises ``InputError`` for a block without volume and a hole that
    leaves less than a tenth of the shorter side on either side of it.
    """

    lower: Triple = (-1.0, -1.0, 0.0)
    upper: Triple = (1.0, 1.0, 0.5)
    radius: float = 0.4

    def __post_init__(self) -> None:
        """Refuse a hole that does not fit."""
        lower, upper = checked_box(self.lower, self.upper)
        shorter = min(upper[d] - lower[d] for d in (0, 1))
        widest = 0.5 * WIDEST * shorter
        require(
            0.0 < number("HoledBlock: radius", self.radius, "m") <= widest,
            f"HoledBlock: radius = {self.radius} m must be positive and at most {widest:g} m, "
            f"{0.5 * WIDEST:g} of the shorter side across it",
        )

    @property
    def volume(self) -> float:
        """Volume of the block less that of the round hole [m^3]."""
        sides = np.subtract(self.upper, self.lower)
        return float(np.prod(sides) - math.pi * self.radius**2 * sides[2])

    def mesh(self, spacing: Spacing) -> HexMesh:
        """Hexahedra of about ``spacing`` [m]; the hole has as many sides as there are spokes.

        Raises ``InputError`` for a spacing that is not positive.
        """
        edge = chosen(spacing, "a HoledBlock")
        require(math.isfinite(edge) and edge > 0.0, f"spacing = {edge} m must be positive")
        lower, upper = np.array(self.lower, float), np.array(self.upper, float)
        check_affordable((upper - lower).tolist(), [edge] * 3)
        # At least two cells a side: a spoke ends in every corner, and one in between.
        along = [max(2, round(side / edge)) for side in (upper - lower)[:2]]
        rim, side_of = _rim(lower, upper, along)
        middle = 0.5 * (lower + upper)[:2]
        way = rim - middle
        length = np.linalg.norm(way, axis=1)
        hole = middle + self.radius * way / length[:, None]
        # Outwards each layer is thicker as its circle is longer: the cells stay as wide as long.
        growth = 1.0 + 2.0 * math.pi / len(rim)
        layers = max(2, round(math.log(float(length.mean()) / self.radius) / math.log(growth)))
        # Along Z as at the hole, where the stress is: cells are flat only far from it.
        deep = max(1, round((upper[2] - lower[2]) * len(rim) / (2.0 * math.pi * self.radius)))
        share = (growth ** np.arange(layers + 1.0) - 1.0) / (growth**layers - 1.0)
        plane = (hole + share[:, None, None] * (rim - hole)).reshape(-1, 2)
        heights = np.linspace(lower[2], upper[2], deep + 1)
        vertices = np.array([(*point, z) for z in heights for point in plane])
        cells, faces = _connected(len(rim), layers, deep, side_of)
        return HexMesh(vertices, cells, faces, edge, is_lattice=False)


def _rim(lower: Array, upper: Array, along: list[int]) -> tuple[Array, list[str]]:
    """Points ``(n, 2)`` once around the block against the clock, and the side after each."""
    (left, low), (right, high) = lower[:2], upper[:2]
    nx, ny = along
    x, y = np.linspace(left, right, nx + 1), np.linspace(low, high, ny + 1)
    sides = {
        "Y-": np.stack([x[:-1], np.full(nx, low)], axis=1),
        "X+": np.stack([np.full(ny, right), y[:-1]], axis=1),
        "Y+": np.stack([x[:0:-1], np.full(nx, high)], axis=1),
        "X-": np.stack([np.full(ny, left), y[:0:-1]], axis=1),
    }
    return np.concatenate([*sides.values()]), [
        name for name, points in sides.items() for _ in points
    ]


def _connected(
    spokes: int, layers: int, deep: int, side_of: list[str]
) -> tuple[Indices, dict[str, Indices]]:
    """Cells, and facets by tag; vertices count around, then outwards, then along Z."""
    ring = np.arange(spokes)
    after = np.roll(ring, -1)
    per_plane = spokes * (layers + 1)

    def at(j: Indices, k: Indices, z: Indices) -> Indices:
        return z * per_plane + k * spokes + j

    z, k, j = (axis.ravel() for axis in np.indices((deep, layers, spokes)))
    floor = [at(j, k, z), at(j, k + 1, z), at(after[j], k + 1, z), at(after[j], k, z)]
    cells = np.stack([*floor, *(corner + per_plane for corner in floor)], axis=1)
    below, above, inside, outside = HEXAHEDRON.facets[[0, 1, 4, 5]]
    names, outermost = np.array(side_of), k == layers - 1
    faces = {
        name: cells[outermost & (names[j] == name)][:, outside] for name in dict.fromkeys(side_of)
    }
    faces |= {"Z-": cells[z == 0][:, below], "Z+": cells[z == deep - 1][:, above]}
    return cells, faces | {"hole": cells[k == 0][:, inside]}
