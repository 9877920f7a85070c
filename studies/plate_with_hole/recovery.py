"""Hoop stress at the hole's edge, from stresses at particles or in the middle of cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
#: Cells to a fit, ten columns of four layers on the mesh of hexahedra, and how many more at a time
#: where these do not determine a quadratic: condition number of the terms, in units of the patch.
PATCH, MORE, LARGEST_CONDITION = 40, 8, 100.0


def hoop(X: Array, stress: Array) -> Array:
    """``t . sigma t (n,)`` with ``t`` around the Z axis, ``stress (n, 3, 3)`` at ``X (n, 3)``."""
    r = np.hypot(X[:, 0], X[:, 1])
    t = np.stack([-X[:, 1] / r, X[:, 0] / r], axis=1)
    return np.asarray(np.einsum("ni,nij,nj->n", t, stress[:, :2, :2], t))


def at_cells(stress: Array, cells: NDArray[np.int64]) -> Array:
    """Means over the corners of cells ``(C, 3, 3)``: the interpolant in the middle of each."""
    return np.asarray(stress[cells].mean(axis=1))


def fitted(X: Array, stress: Array, at: Array) -> Array:
    """Stress ``(m, 3, 3)`` at places ``at (m, 2)``, a mean over the thickness.

    The complete quadratic in X and Y that fits best, in the least-squares sense, the ``PATCH``
    values nearest in the plane, or more where they are in too few rows: patch recovery
    [Zienkiewicz1992], which reaches the edge of the hole from the middles of the cells beside it.
    """
    tree = cKDTree(X[:, :2])
    out = np.empty((len(at), 3, 3))
    for k, place in enumerate(at):
        for size in range(min(PATCH, len(X)), len(X) + 1, MORE):
            _, patch = tree.query(place, k=size)
            d = X[patch, :2] - place
            x, y = (d / np.abs(d).max(axis=0)).T
            terms = np.stack([np.ones_like(x), x, y, x**2, x * y, y**2], axis=1)
            if np.linalg.cond(terms) <= LARGEST_CONDITION:
                break
        fit = np.linalg.lstsq(terms, stress[patch].reshape(size, 9), rcond=None)[0]
        out[k] = fit[0].reshape(3, 3)
    return out
