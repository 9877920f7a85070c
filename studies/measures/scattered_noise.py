"""Pressure noise on points of any kind: no cells, no rows of them, are needed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.record import Snapshot

Array = NDArray[np.float64]
#: Neighbours of a point are those within this many spacings: 18 inside a lattice of cubes.
REACH = 1.6
#: Weight of a point in its own fit, where a neighbour at one spacing has 1.
_OWN = 2.0
#: What is left of a checkerboard inside a lattice: nothing of it is in the mean of the neighbours
#: (6 of weight 1 and one sign, 12 of weight 1/2 and the other), 2 of 14 in its own weight.
_CHECKERBOARD = 1.0 - _OWN / 14.0


def scattered_noise(snapshot: Snapshot, *, spacing: float) -> float:
    """High-frequency share of the pressure, 0 to about 1, at points in any order or disorder.

    The part of ``p_a`` that alternates is its distance from the linear function that fits it and
    its neighbours ``b`` best in the least-squares sense, with weights ``(dx / r_ab)^2`` and 2 for
    ``a`` itself.  The share is its root mean square over that of ``p - mean p``, both weighted by
    volume, over that of a checkerboard inside a lattice, 6/7.  So inside a lattice a checkerboard
    has 1, a saw tooth in one direction 1, a linear field 0 and a sine of ten spacings 0.1, as in
    :func:`~studies.measures.indicators.pressure_noise`; a linear field has 0 in any disorder.  A
    point's own weight keeps those at a face, edge or corner, where the fit is one-sided, from
    counting more than those inside.  ``spacing`` [m] is given, because that of a mesh and that of a
    cloud on the same points differ where cells are no cubes, and with it who is a neighbour.
    """
    return noise_of(snapshot.stress_X, snapshot.stress_V, snapshot.pressure, spacing)


def noise_of(X: Array, V: Array, p: Array, spacing: float) -> float:
    """The same of values ``p (n,)`` at ``X (n, 3)`` [m] with volumes ``V (n,)``."""
    alternating = departure(X, p, spacing) / _CHECKERBOARD
    mean = np.average(p, weights=V)
    spread = math.sqrt(float(np.average((p - mean) ** 2, weights=V)))
    if spread <= 1.0e-14 * abs(mean) or spread == 0.0:
        return 0.0
    return math.sqrt(float(np.average(alternating**2, weights=V))) / spread


def departure(X: Array, p: Array, spacing: float) -> Array:
    """Distance ``(n,)`` of ``p`` from the linear fit around each point."""
    pairs = cKDTree(X).query_pairs(REACH * spacing, output_type="ndarray")
    own = np.arange(len(X))
    a = np.concatenate([pairs[:, 0], pairs[:, 1], own])
    b = np.concatenate([pairs[:, 1], pairs[:, 0], own])
    offset = (X[b] - X[a]) / spacing
    squared = np.einsum("nd,nd->n", offset, offset)
    weight = np.where(a == b, _OWN, 1.0 / np.maximum(squared, 1.0e-300))
    # Relative to the point itself: the fit is of differences, and large means cost no digits.
    terms = np.concatenate([np.ones((len(a), 1)), offset], axis=1)
    matrix, right = np.zeros((len(X), 4, 4)), np.zeros((len(X), 4))
    np.add.at(matrix, a, weight[:, None, None] * terms[:, :, None] * terms[:, None, :])
    np.add.at(right, a, (weight * (p[b] - p[a]))[:, None] * terms)
    # Too few neighbours for a fit: the smallest one that there is.
    fit = np.einsum("nij,nj->ni", np.linalg.pinv(matrix, rcond=1.0e-10, hermitian=True), right)
    return -fit[:, 0]
