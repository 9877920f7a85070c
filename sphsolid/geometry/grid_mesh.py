"""Hexahedra on a structured grid of which some cells are kept: boxes and unions of boxes.

A grid has planes along each axis; wherever the outline of a body has an edge there is a plane, so
that the mesh fills the body exactly.  Disorder moves vertices within what they lie on (body, face,
edge), so the body, its faces and its volume stay exact too.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.geometry.affordable import check_affordable
from sphsolid.geometry.blocks import Block, block_breaks, checked_blocks, covered
from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.given import Triple, disorder, triple
from sphsolid.geometry.mesh import GridMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GridAxis:
    """Planes of a grid along one axis: ``planes (n + 1,)`` [m], cell edges ``steps (n,)`` [m]."""

    planes: Array
    steps: Array

    @classmethod
    def through(cls, breaks: list[float], edge: float) -> GridAxis:
        """Planes through all ``breaks`` (ascending), cells of about ``edge`` [m] between them.

        Every interval is cut into ``round(length / edge)`` equal cells, at least one.
        """
        planes, steps = [np.array(breaks[:1])], []
        for low, high in pairwise(breaks):
            count = max(1, int(np.rint((high - low) / edge)))
            planes.append(np.linspace(low, high, count + 1)[1:])
            steps.append(np.full(count, (high - low) / count))
        return cls(np.concatenate(planes), np.concatenate(steps))

    @property
    def is_uniform(self) -> bool:
        """True when all cells are equally long, up to rounding."""
        return _is_uniform(self.steps)

    @property
    def room(self) -> Array:
        """Shortest cell edge that ends at each plane ``(n + 1,)`` [m]."""
        return np.minimum(np.r_[self.steps[0], self.steps], np.r_[self.steps, self.steps[-1]])


def grid_mesh(
    axes: tuple[GridAxis, GridAxis, GridAxis],
    keep: NDArray[np.bool_],
    jitter: float = 0.0,
    seed: int = 0,
) -> GridMesh:
    """The cells of a grid where ``keep (nx, ny, nz)``; vertices that no cell uses are left out.

    Tags: ``X- X+ Y- Y+ Z- Z+`` on the outermost planes; a face whose outward normal is ``+X`` on an
    inner plane ``X = 3`` is ``X+@3``.  ``jitter`` moves inner vertices, and boundary vertices
    within their face or edge.  Per component the offset is uniform random and at most ``jitter /
    2`` of the shorter of the cell edges that meet there.  Raises ``InputError`` for a jitter
    outside [0, 0.9] and a seed that is no whole number from 0 on.
    """
    jitter = disorder(jitter, seed)
    grid = np.stack(
        np.meshgrid(*(axis.planes for axis in axes), indexing="ij"), axis=-1
    ).reshape(-1, 3)
    number = np.arange(len(grid)).reshape([len(axis.planes) for axis in axes])
    nx, ny, nz = keep.shape
    corner = [number[i : i + nx, j : j + ny, k : k + nz][keep] for i, j, k in CORNERS]
    cells = np.stack(corner, axis=1)

    faces: dict[str, NDArray[np.int64]] = {}
    on_face = np.zeros(grid.shape, dtype=bool)
    for axis in range(3):
        for name, quads in _faces_across(axis, axes[axis].planes, keep, number):
            faces[name] = quads
            on_face[quads, axis] = True
    vertices = grid
    if jitter > 0.0:
        room = np.stack(
            np.meshgrid(*(axis.room for axis in axes), indexing="ij"), axis=-1
        ).reshape(-1, 3)
        offset = np.random.default_rng(seed).uniform(-0.5, 0.5, grid.shape) * jitter * room
        vertices = grid + np.where(on_face, 0.0, offset)

    used = np.unique(cells)
    place = np.full(len(grid), -1)
    place[used] = np.arange(len(used))
    # Every interval has its own whole number of cells; the smallest edge limits the step.  The
    # steps across a gap between parts are nobody's edge.
    steps = [
        axis.steps[keep.any(axis=tuple({0, 1, 2} - {d}))] for d, axis in enumerate(axes)
    ]
    edge = float(min(np.min(its) for its in steps))
    longest = float(max(np.max(its) for its in steps))
    return GridMesh(
        vertices[used],
        place[cells],
        {name: place[quads] for name, quads in faces.items()},
        edge,
        is_lattice=jitter == 0.0 and all(_is_uniform(its) for its in steps),
        elongation=longest / edge,
    )


def _is_uniform(steps: Array) -> bool:
    """True when all cells are equally long, up to rounding."""
    return bool(np.ptp(steps) <= 1.0e-12 * steps[0])


def _faces_across(
    axis: int, planes: Array, keep: NDArray[np.bool_], number: NDArray[np.int64]
) -> list[tuple[str, NDArray[np.int64]]]:
    """Named outward quadrilaterals between a kept cell and none, normal to ``axis``."""
    inside = np.moveaxis(keep, axis, 0)
    plane_numbers = np.moveaxis(number, axis, 0)
    nowhere = np.zeros_like(inside[:1])
    below = np.concatenate([nowhere, inside])
    above = np.concatenate([inside, nowhere])
    found = []
    for side, exposed in (("-", above & ~below), ("+", below & ~above)):
        for plane in np.flatnonzero(exposed.any(axis=(1, 2))):
            a = plane_numbers[plane]
            loop = [a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]]
            quads = np.stack([part[exposed[plane]] for part in loop], axis=1)
            # The loops turn about +X, -Y, +Z: moveaxis leaves the other two axes in order.
            if (side == "-") == (axis != 1):
                quads = quads[:, ::-1].copy()
            outermost = plane == (0 if side == "-" else len(planes) - 1)
            name = f"{'XYZ'[axis]}{side}" + ("" if outermost else f"@{planes[plane]:.12g}")
            found.append((name, quads))
    return found


def box_mesh(
    lower: Triple,
    upper: Triple,
    spacing: float,
    jitter: float = 0.0,
    seed: int = 0,
    aspect: Triple = (1.0, 1.0, 1.0),
) -> GridMesh:
    """Hexahedra filling a box; tags ``X- X+ Y- Y+ Z- Z+``.

    Each edge is cut into ``round(length / (spacing aspect_d))`` equal cells (at least one); for
    ``jitter`` see :func:`grid_mesh`.  Raises ``InputError`` for a non-positive spacing or aspect,
    a jitter outside [0, 0.9] or a box without volume.
    """
    return block_mesh(((lower, upper),), spacing, jitter, seed, aspect)


def block_mesh(
    blocks: tuple[Block, ...],
    spacing: float,
    jitter: float = 0.0,
    seed: int = 0,
    aspect: Triple = (1.0, 1.0, 1.0),
) -> GridMesh:
    """Hexahedra filling the union of axis-aligned boxes, which may overlap.

    All sides of the boxes are grid planes, sides that differ by round-off one plane
    (:func:`~sphsolid.geometry.blocks.checked_blocks`); see :func:`box_mesh` for the rounding
    between them and :func:`grid_mesh` for tags, ``jitter`` and what is raised.
    """
    require(np.isfinite(spacing) and spacing > 0.0, f"spacing = {spacing} m must be positive")
    aspect = triple("aspect", aspect, "spacings, the edges of a cell")
    require(
        min(aspect) > 0.0,
        f"aspect = {aspect} (edge of a cell along X, Y, Z over the spacing) must be positive",
    )
    blocks = checked_blocks(blocks)
    breaks = block_breaks(blocks)
    sides = [axis[-1] - axis[0] for axis in breaks]
    check_affordable(sides, [spacing * factor for factor in aspect])
    x, y, z = (GridAxis.through(breaks[d], spacing * aspect[d]) for d in range(3))
    keep = covered(blocks, (x.planes, y.planes, z.planes))
    return grid_mesh((x, y, z), keep, jitter, seed)
