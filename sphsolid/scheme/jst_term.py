"""The JST dissipation of one body (see ``jst`` for the equations)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.fields import scalar_field, vector_field
from sphsolid.scheme.fastest_damping import damped_step, fastest_rate
from sphsolid.scheme.global_momenta import momenta
from sphsolid.scheme.harmonic import harmonic_operator
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import State
from sphsolid.scheme.supg import powers_of_J
from sphsolid.scheme.term import Term

if TYPE_CHECKING:
    from sphsolid.scheme.jst import JST

Array = NDArray[np.float64]


class JSTTerm(Term):
    """Operators and work arrays of ``options``.

    After an evaluation ``D_p (N, 3)`` [N/m^3] and ``D_J (N,)`` [1/s] are what was added, without
    what ``momenta`` did.
    """

    def __init__(self, options: JST, set_up: SetUp) -> None:
        self.options = options
        self._set_up, self._cloud = set_up, set_up.cloud
        self._material = set_up.material
        self.changes = ("J",) if options.damps_J else ()
        self.momenta = momenta(set_up, kept=options.keeps_momenta)
        self.works = ("dissipation_p", "dissipation_J", *self.momenta.works)
        cloud, size = self._cloud, set_up.cloud.size
        self.length = cloud.h if options.length == "smoothing" else cloud.spacing
        self.wave_speed = reference_p_wave_speed(set_up.material)
        self._lap, self._back = set_up.kept(
            ("harmonic operator", options.weighting.is_self_adjoint), self._operators
        )
        self.D_p = vector_field(size)
        self.D_J = scalar_field(size if options.damps_J else 0)
        of_p = fastest_rate(lambda f: self._damped(f, options.eps_p2, options.eps_p4), (size, 1))
        of_J = 0.0
        if options.damps_J:
            of_J = fastest_rate(
                lambda f: self._damped(f, options.eps_J2, options.eps_J4), (size, 1)
            )
        self.rate = max(of_p, of_J)

    def _operators(self) -> tuple[csr_array, csr_array]:
        """``lap`` and what is applied after it."""
        lap = harmonic_operator(self._cloud)
        if not self.options.weighting.is_self_adjoint:
            return lap, lap
        V = self._cloud.V
        return lap, csr_array(diags_array(1.0 / V) @ lap.T @ diags_array(V))

    def _damped(self, f: Array, eps2: float, eps4: float) -> Array:
        """``c_p h (eps2 lap f - eps4 h^2 lap lap f)`` of ``f (N, k)``."""
        first = self._lap @ np.ascontiguousarray(f)
        out = eps2 * first
        if eps4 > 0.0:
            out -= eps4 * self.length**2 * (self._back @ first)
        return np.asarray(self.wave_speed * self.length * out)

    def add_rates(self, stage: Stage) -> None:
        """``D(J)`` without its mean; ``D(p)``, then what keeps the momenta."""
        options, V = self.options, self._cloud.V
        rates = stage.rates
        if options.damps_J:
            D_J = self._damped(stage.state.J[:, None], options.eps_J2, options.eps_J4)[:, 0]
            if options.keeps_momenta:
                D_J -= (V @ D_J) / np.sum(V)
            self.D_J[:] = D_J
            rates.J += D_J
        self.D_p[:] = self._damped(stage.state.p, options.eps_p2, options.eps_p4)
        rates.p += self.D_p
        self.momenta.correct(stage)

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """``sum V v . D(p)``, ``sum V Sigma_J D(J)``, and ``sum V v`` times the correction [W]."""
        V, s = self._cloud.V, stage.state
        v = s.p / self._material.density
        found = [float(V @ np.sum(v * self.D_p, axis=1)), 0.0]
        if self.options.damps_J:
            of_J = np.empty(len(V))
            powers_of_J(self._material, V, s.F, s.H, s.J, self.D_J, of_J)
            found[1] = float(np.sum(of_J))
        return (*found, *self.momenta.powers(stage))

    def largest_step(self, state: State) -> float:
        """What the fastest damping allows [s] (see ``fastest_damping``)."""
        return damped_step(self.rate, self._cloud, self.wave_speed)

    def description(self, units: Units) -> str:
        """Coefficients, form and what keeps the momenta."""
        coefficients = self.options.coefficients.items()
        given = [f"{name} {value:.4g}" for name, value in coefficients if value]
        return (
            f"JST, {', '.join(given)}, h = {self.length:.4g} m, "
            f"{type(self.options.weighting).__name__}, {self.momenta.words}; "
            f"{self._lap.nnz / self._cloud.size:.1f} neighbours"
        )
