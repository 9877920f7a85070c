"""What a mode looks like: where it sits, what it alternates with, who sees it, and a name for it.

Names, in the order in which they are tried:

* ``checkerboard``: (-1)^(i+j+k) times something smooth, in ``u`` or in ``J``;
* ``corner``, ``surface``: at particles on edges and corners, or on the boundary;
* ``hourglass``: alternates along two axes, or varies from particle to particle with next to no
  gradient at the secondary particles, so that the stabilisation does not see it;
* ``layers``: alternates along one axis;
* ``short wave`` or ``smooth`` by the mean difference of neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid import Simulation

Field = NDArray[np.inexact]
Array = NDArray[np.float64]
#: Shares from which a feature gives the name.
MOST, ALMOST_ALL, ALMOST_NOTHING = 0.5, 0.9, 0.05
#: Mean squared difference of neighbours over its largest value from which a mode is a short wave.
ROUGH = 0.25


@dataclass(frozen=True)
class Shape:
    """Shares, all in [0, 1] but ``seen``, which is about one for a smooth mode.

    ``corner`` of the volume-weighted square on edges and corners, ``boundary`` on the boundary;
    ``alternating[n]`` in patterns that alternate along ``n`` axes (times constants and linears,
    0: smooth); ``roughness`` mean squared difference of neighbours over four times the mean square;
    ``seen`` squared gradient at the secondary particles (without them: at the particles) over that
    of neighbours' differences; ``field`` is ``"u"`` or ``"J"``.
    """

    field: str
    corner: float
    boundary: float
    alternating: tuple[float, float, float, float]
    roughness: float
    seen: float

    @property
    def name(self) -> str:
        """See the module text."""
        of_J = " of J" if self.field == "J" else ""
        if self.alternating[3] >= MOST:
            return "checkerboard" + of_J
        if self.corner >= MOST:
            return "corner" + of_J
        if self.boundary >= ALMOST_ALL:
            return "surface" + of_J
        unseen = self.roughness >= ROUGH and self.seen < ALMOST_NOTHING
        if self.alternating[2] >= MOST or unseen:
            return "hourglass" + of_J
        if self.alternating[1] >= MOST:
            return "layers" + of_J
        return ("short wave" if self.roughness >= ROUGH else "smooth") + of_J


def shape(simulation: Simulation, u: Field, J: Field) -> Shape:
    """Shape of a mode of a box with ``u (N, 3)`` in units of ``l`` and ``J (N,)``."""
    V = simulation.cloud.V
    of_u = float(np.sum(V[:, None] * np.abs(u) ** 2))
    of_J = float(np.sum(V * np.abs(J) ** 2))
    # J moves along with u in any pressure wave, by less than one for a displacement of one.
    field, f = ("u", u) if of_u >= 0.05 * of_J else ("J", J[:, None])
    total = float(np.sum(V[:, None] * np.abs(f) ** 2))
    density = V * np.sum(np.abs(f) ** 2, axis=1) / total
    faces = np.count_nonzero(np.abs(_outermost(simulation)), axis=1)
    alternating = _alternating(simulation, f, total)
    a, b = _edges(simulation)
    jump = np.sum(np.abs(f[a] - f[b]) ** 2, axis=1)
    size = np.sum(np.abs(f[a]) ** 2 + np.abs(f[b]) ** 2, axis=1)
    return Shape(
        field=field,
        corner=float(np.sum(density[faces >= 2])),
        boundary=float(np.sum(density[faces >= 1])),
        alternating=alternating,
        roughness=float(np.sum(jump) / (2.0 * np.sum(size))),
        seen=_seen(simulation, f, float(np.sum(jump)), len(a)),
    )


def lattice_places(simulation: Simulation) -> NDArray[np.int64]:
    """Places ``(i, j, k)`` of the particles of a box ``(N, 3)``, also of a disordered one."""
    first = simulation.cloud.mesh.cells[0]
    plane, line = int(first[1] - first[0]), int(first[3] - first[0])
    a = np.arange(simulation.cloud.size)
    return np.stack([a // plane, (a % plane) // line, a % line], axis=1)


def name_of_wave(k: Array) -> str:
    """Name of a plane wave ``k l (3,)`` of the interior."""
    alternates = int(np.count_nonzero(np.abs(k) > 0.9 * np.pi))
    if alternates:
        return ("", "layers", "hourglass", "checkerboard")[alternates]
    return "short wave" if np.max(np.abs(k)) > 0.45 * np.pi else "smooth"


def _outermost(simulation: Simulation) -> NDArray[np.int64]:
    """Per axis 1 or -1 on the two outermost layers, else 0."""
    place = lattice_places(simulation)
    last = place.max(axis=0)
    return (place == last).astype(np.int64) - (place == 0).astype(np.int64)


def _edges(simulation: Simulation) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    place = lattice_places(simulation)
    last = place.max(axis=0)
    first = simulation.cloud.mesh.cells[0]
    strides = [int(first[1] - first[0]), int(first[3] - first[0]), 1]
    starts = [np.flatnonzero(place[:, d] < last[d]) for d in range(3)]
    ends = [start + stride for start, stride in zip(starts, strides, strict=True)]
    return np.concatenate(starts), np.concatenate(ends)


def _alternating(
    simulation: Simulation, f: Field, total: float
) -> tuple[float, float, float, float]:
    place, root = lattice_places(simulation), np.sqrt(simulation.cloud.V)
    smooth = np.concatenate([np.ones((len(place), 1)), place - place.mean(axis=0)], axis=1)
    share = np.zeros(4)
    for signs in np.ndindex(2, 2, 2):
        sign = 1.0 - 2.0 * ((place @ signs) % 2)
        basis = np.linalg.qr((root * sign)[:, None] * smooth)[0]
        found = float(np.sum(np.abs(basis.T @ (root[:, None] * f)) ** 2)) / total
        # The best pattern of a kind: patterns overlap on a finite block, so shares do not add up.
        share[sum(signs)] = max(share[sum(signs)], found)
    return float(share[0]), float(share[1]), float(share[2]), float(share[3])


def _seen(simulation: Simulation, f: Field, jump: float, edges: int) -> float:
    q, cloud = simulation.secondary, simulation.cloud
    if q is None:
        pairs, G, V = cloud.pairs, cloud.gradients.kinematic, cloud.V
    else:
        pairs, G, V = q.pairs, q.sample[:, :3], q.V
    terms = f[pairs.indices][:, :, None] * G[:, None, :]
    gradient = np.add.reduceat(terms, pairs.indptr[:-1], axis=0)
    squared = float(np.sum(V * np.sum(np.abs(gradient) ** 2, axis=(1, 2)))) / float(np.sum(V))
    # A linear field has a squared gradient of three axes for the mean difference along one.
    return squared * cloud.spacing**2 * edges / (3.0 * jump) if jump > 0.0 else 1.0
