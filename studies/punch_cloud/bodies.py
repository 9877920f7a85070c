"""The block of the punch as hexahedra, and as points with a surface around them."""

from __future__ import annotations

import numpy as np

from sphsolid.geometry import Body, PointCloud, Surface
from sphsolid.geometry.body import AS_MESHED, Spacing
from sphsolid.scenes.punch import block

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
    if cloud == "hexahedra":
        return block(jitter=JITTER, seed=seed), spacing
    if cloud == "points":
        return points_of_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED
    return filled_block(spacing=spacing, jitter=JITTER, seed=seed), AS_MESHED
