"""Bodies whose parts fill one space twice, which is no material: refused."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import GridMesh, Mesh
from sphsolid.geometry.mesh_defects import place
from sphsolid.geometry.outline import Outline

Array = NDArray[np.float64]
#: How deep one part must reach into another, over the size of a facet, to overlap with it: facets
#: of parts that touch along a curved surface reach into each other by less.
_DEPTH = 0.05
#: Places of a triangle that are tried, as shares of its corners.
_PLACES = np.array([[0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9], [1, 1, 1]])
_PLACES = _PLACES / _PLACES.sum(axis=1, keepdims=True)


def refuse_overlap(what: str, mesh: Mesh) -> None:
    """Raises ``InputError`` where the boundary of one part lies inside another.

    A boundary goes once round every point of a body; a point that it goes round twice belongs to
    two parts.  The message compares the volume of the cells with the space that they fill, each
    cell's share of it being its volume over how often its centroid is covered.
    """
    # Grids and points with a surface, checked for itself, cannot overlap.
    if isinstance(mesh, GridMesh) or not mesh.fits_outline:
        return
    outline = Outline.of(mesh)
    volume, centroid = cell_volumes_and_centroids(mesh)
    total = math.fsum(volume)
    room = float(np.prod(np.ptp(mesh.vertices, axis=0)))
    if len(outline.hiding) == 0 and total <= (1.0 + 1.0e-9) * room:
        return
    corner = mesh.vertices[outline.triangles]
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(area, axis=1)[:, None]
    below = corner - (_DEPTH * area / np.sqrt(np.where(size > 0.0, size, 1.0)))[:, None]
    points = np.einsum("pk,tkd->tpd", _PLACES, below).reshape(-1, 3)
    twice = outline.windings(points) > 1.5
    if not np.any(twice):
        return
    filled = math.fsum(volume / np.maximum(1.0, np.rint(outline.windings(centroid))))
    raise InputError(
        f"{what}: parts of the body overlap, for instance at {place(points[np.argmax(twice)])}: "
        f"the cells hold {total:.6g} m^3 in a space of about {filled:.6g} m^3. What is there twice "
        "has twice the mass and stiffness: unite or fragment the parts before meshing, or move "
        "them apart"
    )
