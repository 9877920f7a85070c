"""Delaunay tetrahedra of points inside a closed surface, with volumes that fit it exactly.

A particle's volume is its Voronoi cell's within the tetrahedra (see ``dual_volumes``).  A quarter
of each tetrahedron would be far more uneven: on a lattice it deviates by 30 % where Voronoi's does
not at all.  The tetrahedra fill the body only nearly, since on a curved surface their outer facets
need not be its triangles.  Both volumes, of particles and of cells, are therefore changed such that
either sum has the volume and the first moments that the surface encloses.  The relative change is
the smallest one in the least-squares sense.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, require
from sphsolid.geometry.cell_shape import TETRAHEDRON
from sphsolid.geometry.delaunay import delaunay, open_facets, tetrahedron_volumes
from sphsolid.geometry.dual_volumes import corner_parts
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.mesh import TetMesh
from sphsolid.geometry.surface import Surface
from sphsolid.geometry.surface_parts import SurfacePart, surface_parts

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Least volume of a cell over the cube of its longest edge; below it is a flat one.
_FLAT = 1.0e-7
#: How far the outer facets of the cells may lie off the surface, over their edge.
_OFF_SURFACE = 0.2
#: Largest relative change of a cell's volume.
LARGEST_CHANGE = 0.2


@dataclass(frozen=True)
class PointMesh(TetMesh):
    """Tetrahedra between points, each of which stands for ``shares (C,)`` times its volume.

    ``corner_shares (C, 4)``: the part that a particle has of it, over a quarter of its volume.
    ``faces`` are the triangles of the surface, which need not be facets of the cells.
    ``largest_change``: of the volume of a cell or particle, relatively.
    """

    shares: Array
    corner_shares: Array
    largest_change: float

    @property
    def filling(self) -> Array:
        """See :attr:`shares`."""
        return self.shares

    @property
    def fits_outline(self) -> bool:
        """False: the triangles of the surface need not be facets of the cells."""
        return False

    @property
    def corner_filling(self) -> Array:
        """See :attr:`corner_shares`."""
        return self.corner_shares


@dataclass(frozen=True)
class _Filling:
    """Cells ``(C, 4)`` of one part with their shares, see :class:`PointMesh`."""

    cells: Indices
    shares: Array
    corner_shares: Array
    largest_change: float


def point_mesh(surface: Surface, points: Array) -> PointMesh:
    """Particles on the vertices of ``surface`` and on ``points (n, 3)`` inside it.

    Bodies apart from each other are filled one by one, so no cell joins them and each has its
    own volume and moments.  Raises ``InputError`` where the cells between the particles do not
    follow the surface, a particle gets no volume, or a cell's volume would change by more than
    ``LARGEST_CHANGE``.
    """
    parts = surface_parts(surface)
    particles = np.concatenate([surface.vertices, points])
    if len(parts) == 1:
        filling = _filling(surface, points)
    else:
        filling = _joined([_part(part, surface, points) for part in parts])
        lost = np.setdiff1d(np.arange(len(particles)), filling.cells)
        require(
            len(lost) == 0,
            f"{len(lost)} points lie in none of the {len(parts)} parts that the surface encloses, "
            f"for instance the one at X = {particles[lost[:1]].ravel().tolist()} m; leave them out",
        )
    spacing = _spacing(particles, filling.cells, surface.volume)
    return PointMesh(
        particles, filling.cells, surface.faces, spacing, is_lattice=False,
        shares=filling.shares, corner_shares=filling.corner_shares,
        largest_change=filling.largest_change,
    )  # fmt: skip


def _part(part: SurfacePart, whole: Surface, points: Array) -> _Filling:
    """The filling of one part, numbered as in the whole."""
    mine = np.flatnonzero(part.surface.contains(points))
    filling = _filling(part.surface, points[mine])
    number = np.concatenate([part.vertices, len(whole.vertices) + mine])
    return replace(filling, cells=number[filling.cells])


def _joined(parts: list[_Filling]) -> _Filling:
    return _Filling(
        np.concatenate([part.cells for part in parts]),
        np.concatenate([part.shares for part in parts]),
        np.concatenate([part.corner_shares for part in parts]),
        max(part.largest_change for part in parts),
    )


def _filling(surface: Surface, points: Array) -> _Filling:
    particles = np.concatenate([surface.vertices, points])
    cells = delaunay(particles)
    inside = surface.contains(particles[cells].mean(axis=1))
    flat = _is_flat(particles, cells)
    kept = cells[inside & ~flat]
    volume = tetrahedron_volumes(particles, kept)
    require(len(kept) > 0, "no cell between the points lies inside the surface; add points")
    _check_follows(surface, particles, kept, cells[flat])
    parts = corner_parts(particles, kept)
    held: Array = np.bincount(
        kept.ravel(), weights=parts.ravel(), minlength=len(particles)
    ).astype(np.float64)
    empty = np.flatnonzero(held <= 0.0)
    require(
        len(empty) == 0,
        f"{len(empty)} particles get no volume, for instance the one at X = "
        f"{particles[empty[:1]].ravel().tolist()} m; refine the surface there, or add points",
    )
    cell_change = _change(surface, particles[kept].mean(axis=1), volume)
    change = _change(surface, particles, held)
    corner_shares = parts * (1.0 + change[kept]) / (0.25 * volume[:, None])
    largest = float(max(np.max(np.abs(cell_change)), np.max(np.abs(change))))
    if largest > LARGEST_CHANGE:
        raise InputError(
            f"the cells between the points hold {volume.sum():.6g} m^3 and the surface encloses "
            f"{surface.volume:.6g} m^3: a particle or cell would change its volume by "
            f"{100.0 * largest:.3g} %, allowed are {100.0 * LARGEST_CHANGE:g} %; refine the "
            "surface or add points"
        )
    return _Filling(kept, 1.0 + cell_change, corner_shares, largest)


def _is_flat(particles: Array, cells: Indices) -> NDArray[np.bool_]:
    corner = particles[cells]
    edges = corner[:, [0, 0, 0, 1, 1, 2]] - corner[:, [1, 2, 3, 2, 3, 3]]
    longest = np.max(np.sum(edges**2, axis=2), axis=1)
    return np.asarray(tetrahedron_volumes(particles, cells) <= _FLAT * longest**1.5)


def _spacing(particles: Array, cells: Indices, volume: float) -> float:
    """Edge of a cube per particle [m]; one on a face counts half, on an edge a quarter, ...

    The share of a particle is the solid angle of its cells; on a lattice of cubes this is exact.
    """
    angle = 0.0
    for k in range(4):
        a, b, c = (
            particles[cells[:, (k + m) % 4]] - particles[cells[:, k]] for m in (1, 2, 3)
        )
        la, lb, lc = (np.linalg.norm(e, axis=1) for e in (a, b, c))
        top = np.abs(np.einsum("nd,nd->n", a, np.cross(b, c)))
        bottom = la * lb * lc
        for (u, v), w in zip(((a, b), (b, c), (c, a)), (lc, la, lb), strict=True):
            bottom = bottom + np.einsum("nd,nd->n", u, v) * w
        angle += float(np.sum(2.0 * np.arctan2(top, bottom)))
    return float(np.cbrt(volume * 4.0 * np.pi / angle))


def _check_follows(surface: Surface, particles: Array, cells: Indices, flat: Indices) -> None:
    """The outer facets of the cells must have their corners on the surface, and lie along it."""
    facets, _ = open_facets(cells)
    # Where a flat cell was left out, both of its sides are open and nothing is missing.
    number = same_vertices(np.concatenate([facets, cell_facets(flat, TETRAHEDRON)]))
    facets = facets[~np.isin(number[: len(facets)], number[len(facets) :])]
    advice = "refine the surface there, move points away from it, or add points"
    exposed = np.any(facets >= len(surface.vertices), axis=1)
    corner = particles[facets]
    centre = corner.mean(axis=1)
    require(
        not np.any(exposed),
        f"the points do not fill the surface: {np.sum(exposed)} facets of the cells between them "
        f"end at an inner point, for instance near X = {_first(centre, exposed)} m; {advice}",
    )
    edge = np.max(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2), axis=1)
    off = surface.distance(centre).length > _OFF_SURFACE * edge
    require(
        not np.any(off),
        f"the cells between the points do not follow the surface: {np.sum(off)} of their outer "
        f"facets lie off it, for instance near X = {_first(centre, off)} m; {advice}",
    )


def _first(X: Array, chosen: NDArray[np.bool_]) -> list[float]:
    return [float(f"{x:.6g}") for x in X[int(np.argmax(chosen))]] if np.any(chosen) else []


def _change(surface: Surface, X: Array, volume: Array) -> Array:
    """Least ``sum v d^2`` such that ``v (1 + d)`` at ``X`` has the surface's volume and moments.

    The minimum is ``d = l . (1, X)``: four equations for the four ``l``.
    """
    origin = surface.first_moments / surface.volume
    basis = np.concatenate(
        [np.ones((len(X), 1)), (X - origin) / np.cbrt(surface.volume)], axis=1
    )
    wanted = np.array([surface.volume, 0.0, 0.0, 0.0])
    # What is lacking may be no more than rounding: it is summed with digits to spare.
    lack = wanted - np.sum(volume.astype(np.longdouble)[:, None] * basis, axis=0)
    normal = basis.T @ (volume[:, None] * basis)
    # A handful of cells may leave the four equations dependent, and then nothing to solve.
    return np.asarray(basis @ np.linalg.lstsq(normal, lack.astype(np.float64), rcond=1e-12)[0])
