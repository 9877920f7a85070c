"""A box of unstructured tetrahedra: the cloud without any grid behind it.

Points: corners, jittered edges, faces and the interior filled with blue noise, as many as a
lattice of that spacing has.  The interior is relaxed towards an optimal Delaunay triangulation
[Chen2004], where a vertex is the volume-weighted mean of the circumcentres around it.  It has few
slivers, and what is left of them is shaken loose.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.errors import require
from sphsolid.geometry.affordable import check_affordable
from sphsolid.geometry.blocks import checked_box
from sphsolid.geometry.blue_noise import blue_noise
from sphsolid.geometry.body import Spacing, chosen
from sphsolid.geometry.delaunay import circumspheres, delaunay, open_facets, tetrahedron_volumes
from sphsolid.geometry.given import Triple, check_seed
from sphsolid.geometry.mesh import TetMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
_EDGE_JITTER = 0.3
_SWEEPS = 5
#: A cell of less volume than this, over a sixth of a cube of the spacing, is a sliver.
_SLIVER = 0.1
#: Points closer than the first of these, over the spacing, are moved apart to the second.
_CLOSE, _APART = 0.6, 0.65
#: Largest shake of the corners of a sliver, over the spacing, and how often to try.
_SHAKE = 0.1
_ROUNDS = 60


@dataclass(frozen=True)
class TetBox:
    """Axis-aligned box of unstructured tetrahedra with faces ``X- X+ Y- Y+ Z- Z+``."""

    lower: Triple = (0.0, 0.0, 0.0)
    upper: Triple = (1.0, 1.0, 1.0)
    seed: int = 0

    def mesh(self, spacing: Spacing) -> TetMesh:
        """Delaunay tetrahedra of about ``spacing`` [m], the same ones for the same ``seed``.

        As many vertices as a :class:`~sphsolid.geometry.body.Box` has at that spacing, or a few
        less.  Raises ``InputError`` for a non-positive spacing, a box without volume, or a seed
        that is no whole number from 0 on.
        """
        edge = chosen(spacing, "a TetBox")
        require(np.isfinite(edge) and edge > 0.0, f"spacing = {edge} m must be positive")
        check_seed(self.seed)
        lower, upper = map(np.array, checked_box(self.lower, self.upper))
        check_affordable((upper - lower).tolist(), [edge] * 3)
        counts = np.maximum(1, np.rint((upper - lower) / edge).astype(int))
        size = float(np.prod((upper - lower) / counts) ** (1.0 / 3.0))
        random = np.random.default_rng(self.seed)
        points, free = _scatter(lower, upper, counts, random)
        for _ in range(_SWEEPS):
            cells = _cells(points, lower, upper)
            points = np.where(free, _optimal(points, cells, size), points)
        cells = _settled(points, free, lower, upper, size, random)
        return TetMesh(points, cells, _faces(points, cells, lower, upper), size, is_lattice=False)

    @property
    def volume(self) -> float:
        """Product of the edge lengths [m^3]."""
        lower, upper = checked_box(self.lower, self.upper)
        return float(np.prod(np.subtract(upper, lower)))


def _scatter(
    lower: Array, upper: Array, counts: Indices, random: np.random.Generator
) -> tuple[Array, NDArray[np.bool_]]:
    """Points ``(N, 3)`` on corners, edges, faces and inside, and the axes each may move along."""
    points = np.empty((0, 3))
    for dimension in range(4):
        # Edges end in corners, faces in edges: each fills the room between the ones before.
        found = [
            _fill(list(free), list(side), lower, upper, counts, points, random)
            for free in combinations(range(3), dimension)
            for side in product((0, 1), repeat=3 - dimension)
        ]
        points = np.concatenate([points, *found])
    return points, (points != lower) & (points != upper)


def _fill(
    free: list[int],
    side: list[int],
    lower: Array,
    upper: Array,
    counts: Indices,
    known: Array,
    random: np.random.Generator,
) -> Array:
    """Points inside the corner, edge, face or body that extends along the axes ``free``."""
    held = [d for d in range(3) if d not in free]
    place = np.where(np.array(side) == 1, upper[held], lower[held])
    points = np.empty((int(np.prod(counts[free] - 1)), 3))
    points[:, held] = place
    if len(free) == 1:
        shift = random.uniform(-0.5, 0.5, len(points)) * _EDGE_JITTER
        share = (np.arange(1, len(points) + 1) + shift) / counts[free]
        points[:, free] = (lower[free] + (upper - lower)[free] * share)[:, None]
    elif len(free) > 1:
        around = known[np.all(known[:, held] == place, axis=1)][:, free]
        points[:, free] = blue_noise(lower[free], upper[free], len(points), around, random)
    return points


def _cells(points: Array, lower: Array, upper: Array) -> Indices:
    """Delaunay cells without the flat ones that lie in a face of the box."""
    cells = delaunay(points)
    in_face = np.zeros(len(cells), dtype=bool)
    for plane in (lower, upper):
        in_face |= np.any(np.all(points[cells] == plane, axis=1), axis=1)
    return cells[~in_face]


def _optimal(points: Array, cells: Indices, size: float) -> Array:
    """Volume-weighted means ``(N, 3)`` of the circumcentres around every vertex."""
    volume = tetrahedron_volumes(points, cells)
    centre, _ = circumspheres(points, cells)
    centroid = points[cells].mean(axis=1)
    # Slivers, and cells at the faces, can have theirs anywhere.
    far = np.linalg.norm(centre - centroid, axis=1) > 0.5 * size
    moment = volume[:, None] * np.where(far[:, None], centroid, centre)
    corner = cells.ravel()
    weight = np.bincount(corner, weights=np.repeat(volume, 4), minlength=len(points))
    total = [
        np.bincount(corner, weights=np.repeat(part, 4), minlength=len(points))
        for part in moment.T
    ]
    return np.stack(total, axis=1) / weight[:, None]


def _settled(
    points: Array,
    free: NDArray[np.bool_],
    lower: Array,
    upper: Array,
    size: float,
    random: np.random.Generator,
) -> Indices:
    """Cells of ``points``, moved in place until none is a sliver and no two points are close."""
    margin = np.minimum(0.3 * size, 0.25 * (upper - lower))
    for _ in range(_ROUNDS):
        _move_apart(points, free, size)
        cells = _cells(points, lower, upper)
        volume = tetrahedron_volumes(points, cells)
        corners = np.unique(cells[volume < _SLIVER * size**3 / 6.0])
        if not np.any(free[corners]):
            break
        shake = random.uniform(-_SHAKE, _SHAKE, (len(corners), 3)) * size
        points[corners] += np.where(free[corners], shake, 0.0)
        points[:] = np.where(free, np.clip(points, lower + margin, upper - margin), points)
    return cells


def _move_apart(points: Array, free: NDArray[np.bool_], size: float) -> None:
    """Push close points apart, in place; both ends of a pair by half of what is lacking."""
    for _ in range(_ROUNDS):
        pairs = cKDTree(points).query_pairs(_CLOSE * size, output_type="ndarray")
        if len(pairs) == 0:
            break
        way = points[pairs[:, 0]] - points[pairs[:, 1]]
        length = np.linalg.norm(way, axis=1, keepdims=True)
        way *= 0.5 * (_APART * size - length) / length
        for end, push in ((0, way), (1, -way)):
            np.add.at(points, pairs[:, end], np.where(free[pairs[:, end]], push, 0.0))


def _faces(points: Array, cells: Indices, lower: Array, upper: Array) -> dict[str, Indices]:
    facets, _ = open_facets(cells)
    faces = {}
    for axis, name in enumerate("XYZ"):
        for sign, plane in (("-", lower), ("+", upper)):
            on = np.all(points[facets][:, :, axis] == plane[axis], axis=1)
            faces[name + sign] = facets[on]
    return faces
