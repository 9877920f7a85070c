"""A body given by points and the closed surface around them: no mesh is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from sphsolid.errors import InputError, require
from sphsolid.geometry.affordable import check_affordable
from sphsolid.geometry.body import AsMeshed, Spacing
from sphsolid.geometry.given import disorder
from sphsolid.geometry.mesh import copied
from sphsolid.geometry.point_file import read_points
from sphsolid.geometry.point_mesh import PointMesh, point_mesh
from sphsolid.geometry.surface import Surface
from sphsolid.geometry.units import Unit, metres
from sphsolid.paths import path_of
from sphsolid.protocols import number

Array = NDArray[np.float64]
#: Points nearer to the surface than this, over the local edge of its triangles, are left out.
CLEARANCE = 0.25
_SAME = 1.0e-9
#: Largest ratio of a filling's spacing to the edges of the surface, either way.
_RATIO = 2.0


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Particles on the vertices of a closed surface and on points inside it.

    ``points (n, 3)``, or a file ``.csv .npy .txt .vtu .xyz`` of them; ``surface``: a
    :class:`Surface`, or a file ``.stl .ply .obj .msh .vtu``; ``unit`` of the numbers in both (a
    ``Surface`` is in metres always).  The surface's names are the tags of the faces.

    The surface's own vertices stand for the boundary.  So points that lie within ``CLEARANCE`` (a
    quarter) of the local edge of the surface, on either side, are left out.  Those of a cloud's
    boundary layer do, and on a curved boundary they are not exactly on its triangles.  A point
    further outside is an error.
    """

    points: ArrayLike | str | Path
    surface: Surface | str | Path
    unit: Unit = "m"

    @classmethod
    def fill(
        cls,
        *,
        surface: Surface | str | Path,
        spacing: float,
        jitter: float = 0.0,
        seed: int = 0,
        unit: Unit = "m",
    ) -> PointCloud:
        """A surface filled with a lattice of ``spacing`` [m]; see :func:`interior_lattice`.

        Raises ``InputError`` where the triangles are much smaller or larger than that: their
        vertices are particles too.
        """
        around = surface if isinstance(surface, Surface) else Surface.read(surface, unit=unit)
        spacing = number("spacing", spacing, "m")
        ratio = spacing / around.edge if spacing > 0.0 else 1.0
        require(
            1.0 / _RATIO <= ratio <= _RATIO,
            f"spacing = {spacing:g} m does not fit the surface, whose edges are {around.edge:.3g} "
            f"m long (median): their ratio must be within [{1 / _RATIO:g}, {_RATIO:g}]; mesh the "
            "surface with triangles of that size",
        )
        points = interior_lattice(surface=around, spacing=spacing, jitter=jitter, seed=seed)
        return cls(points, around)

    def mesh(self, spacing: Spacing) -> PointMesh:
        """The particles' Delaunay cells, with volumes that fit the surface exactly.

        Raises ``InputError`` for a spacing (the body has its own points), points that are not
        finite, coincide or lie outside, and as :func:`~sphsolid.geometry.point_mesh.point_mesh`
        does.
        """
        require(
            isinstance(spacing, AsMeshed),
            f"spacing = {spacing} m is asked of a PointCloud, which brings its own points: leave "
            "the spacing out, or use PointCloud.fill",
        )
        return copied(self._mesh)

    @property
    def volume(self) -> float:
        """What the surface encloses [m^3]."""
        return self.enclosed.volume

    @cached_property
    def enclosed(self) -> Surface:
        """The surface, read if need be."""
        if isinstance(self.surface, Surface):
            return self.surface
        return Surface.read(self.surface, unit=self.unit)

    @cached_property
    def _mesh(self) -> PointMesh:
        if isinstance(self.points, str | Path):
            given, name = read_points(path_of(self.points)), str(self.points)
        else:
            given, name = np.asarray(self.points, dtype=np.float64), "points"
        points = metres(self.unit, f"the point cloud {name}") * given
        return point_mesh(self.enclosed, inner_points(points, self.enclosed, name))


def inner_points(points: Array, surface: Surface, name: str) -> Array:
    """Those of ``points (n, 3)`` that are inside and clear of the surface.

    Raises ``InputError`` for points that are not finite, coincide or lie outside.
    """
    require(
        points.ndim == 2 and points.shape[1] == 3,
        f"{name}: points must have shape (n, 3), got {points.shape}",
    )
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    require(
        len(bad) == 0,
        f"{name}: {len(bad)} points are not finite, the first is number {bad[:1].tolist()}",
    )
    if len(points) == 0:
        return points
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    pairs = cKDTree(points).query_pairs(_SAME * size, output_type="ndarray")
    if len(pairs):
        a, b = np.sort(pairs, axis=1)[0].tolist()
        raise InputError(
            f"{name}: {len(pairs)} pairs of points coincide, for instance numbers {a} and {b} at "
            f"X = {points[a].tolist()} m; give each once"
        )
    corner = surface.vertices[surface.triangles]
    edge = np.sqrt(np.mean(np.sum((corner - np.roll(corner, 1, axis=1)) ** 2, axis=2), axis=1))
    distance = surface.distance(points, reach=CLEARANCE * float(edge.max()))
    clear = distance.length > (1.0 + 1.0e-9) * CLEARANCE * edge[distance.triangle]
    inside = surface.contains(points)
    outside = np.flatnonzero(clear & ~inside)
    if len(outside):
        raise InputError(
            f"{name}: {len(outside)} of {len(points)} points lie outside the surface, the first is "
            f"number {outside[0]} at X = {points[outside[0]].tolist()} m, the surface reaches from "
            f"{surface.vertices.min(axis=0).tolist()} to {surface.vertices.max(axis=0).tolist()} "
            "m; give both in the same unit and place, or leave these points out"
        )
    return points[inside & clear]


def interior_lattice(
    *, surface: Surface, spacing: float, jitter: float = 0.0, seed: int = 0
) -> Array:
    """Points ``(n, 3)`` [m] of a lattice inside a surface, at least half a spacing away from it.

    The lattice fits the bounding box: each of its edges is cut into ``round(length / spacing)``.
    ``jitter`` moves every point by a uniform random offset of at most ``jitter / 2`` of the
    spacing, per component.  Raises ``InputError`` for a spacing that is not positive, a jitter
    outside [0, 0.9], a seed that is no whole number from 0 on, or if no point is left.
    """
    spacing = number("spacing", spacing, "m")
    require(spacing > 0.0, f"spacing = {spacing} m must be positive")
    jitter = disorder(jitter, seed)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    check_affordable((high - low).tolist(), [spacing] * 3)
    counts = np.maximum(1, np.rint(np.round((high - low) / spacing, 9)).astype(int))
    planes = [np.linspace(a, b, n + 1)[1:-1] for a, b, n in zip(low, high, counts, strict=True)]
    points = np.stack(np.meshgrid(*planes, indexing="ij"), axis=-1).reshape(-1, 3)
    if jitter > 0.0:
        random = np.random.default_rng(seed)
        points = points + random.uniform(-0.5, 0.5, points.shape) * jitter * spacing
    points = points[surface.contains(points)]
    if len(points):
        near = surface.distance(points, resolution=spacing / 6.0, reach=spacing).length
        points = points[near >= 0.5 * spacing * (1.0 - 1.0e-9)]
    require(
        len(points) > 0,
        f"no point of a lattice of spacing = {spacing} m is inside the surface and half a spacing "
        "away from it; use a smaller spacing",
    )
    return points
