"""Fields of both solvers at the same places: particles at vertices, elements in cells.

A particle's value is that of a vertex, up to the very surface; an element's is a mean over a
cell.  Side by side the first look larger for no other reason, so both are taken over cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.record.snapshot import HasFields, PointField

Array = NDArray[np.float64]


def in_cells(snapshot: HasFields, name: str) -> PointField:
    """A field over the cells of the mesh: their centroids, volumes and values ``(C, ...)``.

    Of particles the mean of a cell's corners, of finite elements what the element has.  Raises
    ``InputError`` for a field at any other points.
    """
    found = snapshot.field(name)
    cells = snapshot.mesh.cells
    V, X = cell_volumes_and_centroids(snapshot.mesh)
    if found.is_at(snapshot.X):
        return PointField(X, V, np.asarray(found.values[cells].mean(axis=1)))
    if len(found.X) != len(cells):
        raise InputError(
            f"in_cells: {name} is known at {len(found.X)} points, which are neither the "
            f"{len(snapshot.X)} vertices nor the {len(cells)} cells of the mesh"
        )
    return PointField(X, V, found.values)


def cell_means_at_vertices(snapshot: HasFields, name: str) -> Array:
    """The same carried to the vertices ``(N,)``: means of the adjacent cells by volume."""
    found = in_cells(snapshot, name)
    cells = snapshot.mesh.cells
    corner = cells.ravel()
    volume = np.repeat(found.V, cells.shape[1])
    size = len(snapshot.X)
    total = np.bincount(corner, weights=volume * np.repeat(found.values, cells.shape[1]),
                        minlength=size)  # fmt: skip
    return np.asarray(total / np.bincount(corner, weights=volume, minlength=size))
