"""The closed surface of a body: triangles, their names, and the volume that they enclose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.closed_surface import check_triangles, halves, joined, oriented
from sphsolid.geometry.inside import Distance, distance_to_surface, winding_numbers
from sphsolid.geometry.surface_file import UNNAMED, read_facets
from sphsolid.geometry.units import Unit, metres
from sphsolid.paths import path_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Surface:
    """Triangles that enclose a body, every one of them turned outward.

    ``vertices (n, 3)`` [m]; ``faces`` name -> ``(f, 3)``.  Made by :meth:`closed` or :meth:`read`,
    which check it.  A hollow body has a component around it and one around each hole.
    """

    vertices: Array
    faces: dict[str, Indices]

    @classmethod
    def closed(
        cls,
        *,
        vertices: ArrayLike,
        faces: Mapping[str, ArrayLike] | ArrayLike,
        merge: float = 0.0,
    ) -> Surface:
        """From loops of three or four vertices, turned consistently and outward where they are not.

        ``faces``: name -> ``(f, 3)`` or ``(f, 4)``, or one array, then named ``"surface"``;
        quadrilaterals are cut along their first diagonal; vertices that no loop uses are left
        out.  Vertices closer than ``merge`` times the size of the surface become one, and what
        loses its area by that is dropped.  Raises ``InputError`` for a surface that is open, has
        two vertices at one place, a triangle without area, touches or crosses itself, has two
        sheets that only round-off keeps apart, has one side only, or numbers that are not finite.
        """
        points = np.asarray(vertices, dtype=np.float64)
        require(
            points.ndim == 2 and points.shape[1] == 3,
            f"vertices must have shape (n, 3), got {points.shape}",
        )
        named = faces if isinstance(faces, Mapping) else {UNNAMED: faces}
        loops = [(name, _triangles(name, face, len(points))) for name, face in named.items()]
        names = [name for name, face in loops for _ in range(len(face))]
        require(len(names) > 0, "the surface has no triangles")
        triangles = np.concatenate([face for _, face in loops])
        if merge > 0.0:
            finite = points[np.isfinite(points).all(axis=1)]
            size = float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 0.0
            if len(finite) == len(points):
                triangles = joined(points, triangles, merge * size)
        proper = np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)
        require(
            merge > 0.0 or bool(proper.all()),
            f"{np.sum(~proper)} triangles of the surface use a vertex twice; remove them",
        )
        triangles = triangles[proper]
        require(len(triangles) > 0, "the surface has no triangles with an area")
        used, triangles = np.unique(triangles, return_inverse=True)
        triangles = triangles.reshape(-1, 3)
        points = points[used]
        check_triangles(points, triangles)
        triangles = oriented(points, triangles)
        of = np.array(names)[proper]
        return cls(points, {name: triangles[of == name] for name in np.unique(of).tolist()})

    @classmethod
    def read(cls, path: str | Path, *, unit: Unit = "m") -> Surface:
        """From ``.stl``, ``.ply``, ``.obj``, ``.msh`` or ``.vtu``.

        ``unit``: one of :data:`~sphsolid.geometry.units.UNITS` or metres as a number.  Names: the
        physical surfaces of ``.msh``, the tags of ``.vtu``, the solids of ``.stl`` where there
        are several.  Vertices of ``.stl`` are merged.  Raises ``InputError`` for a file that
        cannot be read, and as :meth:`closed` does.
        """
        scale = metres(unit, f"surface file {path}")
        facets = read_facets(path_of(path))
        try:
            return cls.closed(
                vertices=scale * facets.points, faces=facets.faces, merge=facets.merge
            )
        except InputError as error:
            raise InputError(f"{path}: {error}") from error

    @cached_property
    def triangles(self) -> Indices:
        """All triangles ``(t, 3)``, by name in alphabetic order."""
        return np.concatenate([self.faces[name] for name in sorted(self.faces)])

    @cached_property
    def _moments(self) -> tuple[float, Array]:
        # About the mean, so that a body far from the origin keeps its digits.
        centre = self.vertices.mean(axis=0)
        a, b, c = (self.vertices[self.triangles[:, k]] - centre for k in range(3))
        share = np.einsum("nd,nd->n", a, np.cross(b, c)) / 6.0
        volume = float(share.sum())
        return volume, share @ (a + b + c) / 4.0 + volume * centre

    @property
    def volume(self) -> float:
        """``int dV = sum of X . A / 3`` [m^3]."""
        return self._moments[0]

    @property
    def first_moments(self) -> Array:
        """``int X dV (3,)`` [m^4]."""
        return self._moments[1]

    @cached_property
    def edge(self) -> float:
        """Median length of the edges [m]."""
        corner = self.vertices[self.triangles]
        return float(np.median(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)))

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Which points ``(n, 3)`` lie inside: their winding number is one; on it, it is less."""
        return np.asarray(winding_numbers(points, self.vertices, self.triangles) > 1.0 - 1.0e-6)

    def distance(
        self, points: Array, *, resolution: float | None = None, reach: float = np.inf
    ) -> Distance:
        """How far points ``(n, 3)`` lie from the surface; see ``distance_to_surface``."""
        resolution = self.edge / 6.0 if resolution is None else resolution
        return distance_to_surface(
            points, self.vertices, self.triangles, resolution=resolution, reach=reach
        )


def _triangles(name: str, face: ArrayLike, count: int) -> Indices:
    loops = np.asarray(face)
    if loops.size == 0:
        return np.empty((0, 3), dtype=np.int64)
    if loops.ndim != 2 or loops.shape[1] not in (3, 4) or loops.dtype.kind not in "iu":
        raise InputError(
            f"face {name!r} must be integers of shape (f, 3) or (f, 4), got {loops.dtype} of shape "
            f"{loops.shape}"
        )
    require(
        int(loops.min()) >= 0 and int(loops.max()) < count,
        f"face {name!r} names vertices {loops.min()} to {loops.max()}; there are 0 to {count - 1}",
    )
    return halves(loops)
