"""The block of the punch as hexahedra, and as points with a surface around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sphsolid.geometry import Body, HexMesh, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes.punch import block

#: The block as a mesh of hexahedra, and as a grid, which counts its widest edge.
HEXAHEDRA, WIDEST = "hexahedra", "hexahedra, widest edge"
#: Disorder: every particle is off its place by at most this half, in spacings and components.
JITTER = 0.4


@dataclass(frozen=True)
class Ungridded:
    """The hexahedra of a body as a file would bring them, without the planes of its grid.

    ``dx`` is then the edge of a cube of the mean volume, as it is for the same particles without a
    mesh: the same neighbours, and what differs are volumes and secondary points.  On cells of
    25 x 33 x 25 mm the widest edge is a fifth longer and sees two thirds more neighbours.
    """

    body: Body

    def mesh(self, spacing: Spacing) -> HexMesh:
        """The same vertices, cells and faces."""
        grid = self.body.mesh(spacing)
        edge = float(np.cbrt(np.sum(vertex_volumes(grid)) / len(grid.cells)))
        return HexMesh(grid.vertices, grid.cells, grid.faces, edge, is_lattice=False)

    @property
    def volume(self) -> float:
        """That of the body [m^3]."""
        return self.body.volume


def points_of_block(*, spacing: float, jitter: float, seed: int) -> PointCloud:
    """The particles of ``block(jitter=jitter, seed=seed)`` and the surface through its own.

    Nothing but positions and the triangles of the surface is taken from the mesh of the block.
    """
    mesh = block(jitter=jitter, seed=seed).mesh(spacing)
    inner = np.ones(len(mesh.vertices), dtype=bool)
    inner[mesh.boundary] = False
    surface = Surface.closed(vertices=mesh.vertices, faces=mesh.faces)
    return PointCloud(mesh.vertices[inner], surface)


def filled_block(*, spacing: float, jitter: float, seed: int) -> PointCloud:
    """The same surface filled by a lattice of its own, disordered by another seed."""
    surface = points_of_block(spacing=spacing, jitter=jitter, seed=seed).enclosed
    return PointCloud.fill(surface=surface, spacing=spacing, jitter=jitter, seed=seed + 1000)


def body_of(cloud: str, *, spacing: float, seed: int) -> tuple[Body, Spacing]:
    """A body by name and the spacing it is to be meshed with."""
    if cloud == "lattice":
        return block(), spacing
    if cloud == HEXAHEDRA:
        return Ungridded(block(jitter=JITTER, seed=seed)), spacing
    if cloud == WIDEST:
        return block(jitter=JITTER, seed=seed), spacing
    if cloud == "points":
        return points_of_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED
    return filled_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED
