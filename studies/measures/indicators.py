"""Numbers that judge a deformed body: pressure noise, twist, ranges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sphsolid.geometry.cell_shape import CORNERS
from sphsolid.geometry.mesh import HexMesh, hexahedra
from sphsolid.look.percentiles import weighted_percentile
from sphsolid.record import Snapshot

#: Noise that counts as smooth (a sine of ten spacings has 0.1) and as fluctuating, and the largest
#: share of a fluctuation that may be left where a term removes it: the same in every study.
SMOOTH, FLUCTUATES, REMOVED = 0.1, 0.15, 0.5
Array = NDArray[np.float64]
Triples = NDArray[np.int64]


def vertex_triples(mesh: HexMesh) -> tuple[Triples, ...]:
    """For each of the three directions of the cells the runs of three vertices ``(n, 3)``.

    A run follows cell edges of one local direction through two cells.
    """
    found = []
    for axis in range(3):
        starts = np.flatnonzero(CORNERS[:, axis] == 0)
        step = np.eye(3, dtype=int)[axis]
        ends = [int(np.flatnonzero((CORNERS[c] + step == CORNERS).all(axis=1))[0]) for c in starts]
        following = np.full(len(mesh.vertices), -1)
        following[mesh.cells[:, starts].ravel()] = mesh.cells[:, ends].ravel()
        found.append(_runs(following))
    return tuple(found)


def cell_triples(mesh: HexMesh) -> tuple[Triples, ...]:
    """The same for cells: runs of three that share faces in one local direction."""
    found = []
    for axis in range(3):
        behind = {
            tuple(sorted(face)): cell
            for cell, face in enumerate(mesh.cells[:, CORNERS[:, axis] == 0].tolist())
        }
        ahead = mesh.cells[:, CORNERS[:, axis] == 1].tolist()
        following = np.array([behind.get(tuple(sorted(face)), -1) for face in ahead])
        found.append(_runs(following))
    return tuple(found)


def _runs(following: NDArray[np.int64]) -> Triples:
    first = np.flatnonzero(following >= 0)
    middle = following[first]
    last = following[middle]
    inside = last >= 0
    return np.stack([first[inside], middle[inside], last[inside]], axis=1)


def pressure_noise(snapshot: Snapshot, *, above: float = -math.inf) -> float:
    """High-frequency share of the pressure, 0 to 1, in the direction where it is largest.

    In a run of three neighbours ``b, a, c`` the part of ``p_a`` that alternates is half its
    distance from the straight line between ``p_b`` and ``p_c``; the share is its root mean square
    over all runs of a direction over that of ``p - mean p``.  A checkerboard, and a saw tooth in
    one direction, has 1, a linear field 0, a sine of ten spacings 0.1.  Only points with
    ``X_2 > above`` [m] count, which leaves out a clamp and the singular stress at its corners.
    """
    at_vertices = len(snapshot.J) == len(snapshot.X)
    mesh = hexahedra(snapshot.mesh, "pressure_noise")
    triples = (vertex_triples if at_vertices else cell_triples)(mesh)
    p, X = snapshot.pressure, snapshot.stress_X
    kept = X[:, 1] > above
    weights = snapshot.stress_V[kept]
    if not kept.any():
        return 0.0
    mean = np.average(p[kept], weights=weights)
    spread = math.sqrt(float(np.average((p[kept] - mean) ** 2, weights=weights)))
    if spread == 0.0:
        return 0.0
    shares = [0.0]
    for runs in triples:
        b, a, c = runs[kept[runs].all(axis=1)].T
        if len(a) == 0:
            continue
        to_b = np.linalg.norm(X[a] - X[b], axis=1)
        to_c = np.linalg.norm(X[c] - X[a], axis=1)
        between = (to_c * p[b] + to_b * p[c]) / (to_b + to_c)
        shares.append(float(np.sqrt(np.mean((0.5 * (between - p[a])) ** 2))) / spread)
    return max(shares)


def pressure_range(snapshot: Snapshot, low: float = 1.0, high: float = 99.0) -> tuple[float, float]:
    """Percentiles of the pressure [Pa] by the volume of the points where stress is evaluated."""
    ends = weighted_percentile(snapshot.pressure, snapshot.stress_V, [low, high])
    return float(ends[0]), float(ends[1])


def twist_of_top(snapshot: Snapshot) -> float:
    """Best-fit rotation [rad] about Y of the points on the top face, in (-pi, pi]."""
    top = np.isclose(snapshot.X[:, 1], np.max(snapshot.X[:, 1]))
    before = snapshot.X[top][:, [0, 2]] @ [1.0, 1.0j]
    now = snapshot.x[top] - snapshot.x[top].mean(axis=0)
    after = now[:, [0, 2]] @ [1.0, 1.0j]
    return float(np.angle(np.sum(after * np.conj(before))))


def whole_turns(angle: float, last: float) -> float:
    """``angle`` [rad] plus the whole turns that bring it within half a turn of ``last``."""
    return angle - 2.0 * math.pi * round((angle - last) / (2.0 * math.pi))


# --- noise on points of any kind: no cells, no rows of them, are needed ---------------------------

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
