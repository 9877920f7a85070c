"""What a mesh is worth as a particle body: volume, moments, closure, spacing, quality, tags."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.geometry.facets import cell_facets, same_vertices
from sphsolid.geometry.hidden import hidden_vertices
from sphsolid.geometry.integrals import (
    cell_volumes_and_centroids,
    local_spacing,
    vertex_volumes,
)
from sphsolid.geometry.line_of_sight import near_hiding
from sphsolid.geometry.mesh import Mesh
from sphsolid.geometry.outline import Outline
from sphsolid.geometry.overlap import refuse_overlap

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Vector = tuple[float, float, float]

#: Edges of a cell at each of its corners, as the local corners they lead to, right-handed.
_EDGES = {
    8: [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)],
    4: [(1, 2, 3), (2, 0, 3), (0, 1, 3), (0, 2, 1)],
}


#: Radius within which neighbours are counted, in local spacings: the support of the default
#: smoothing function off a lattice.
REACH = 2.0


@dataclass(frozen=True)
class TagReport:
    """A tag of the boundary: its facets and their area [m^2]."""

    name: str
    facets: int
    area: float


@dataclass(frozen=True)
class MeshReport:
    """What :func:`check_mesh` found; prints as a block of text.

    ``volume_of_cells``, ``volume_of_particles`` (sum of ``V_a``) and ``volume_in_boundary`` [m^3]
    are the same volume found in three ways, ``centroid_of_particles`` and
    ``centroid_in_boundary`` [m] the same point in two; ``open_area``: ``|sum A_a N_a|`` over the
    area of the boundary.  ``spacing``, ``smallest_spacing``, ``largest_spacing`` [m]: nominal, and
    the extremes of :func:`~sphsolid.geometry.integrals.local_spacing`; ``smallest_distance`` [m]
    of two vertices that see each other; ``neighbours``: fewest, mean and most vertices within
    :data:`REACH` local spacings of a vertex, nearly those that a particle will have;
    ``left_out``: pairs within that reach that are not counted, because the straight line between
    them leaves the body (:mod:`~sphsolid.geometry.line_of_sight`); ``worst_quality`` and
    ``mean_quality`` of the cells, see :func:`cell_quality`; ``parts``: pieces that share no facet;
    ``size`` [m] the diagonal of the box around the body.
    """

    cell: str
    cells: int
    vertices: int
    unused_vertices: int
    midside_vertices: int
    parts: int
    size: float
    volume_of_cells: float
    volume_of_particles: float
    volume_in_boundary: float
    centroid_of_particles: Vector
    centroid_in_boundary: Vector
    area: float
    open_area: float
    spacing: float
    smallest_spacing: float
    largest_spacing: float
    smallest_distance: float
    neighbours: tuple[int, float, int]
    left_out: int
    worst_quality: float
    mean_quality: float
    tags: tuple[TagReport, ...]

    @property
    def volume_error(self) -> float:
        """Largest relative difference of the three volumes."""
        found = (self.volume_of_particles, self.volume_in_boundary)
        return max(abs(volume / self.volume_of_cells - 1.0) for volume in found)

    @property
    def moment_error(self) -> float:
        """Distance of the two centroids over the size of the body."""
        return math.dist(self.centroid_of_particles, self.centroid_in_boundary) / self.size

    def __str__(self) -> str:
        """A block of lines, values with their units."""
        x, y, z = self.centroid_of_particles
        fewest, mean, most = self.neighbours
        left_out = f"{self.unused_vertices} unused, {self.midside_vertices} midside left out"
        width = max(len("tag"), *(len(tag.name) for tag in self.tags)) if self.tags else 3
        rows = [
            f"cells        {self.cells} of type {self.cell}, in {self.parts} part(s)",
            f"vertices     {self.vertices} ({left_out})",
            f"volume       {self.volume_of_cells:.9g} m^3; sum of V_a and boundary integral agree "
            f"to {self.volume_error:.1e}",
            f"centroid     ({x:.6g}, {y:.6g}, {z:.6g}) m; sum of V_a X_a and boundary integral "
            f"agree to {self.moment_error:.1e} of the size",
            f"boundary     {self.area:.9g} m^2, open by {self.open_area:.1e} of it",
            f"spacing      {self.spacing:.4g} m; around a vertex {self.smallest_spacing:.4g} to "
            f"{self.largest_spacing:.4g} m; smallest distance {self.smallest_distance:.4g} m",
            f"neighbours   {fewest} to {most} of a vertex, {mean:.1f} on average, within "
            f"{REACH:g} spacings around it",
            f"left out     {self.left_out} pairs as near: a slot, notch or gap is between them",
            f"quality      scaled Jacobian {self.worst_quality:.3f} at worst, "
            f"{self.mean_quality:.3f} on average (best 1)",
            f"{'tag':<{width}}  {'facets':>8}  {'area [m^2]':>12}",
            *(f"{t.name:<{width}}  {t.facets:>8}  {t.area:>12.6g}" for t in self.tags),
        ]
        return "\n".join(rows)


def check_mesh(mesh: Mesh, *, unused_vertices: int = 0, midside_vertices: int = 0) -> MeshReport:
    """Measure a mesh; the numbers of vertices left out of it are repeated in the report.

    Volume and first moments come from the particles, ``sum V_a`` and ``sum V_a X_a``, and from
    the divergence theorem over the tagged facets,

        V = 1/3 int X . n dA,    int X_d dV = 1/2 int X_d^2 n_d dA,

    both without quadrature error, so that they differ by round-off unless a facet is missing,
    there twice or turned inwards.  Raises ``InputError`` for an inverted or flat cell, and for
    parts that overlap.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle = 0.5 * (low + high)
    V = vertex_volumes(mesh)
    refuse_overlap("the mesh", mesh)
    cell_volume, _ = cell_volumes_and_centroids(mesh)
    particles = middle + (V @ (mesh.vertices - middle)) / V.sum()
    tags, volume, moment, closure = [], 0.0, np.zeros(3), np.zeros(3)
    for name in sorted(mesh.faces):
        area, flux, its_moment, vector = _boundary_integrals(mesh, mesh.faces[name], middle)
        tags.append(TagReport(name, len(mesh.faces[name]), area))
        volume, moment, closure = volume + flux, moment + its_moment, closure + vector
    total = math.fsum(tag.area for tag in tags)
    around = local_spacing(mesh)
    quality = cell_quality(mesh)
    # The smoothing function is zero at the edge, where a lattice has neighbours up to round-off.
    near, left_out, smallest = _neighbours(mesh, (1.0 - 1.0e-9) * REACH * around)
    return MeshReport(
        cell=mesh.shape.name,
        cells=len(mesh.cells),
        vertices=len(mesh.vertices),
        unused_vertices=unused_vertices,
        midside_vertices=midside_vertices,
        parts=_parts(mesh),
        size=float(np.linalg.norm(high - low)),
        volume_of_cells=math.fsum(cell_volume),
        volume_of_particles=math.fsum(V),
        volume_in_boundary=volume,
        centroid_of_particles=_vector(particles),
        centroid_in_boundary=_vector(middle + moment / volume),
        area=total,
        open_area=float(np.linalg.norm(closure)) / total,
        spacing=mesh.spacing,
        smallest_spacing=float(around.min()),
        largest_spacing=float(around.max()),
        smallest_distance=smallest,
        neighbours=(int(near.min()), float(near.mean()), int(near.max())),
        left_out=left_out,
        worst_quality=float(quality.min()),
        mean_quality=float(quality.mean()),
        tags=tuple(tags),
    )


def cell_quality(mesh: Mesh) -> Array:
    """Scaled Jacobian of each cell ``(C,)``: one for a cube or a regular tetrahedron, 0 if flat.

    The triple product of the edges at a corner over the product of their lengths; the smallest
    over the corners of a hexahedron, ``sqrt(2)`` times the smallest for a tetrahedron.
    """
    corners = mesh.vertices[mesh.cells]
    found = np.full(len(corners), np.inf)
    for corner, ends in enumerate(_EDGES[mesh.shape.corners]):
        edges = corners[:, ends] - corners[:, corner, None]
        found = np.minimum(
            found, np.linalg.det(edges) / np.linalg.norm(edges, axis=2).prod(axis=1)
        )
    return found if mesh.shape is HEXAHEDRON else math.sqrt(2.0) * found


def _neighbours(mesh: Mesh, reach: Array) -> tuple[Indices, int, float]:
    """Vertices seen within ``reach (N,)`` of each, pairs hidden, and the smallest distance seen."""
    X, outline = mesh.vertices, Outline.of(mesh)
    tree = cKDTree(X)
    near = tree.query_ball_point(X, reach, return_length=True).astype(np.int64) - 1
    nearest = tree.query(X, k=2)[0][:, 1]
    some = np.flatnonzero(near_hiding(outline, X, float(reach.max())))
    if len(some) == 0:
        return near, 0, float(nearest.min())
    found = tree.query_ball_point(X[some], reach[some], return_sorted=True)
    row = np.repeat(some, [len(of) for of in found])
    column = np.concatenate(found).astype(np.int64)
    other = row != column
    row, column = row[other], column[other]
    hidden = hidden_vertices(outline, row, column)
    near -= np.bincount(row[hidden], minlength=len(X))
    key = np.minimum(row, column) * len(X) + np.maximum(row, column)
    nearest[some] = np.inf
    distance = np.linalg.norm(X[row] - X[column], axis=1)[~hidden]
    smallest = min(float(nearest.min()), float(distance.min(initial=np.inf)))
    return near, len(np.unique(key[hidden])), smallest


def _boundary_integrals(
    mesh: Mesh, facets: NDArray[np.int64], origin: Array
) -> tuple[float, float, Array, Array]:
    """Area, ``1/3 int X . n dA``, ``1/2 int X_d^2 n_d dA`` and ``int n dA`` of some facets."""
    corners = mesh.vertices[facets] - origin
    area, flux, moment, vector = 0.0, 0.0, np.zeros(3), np.zeros(3)
    for point in mesh.shape.facet_rule:
        tangents = np.einsum("fcd,ck->kfd", corners, point.slopes)
        n = point.weight * np.cross(tangents[0], tangents[1])
        X = np.einsum("fcd,c->fd", corners, point.N)
        area += float(np.linalg.norm(n, axis=1).sum())
        flux += float(np.sum(X * n)) / 3.0
        moment += 0.5 * np.sum(X**2 * n, axis=0)
        vector += n.sum(axis=0)
    return area, flux, moment, vector


def _parts(mesh: Mesh) -> int:
    """Pieces of the mesh whose cells share no facet."""
    number = same_vertices(cell_facets(mesh.cells, mesh.shape))
    cell = np.repeat(np.arange(len(mesh.cells)), len(mesh.shape.facets))
    order = np.argsort(number, kind="stable")
    same = np.diff(number[order]) == 0
    a, b = cell[order[:-1][same]], cell[order[1:][same]]
    link = coo_array((np.ones(len(a)), (a, b)), shape=(len(mesh.cells), len(mesh.cells)))
    return int(connected_components(link, directed=False)[0])


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return (x, y, z)
