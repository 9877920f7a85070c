"""The acoustic Riemann flux of one body (see ``upwind`` for the equations)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.pairs.neighbours import transposed
from sphsolid.continuum.wave_speed import moduli_at_rest, reference_p_wave_speed
from sphsolid.fields import as_field, components, tensor_field, vector_field
from sphsolid.scheme.fastest_damping import damped_step, fastest_rate
from sphsolid.scheme.global_momenta import momenta
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import Term
from sphsolid.scheme.upwind_kernels import Faces, Speeds, limiters, upwind

if TYPE_CHECKING:
    from sphsolid.scheme.upwind import Upwind

Array = NDArray[np.float64]


def faces_of(cloud: Cloud) -> Faces:
    """The pairs of ``cloud`` with ``A_ab = (V_a G_b(X_a) - V_b G_a(X_b)) / 2``, none of zero area.

    ``G`` is the gradient whose adjoint makes the force.
    """
    pairs = cloud.pairs
    row = pairs.row_of_pair
    flux = cloud.V[row, None] * cloud.gradients.force
    area = 0.5 * (flux - flux[transposed(pairs, pairs.rows)[1]])
    size = np.linalg.norm(area, axis=1)
    # What is round-off of no area has no direction.
    place = np.flatnonzero((row != pairs.indices) & (size > 1e-12 * np.max(size)))
    count = np.bincount(row[place], minlength=pairs.rows)
    return Faces(
        np.concatenate([[0], np.cumsum(count)]).astype(np.uint64), pairs.indices[place],
        np.ascontiguousarray(area[place].T), components(as_field(cloud.X)), cloud.V,
    )  # fmt: skip


class UpwindTerm(Term):
    """Faces and work arrays of ``options``.

    After an evaluation ``D_p (N, 3)`` [N/m^3] is what the faces added, without what ``momenta``
    did.
    """

    def __init__(self, options: Upwind, set_up: SetUp) -> None:
        self.options = options
        self.needs_rates = options.reconstruction != "none"
        self.momenta = momenta(set_up, kept=options.keeps_momenta)
        self.works = ("dissipation_p", *self.momenta.works)
        self._set_up, self._material = set_up, set_up.material
        cloud = set_up.cloud
        self._faces = set_up.kept("faces of upwind", lambda: faces_of(cloud))
        mu, _ = moduli_at_rest(set_up.material)
        c_s = math.sqrt(mu / set_up.material.density)
        self._wave_speed = c_p = reference_p_wave_speed(set_up.material)
        share = options.impedance
        self.speeds = Speeds(share * c_p, share * c_s, options.normal == "pair")
        self.D_p = vector_field(cloud.size)
        self.phi = vector_field(cloud.size if options.reconstruction == "limited" else 0)
        self._none = tensor_field(0, particle_major=cloud.particle_major)
        self._F = self._none
        self.rate = self._fastest(cloud)

    def _fastest(self, cloud: Cloud) -> float:
        """Fastest damping [1/s] of the undeformed body; a reconstruction makes it less."""
        size = cloud.size
        F = self._set_up.operator.zeros(Field("F", "tensor"))
        F[:] = np.eye(3)
        arms, out = as_field(cloud.X - cloud.middle), vector_field(size)

        def damp(p: Array) -> Array:
            p_and_F = components(as_field(p)), components(F)
            motion = components(arms), *p_and_F, components(self._none)
            unlimited = components(vector_field(0))
            density = self._material.density
            upwind(self._faces, self.speeds, motion, unlimited, density, components(out))
            return out.copy()

        return fastest_rate(damp, (size, 3))

    def add_rates(self, stage: Stage) -> None:
        """``D(p)``, then what keeps the angular momentum."""
        F = stage.state.F
        if not stage.knows_F_x:
            if not self._F.size:
                self._F = self._set_up.operator.zeros(Field("F_x", "tensor"))
            F = self._F
            self._set_up.operator.gradient(stage.arms, 1.0, F)
        p, density = components(as_field(stage.state.p)), self._material.density
        L = components(stage.rates.F if self.needs_rates else self._none)
        if self.phi.size:
            limiters(self._faces, p, L, density, components(self.phi))
        motion = components(as_field(stage.arms)), p, components(F), L
        upwind(
            self._faces, self.speeds, motion, components(self.phi), density, components(self.D_p)
        )
        stage.rates.p += self.D_p
        self.momenta.correct(stage)

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """``sum V v . D(p)``, and ``sum V v`` times the correction [W]."""
        V, v = self._set_up.cloud.V, stage.state.p / self._material.density
        return (float(V @ np.sum(v * self.D_p, axis=1)), *self.momenta.powers(stage))

    def largest_step(self, state: State) -> float:
        """What the fastest damping allows [s] (see ``fastest_damping``)."""
        return damped_step(self.rate, self._set_up.cloud, self._wave_speed)

    def description(self, units: Units) -> str:
        """Reconstruction, impedance and normal."""
        options, faces = self.options, len(self._faces.indices) / self._set_up.cloud.size
        return (
            f"acoustic Riemann flux, reconstruction {options.reconstruction}, "
            f"{options.impedance:g} of the impedance, normal of the {options.normal}, "
            f"{self.momenta.words}; {faces:.1f} faces a particle"
        )
