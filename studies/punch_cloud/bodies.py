"""The block of the punch as hexahedra, and as points with a surface around them."""

from __future__ import annotations

import numpy as np

from sphsolid.geometry import Body, GridMesh, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.scenes.punch import block

#: The block as hexahedra with the smoothing length of points, and with its own.
HEXAHEDRA, WIDEST = "hexahedra", "hexahedra, widest edge"
#: Disorder: every particle is off its place by at most this half, in spacings and components.
JITTER = 0.4


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
    if cloud in (HEXAHEDRA, WIDEST):
        return block(jitter=JITTER, seed=seed), spacing
    if cloud == "points":
        return points_of_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED
    return filled_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED


def length_of_points(body: Body, spacing: Spacing) -> float:
    """What scales the smoothing length of disordered hexahedra to that of the same points.

    A disordered grid counts its widest edge, points the edge of a cube of their mean volume: on
    cells of 25 x 33 x 25 mm these differ by a fifth, and neighbours by two thirds.
    """
    mesh = body.mesh(spacing)
    assert isinstance(mesh, GridMesh)
    return float(np.cbrt(np.sum(vertex_volumes(mesh)) / len(mesh.cells))) / mesh.widest
