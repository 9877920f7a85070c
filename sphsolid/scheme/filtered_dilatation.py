"""The volumetric energy of a filtered Jacobian, as a term of one body.

    E = sum V [W(F, H, J) - U(J) + U(S J) + k (J - S J)^2 / 2]

with ``S`` symmetric in the volumes and ``S 1 = 1``, so that the pressure that acts is

    p~ = S U'(S J) + k (I - S)^2 J,        P = dW/dF + [p~ - U'(J)] H.

Of a uniform change of volume ``p~ = U'(J)``.  What ``S`` leaves of ``J`` costs no volumetric
energy, so nothing locks.  **What J means then.**  ``J`` of one particle may wander from that of
its neighbours by what the filter takes out; ``S J`` is the change of volume that the material
resists, and ``p~``, not ``U'(J)``, the mean stress.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.dilatation_filter import dilatation_filter
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant, join, scale, split
from sphsolid.continuum.wave_speed import moduli_at_rest
from sphsolid.fields import LANES, components, scalar_field, tensor_field
from sphsolid.scheme import volumetric_stress
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import Term
from sphsolid.scheme.tile import make_scratch

if TYPE_CHECKING:
    from sphsolid.scheme.dilatation import FilteredDilatation

Array = NDArray[np.float64]


class FilteredDilatationTerm(Term):
    """Filter and work arrays of ``options``; ``excess (N,)`` [Pa] is ``p~ - U'(J)``.

    The stress is that of a potential.  Its work is none of the energy budget's, but for what the
    projection, a force that is not adjoint and a ``D(J)`` do to it: those make one column.
    """

    works = ("filtered_dilatation",)
    stores_volume = True

    def __init__(self, options: FilteredDilatation, set_up: SetUp) -> None:
        self.options = options
        self._set_up, self._material = set_up, set_up.material
        mu, kappa = moduli_at_rest(self._material)
        #: What holds the rest [Pa]: more than the bulk modulus would be stiffer than no filter.
        self.stiffness = min(options.beta * mu * mu / kappa, kappa)
        self._filter = set_up.kept(
            ("dilatation filter", options.order, options.width),
            lambda: dilatation_filter(
                set_up.cloud, order=options.order, width=options.width
            ),
        )
        size = set_up.operator.size
        evolves_J = set_up.formulation.evolves_J
        self._tiles = -(-size // LANES)
        self._none = tensor_field(0, particle_major=set_up.cloud.particle_major)
        self._gradient = self._F_x = self._none
        self._power_of_J = 0.0
        self._powers = np.zeros(size if evolves_J else 0)
        self._scratch = make_scratch()

    # The evaluation on a box lattice has arrays of its own and no use for these.
    @cached_property
    def excess(self) -> Array:
        """``p~ - U'(J)  (N,)`` [Pa] of the last evaluation."""
        return scalar_field(self._set_up.operator.size)

    @cached_property
    def _arrays(self) -> tuple[Array, Array, Array, Array]:
        size = self._set_up.operator.size
        own = 0 if self._set_up.formulation.evolves_J else size
        return scalar_field(own), scalar_field(size), scalar_field(size), scalar_field(size)

    def add_stress(self, stage: Stage) -> None:
        """``P += [p~ - U'(J)] H``, projected where the stresses are."""
        _, F, H, J = stage.state.rows()
        own_J, smooth, work, pressure = self._arrays
        if not J.size:
            J = components(own_J)
            volumetric_stress.jacobian(F, self._tiles, J, self._scratch)
        own = J[0, : len(self.excess)]
        self._filter.apply(own, work, smooth)
        of_filtered = (self._material, self.stiffness, own, smooth)
        volumetric_stress.conjugate(*of_filtered, pressure)
        self._filter.apply(pressure, work, self.excess)
        volumetric_stress.excess(*of_filtered, self.excess)
        self._F_x = self._geometry(stage)
        volumetric_stress.add(
            components(self.excess), F, H, components(self._F_x), self._tiles,
            components(stage.P), self._scratch,
        )  # fmt: skip

    def _geometry(self, stage: Stage) -> Array:
        """``F_x (N, 3, 3)``, of zero length where ``e H`` needs no projection."""
        if not stage.projects or stage.knows_F_x:
            return self._none
        if not len(self._gradient):
            self._gradient = self._set_up.operator.zeros(Field("F_x", "tensor"))
        self._set_up.operator.force_gradient(stage.arms, 1.0, self._gradient)
        return self._gradient

    def add_rates(self, stage: Stage) -> None:
        """No rate; the power that the ``D(J)`` of the terms before gives the filtered energy."""
        if len(self._powers):
            s, rates = stage.state, stage.rates
            volumetric_stress.powers_of_J(
                self._set_up.cloud.V, self.excess, s.F, s.H, rates.F, rates.J, self._powers
            )
            self._power_of_J = float(np.sum(self._powers))

    def powers(self, stage: Stage) -> tuple[float]:
        """``sum V [Q : L_k - Q^C : L_f + e D(J)]``: zero where ``Q = e H`` needs no projection."""
        operator, s = self._set_up.operator, stage.state
        L_k, L_f = stage.rates.F, stage.rates.F
        if not operator.is_adjoint:
            L_f = operator.zeros(Field("L_f", "tensor"))
            operator.force_gradient(s.p / self._material.density, 1.0, L_f)
        out = np.empty(operator.size)
        volumetric_stress.powers_of_stress(
            self._set_up.cloud.V, self.excess, s.F, s.H, self._F_x, L_k, L_f, out
        )
        return (float(np.sum(out)) + self._power_of_J,)

    def _filtered(self, f: Array) -> Array:
        source, out = np.ascontiguousarray(f), np.empty(len(f))
        self._filter.apply(source, np.empty(len(f)), out)
        return out

    def _jacobian(self, state: State) -> Array:
        return state.J if len(state.J) else np.asarray(determinant(split(state.F)))

    def stored_energy(self, state: State) -> float:
        """``sum V [U(S J) - U(J) + k (J - S J)^2 / 2]`` [J]."""
        J = self._jacobian(state)
        S_J = self._filtered(J)
        density = law.volumetric_energy(self._material, S_J)
        density = density - law.volumetric_energy(self._material, J)
        density = density + 0.5 * self.stiffness * (J - S_J) ** 2
        return float(np.sum(self._set_up.cloud.V * density))

    def add_constitutive(self, state: State, P: Array) -> None:
        """``P += [p~ - U'(J)] H``."""
        J = self._jacobian(state)
        S_J = self._filtered(J)
        rest = self.stiffness * (J - S_J)
        p = self._filtered(law.volumetric_pressure(self._material, S_J) - rest) + rest
        H = split(state.H) if len(state.H) else cofactor(split(state.F))
        P += join(scale(p - law.volumetric_pressure(self._material, J), H))

    def description(self, units: Units) -> str:
        """The filter, and ``beta`` where there is one."""
        beta = f", the rest held by {self.stiffness:.3g} Pa" if self.stiffness else ""
        return f"pressure of a filtered J ({self._filter.description}{beta})"
