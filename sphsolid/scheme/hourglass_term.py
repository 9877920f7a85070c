"""The springs of [Ganzenmueller2015] on one body (see ``hourglass_control`` for what they are)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum.wave_speed import moduli_at_rest
from sphsolid.fields import as_field, components, tensor_field, vector_field
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.restraint_pairs import apart, mean_with, unseen
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.support_pairs import support_pairs
from sphsolid.scheme.term import Term
from sphsolid.scheme.tile import tensor_of

Array = NDArray[np.float64]
#: Largest angle of a spring's own oscillation in a step.  With the 1.4 of the body's at a CFL
#: number of 0.7 it leaves position Verlet stable: ``1.4^2 + 1^2 < 2^2``.
_MOST = 1.0


class Springs(NamedTuple):
    """Row ``a`` has the pairs ``indptr[a] .. indptr[a + 1]``: ``indices``, ``stiffness`` [N/m].

    ``X (3, .)`` [m] are the particles, ``V (N,)`` [m^3] their volumes.
    """

    indptr: NDArray[np.uint64]
    indices: NDArray[np.uint32]
    stiffness: Array
    X: Array
    V: Array


@kernel
def hold(springs, x, F, out):  # type: ignore[no-untyped-def]
    """``out (3, .)`` [N/m^3]: the springs at positions ``x (3, .)`` with gradients ``F``."""
    for a in prange(len(springs.V)):
        f0 = f1 = f2 = 0.0
        F_a = tensor_of(F, a)
        for k in range(springs.indptr[a], springs.indptr[a + 1]):
            b = springs.indices[k]
            y = apart(x, a, b)
            e = unseen(mean_with(F, F_a, b), apart(springs.X, a, b), y)
            square = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
            c = springs.stiffness[k] * (e[0] * y[0] + e[1] * y[1] + e[2] * y[2]) / square
            f0 += c * y[0]
            f1 += c * y[1]
            f2 += c * y[2]
        out[0, a] = f0 / springs.V[a]
        out[1, a] = f1 / springs.V[a]
        out[2, a] = f2 / springs.V[a]


class HourglassTerm(Term):
    """Springs along the pairs of one body; ``force (N, 3)`` [N/m^3] of the last evaluation."""

    works = ("hourglass_control",)

    def __init__(self, alpha: float, set_up: SetUp) -> None:
        self.alpha = alpha
        self._set_up = set_up
        cloud, density = set_up.cloud, set_up.material.density
        mu, kappa = moduli_at_rest(set_up.material)
        young = 9.0 * kappa * mu / (3.0 * kappa + mu)
        pairs = support_pairs(cloud)
        both = cloud.V[pairs.row] * cloud.V[pairs.column]
        stiffness = alpha * young * both * pairs.W / pairs.r**2
        self._springs = Springs(
            pairs.indptr, pairs.column, stiffness, components(as_field(cloud.X)), cloud.V
        )
        self.force = vector_field(cloud.size)
        self._F = tensor_field(0, particle_major=cloud.particle_major)
        # Gershgorin: twice the largest sum over the springs of a particle.
        pull = np.bincount(pairs.row, stiffness, minlength=cloud.size) / cloud.V
        self.frequency = math.sqrt(2.0 * float(np.max(pull)) / density)
        self._mean = len(pairs.column) / cloud.size

    def add_rates(self, stage: Stage) -> None:
        """The springs at the positions of the stage, with the gradient of the same positions."""
        F = stage.state.F
        if not stage.knows_F_x:
            if not self._F.size:
                self._F = self._set_up.operator.zeros(Field("F_x", "tensor"))
            F = self._F
            self._set_up.operator.gradient(stage.arms, 1.0, F)
        hold(
            self._springs, components(as_field(stage.arms)), components(F), components(self.force)
        )
        stage.rates.p += self.force

    def powers(self, stage: Stage) -> tuple[float]:
        """``sum V v . f`` [W] of the last evaluation's force."""
        momentum = np.sum(stage.state.p * self.force, axis=1)
        return (float(self._set_up.cloud.V @ momentum) / self._set_up.material.density,)

    def largest_step(self, state: State) -> float:
        """A share of what the springs alone would allow [s]."""
        return _MOST / self.frequency

    def description(self, units: Units) -> str:
        """Strength and number of springs."""
        return (
            f"hourglass control of pairs, alpha {self.alpha:g}, {self._mean:.1f} springs a "
            "particle, both momenta exact"
        )
