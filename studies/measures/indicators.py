"""Numbers that judge a deformed body: pressure noise, twist, ranges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

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
