"""How fast the fastest mode grows, up to which CFL number it does not, and what it looks like.

TVD-RK2 lets an undamped oscillation ``w`` grow by ``(w dt)^4 / 8`` a step, slowly where ``w dt``
is small, and damping that is not a positive form can feed slow modes.  So three limits are told
apart by ``max |g|``:

* ``strict``: no growth at all but round-off, ``1 + 1e-8``;
* ``slow``: tenfold in 1000 steps, ``10^(1/1000)``;
* ``fast``: tenfold in 50 steps, ``10^(1/50)``: beyond it a run diverges at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid import Simulation

Field = NDArray[np.inexact]
Array = NDArray[np.float64]
#: Eigenvalues this near to one belong to modes that neither move nor grow.
NEUTRAL = 1.0e-5
LIMITS: dict[str, float] = {
    "strict": 1.0 + 1.0e-8,
    "slow": 10.0 ** (1.0 / 1000.0),
    "fast": 10.0 ** (1.0 / 50.0),
}
CFL = tuple(round(0.1 * n, 1) for n in range(1, 13))
#: Smallest CFL number that is tried, and the width at which bisection stops.
SMALLEST, WIDTH = 0.01, 0.004
#: Shares from which a feature gives a mode its name, and the mean squared difference of neighbours
#: over its largest value from which it is a short wave.
MOST, ALMOST_ALL, ALMOST_NOTHING, ROUGH = 0.5, 0.9, 0.05, 0.25
PATTERNS = ("smooth", "layers", "hourglass", "checkerboard")


def largest_modulus(g: NDArray[np.complex128]) -> float:
    """``max |g|`` of all that are not neutral; zero where nothing is left."""
    return float(np.max(np.where(np.abs(g - 1.0) < NEUTRAL, 0.0, np.abs(g)), initial=0.0))


def decades(modulus: float, steps: int = 1000) -> float:
    """``log10`` of the growth over ``steps`` steps."""
    return steps * float(np.log10(modulus)) if modulus > 0.0 else float("-inf")


def scan(modulus: Callable[[float], float], cfl: Sequence[float] = CFL) -> dict[float, float]:
    """``max |g|`` at every CFL number."""
    return {number: modulus(number) for number in cfl}


def limits(
    modulus: Callable[[float], float],
    scanned: Mapping[float, float],
    thresholds: Mapping[str, float] = LIMITS,
) -> dict[str, float]:
    """Largest CFL number below the first crossing of each threshold, by bisection.

    ``scanned`` maps CFL numbers to ``max |g|``; ``modulus(cfl)`` is asked in between and every
    answer is used for all thresholds.  Zero: not even ``SMALLEST``; the last scanned value: no
    crossing was found.
    """
    known = dict(scanned)
    found = {}
    for name, threshold in thresholds.items():
        over = [cfl for cfl in sorted(known) if known[cfl] > threshold]
        if not over:
            found[name] = max(known)
            continue
        high = over[0]
        below = [cfl for cfl in known if cfl < high]
        low = max(below, default=SMALLEST)
        if not below:
            known[low] = modulus(low)
            if known[low] > threshold:
                found[name] = 0.0
                continue
        while high - low > WIDTH:
            middle = 0.5 * (low + high)
            known[middle] = modulus(middle)
            low, high = (middle, high) if known[middle] <= threshold else (low, middle)
        found[name] = low
    return found


@dataclass(frozen=True)
class Shape:
    """What a mode looks like; shares in [0, 1] but ``seen``, which is about one for a smooth mode.

    ``corner`` of the volume-weighted square on edges and corners, ``boundary`` on the boundary;
    ``alternating[n]`` in patterns that alternate along ``n`` axes (times constants and linears,
    0: smooth); ``roughness`` mean squared difference of neighbours over four times the mean square;
    ``seen`` squared gradient at the secondary particles (without them: at the particles) over that
    of neighbours' differences; ``field`` is ``"u"`` or ``"J"``.
    """

    field: str
    corner: float
    boundary: float
    alternating: tuple[float, ...]
    roughness: float
    seen: float

    @property
    def name(self) -> str:
        """The first of these that holds.

        ``checkerboard``: ``(-1)^(i+j+k)`` times something smooth; ``corner``, ``surface``: at
        particles on edges and corners, or on the boundary; ``hourglass``: alternates along two
        axes, or varies from particle to particle with next to no gradient at the secondary
        particles, so that the stabilisation does not see it; ``layers``: alternates along one axis;
        ``short wave`` or ``smooth`` by the mean difference of neighbours.
        """
        unseen = self.roughness >= ROUGH and self.seen < ALMOST_NOTHING
        names = {
            "checkerboard": self.alternating[3] >= MOST,
            "corner": self.corner >= MOST,
            "surface": self.boundary >= ALMOST_ALL,
            "hourglass": self.alternating[2] >= MOST or unseen,
            "layers": self.alternating[1] >= MOST,
            "short wave": self.roughness >= ROUGH,
            "smooth": True,
        }
        return next(name for name, holds in names.items() if holds) + (
            " of J" if self.field == "J" else ""
        )


def shape(simulation: Simulation, u: Field, J: Field) -> Shape:
    """Shape of a mode of a box with ``u (N, 3)`` in units of ``l`` and ``J (N,)``."""
    V = simulation.cloud.V
    of_u = float(np.sum(V[:, None] * np.abs(u) ** 2))
    of_J = float(np.sum(V * np.abs(J) ** 2))
    # J moves along with u in any pressure wave, by less than one for a displacement of one.
    field, f = ("u", u) if of_u >= 0.05 * of_J else ("J", J[:, None])
    total = float(np.sum(V[:, None] * np.abs(f) ** 2))
    density = V * np.sum(np.abs(f) ** 2, axis=1) / total
    place = lattice_places(simulation)
    last = place.max(axis=0)
    faces = np.count_nonzero((place == 0) | (place == last), axis=1)
    # Neighbours along an axis: their numbers differ by its stride.
    strides = [int(np.flatnonzero((place == step).all(axis=1))[0]) for step in np.eye(3)]
    a = np.concatenate([np.flatnonzero(place[:, d] < last[d]) for d in range(3)])
    b = np.concatenate([np.flatnonzero(place[:, d] < last[d]) + strides[d] for d in range(3)])
    jump = float(np.sum(np.abs(f[a] - f[b]) ** 2))
    return Shape(
        field=field,
        corner=float(np.sum(density[faces >= 2])),
        boundary=float(np.sum(density[faces >= 1])),
        alternating=_alternating(place, np.sqrt(V), f, total),
        roughness=jump / (2.0 * float(np.sum(np.abs(f[a]) ** 2 + np.abs(f[b]) ** 2))),
        # A linear field has a squared gradient of three axes for the mean difference along one.
        seen=_seen(simulation, f) * len(a) / (3.0 * jump) if jump > 0.0 else 1.0,
    )


def lattice_places(simulation: Simulation) -> NDArray[np.int64]:
    """Places ``(i, j, k)`` of the particles of a box ``(N, 3)``, also of a disordered one."""
    first = simulation.cloud.mesh.cells[0]
    plane, line = int(first[1] - first[0]), int(first[3] - first[0])
    a = np.arange(simulation.cloud.size)
    return np.stack([a // plane, (a % plane) // line, a % line], axis=1)


def _alternating(
    place: NDArray[np.int64], root: Array, f: Field, total: float
) -> tuple[float, ...]:
    smooth = np.concatenate([np.ones((len(place), 1)), place - place.mean(axis=0)], axis=1)
    share = np.zeros(4)
    for signs in np.ndindex(2, 2, 2):
        sign = 1.0 - 2.0 * ((place @ signs) % 2)
        basis = np.linalg.qr((root * sign)[:, None] * smooth)[0]
        found = float(np.sum(np.abs(basis.T @ (root[:, None] * f)) ** 2)) / total
        # The best pattern of a kind: patterns overlap on a finite block, so shares do not add up.
        share[sum(signs)] = max(share[sum(signs)], found)
    return tuple(share.tolist())


def _seen(simulation: Simulation, f: Field) -> float:
    """Mean squared gradient of ``f`` times ``dx^2``, where the stabilisation looks."""
    q, cloud = simulation.secondary, simulation.cloud
    if q is None:
        pairs, G, V = cloud.pairs, cloud.gradients.kinematic, cloud.V
    else:
        pairs, G, V = q.pairs, q.sample[:, :3], q.V
    terms = f[pairs.indices][:, :, None] * G[:, None, :]
    gradient = np.add.reduceat(terms, pairs.indptr[:-1], axis=0)
    squared = np.sum(np.abs(gradient) ** 2, axis=(1, 2))
    return float(np.average(squared, weights=V)) * cloud.spacing**2


def name_of_wave(k: Array) -> str:
    """Name of a plane wave ``k l (3,)`` of the interior."""
    alternates = int(np.count_nonzero(np.abs(k) > 0.9 * np.pi))
    if alternates:
        return PATTERNS[alternates]
    return "short wave" if np.max(np.abs(k)) > 0.45 * np.pi else "smooth"
