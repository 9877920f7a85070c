"""The SUPG terms of one body: ``D(p)`` and ``D(J)`` at its secondary particles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import kernel, prange
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, load
from sphsolid.fields import scalar_field, vector_field
from sphsolid.scheme.fine_scale_forms import Sampled
from sphsolid.scheme.intrinsic_time import Times, Units
from sphsolid.scheme.secondary_sums import SecondarySums
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field
from sphsolid.scheme.term import Term

if TYPE_CHECKING:
    from sphsolid.scheme.stabilisation import SUPG

Array = NDArray[np.float64]


@kernel
def powers_of_J(material, V, F, H, J, D_J, out):  # type: ignore[no-untyped-def]
    """``V Sigma_J D(J)  (N,)`` [W]."""
    for a in prange(len(V)):
        F_a = load(F, a)
        H_a = load(H, a) if len(H) > 0 else cofactor(F_a)
        out[a] = V[a] * law.conjugate_stresses(material, F_a, H_a, J[a])[2] * D_J[a]


class SUPGTerm(Term):
    """Secondary particles and work arrays of ``options``.

    After an evaluation ``P_fine (M, 3, 3)`` [Pa] and ``flux (M, 3)`` are those of its stage.
    ``times`` are the intrinsic times [s], which belong to the state at the start of a step and to
    no step length.
    """

    needs_rates = True

    def __init__(self, options: SUPG, set_up: SetUp) -> None:
        self.options = options
        self.follows_step = options.follows_step
        self.needs_projected_rate = options.is_self_adjoint
        self.changes = ("J",) if options.damps_J else ()
        self.works = ("dissipation_p", "dissipation_J")
        self.times = Times()
        self.secondary = set_up.secondary(
            options.secondary, adjoint_weight=options.is_self_adjoint
        )
        self._set_up, self._material = set_up, set_up.material
        self._sums = sums = SecondarySums(self.secondary, set_up.cloud)
        self.P_fine = sums.tensor()
        self.F_x = sums.tensor(used=options.damps_J or options.fine_scale.writes_F_x)
        self.flux = sums.vector(used=options.damps_J)
        self.inertia = vector_field(set_up.operator.size if options.damps_J else 0)

    def at_secondary(self, f: Array) -> Array:
        """``sum_a f_a (x) G_a(X_q)  (M, 3, 3)``."""
        return self._sums.gradient(f)

    def begin_step(self, units: Units) -> None:
        """Resolve the intrinsic times."""
        self.times = self.options.seconds(units)

    def add_stress(self, stage: Stage) -> None:
        """``P_fine``; of the self-adjoint weighting, minus its ``B``."""
        at = Sampled(self._sums, self._material, stage, self.times, self.P_fine, self.F_x)
        self.options.fine_scale.fine_stress(at, self.options)
        if self.options.is_self_adjoint:
            self._sums.subtract_back(stage, self.P_fine, stage.P)

    def add_rates(self, stage: Stage) -> None:
        """``D(J)`` from the momentum residual of the rates so far, then ``D(p)``."""
        rates = stage.rates
        if self.options.damps_J:
            # R_p holds the Galerkin rate alone, so it is taken before D(p) is added.
            self.inertia[:] = rates.p
            self._set_up.essential.release(self.inertia)
            if self._set_up.loads.has_body_force:
                self.inertia -= self._set_up.loads.at(stage.t)[1]
            factor = self.times.p / self._material.density
            self._sums.momentum_residual(stage, factor, self.inertia, self.F_x, self.flux)
            self._sums.volume_dissipation(self.flux, rates.J)
        self._sums.momentum_dissipation(self.P_fine, rates.p)

    def powers(self, stage: Stage) -> tuple[float, float]:
        """``sum V v.D(p)`` and ``sum V Sigma_J D(J)``, evaluated again from stress and flux."""
        V = self._set_up.cloud.V
        v = stage.state.p / self._material.density
        by_p = float(np.sum(V[:, None] * v * self.dissipation(stage)))
        if not self.options.damps_J:
            return by_p, 0.0
        size = len(V)
        D_J, powers = scalar_field(size), np.empty(size)
        self._sums.volume_dissipation(self.flux, D_J)
        s = stage.state
        powers_of_J(self._material, V, s.F, s.H, s.J, D_J, powers)
        return by_p, float(np.sum(powers))

    def dissipation(self, stage: Stage) -> Array:
        """``D(p)  (N, 3)`` [N/m^3], with the force of ``-B`` in the self-adjoint weighting."""
        operator = self._set_up.operator
        D_p = vector_field(operator.size)
        self._sums.momentum_dissipation(self.P_fine, D_p)
        if self.options.is_self_adjoint:
            minus_B, force = operator.zeros(Field("B", "tensor")), vector_field(operator.size)
            self._sums.subtract_back(stage, self.P_fine, minus_B)
            operator.internal_force(minus_B, force)
            D_p += force
        return D_p

    def description(self, units: Units) -> str:
        """Name, form, intrinsic times, weighting, and how many secondary particles."""
        assert self.secondary is not None
        s = self.options
        times = []
        for name, time in s.intrinsic_times.items():
            if time.c > 0.0:
                at = " undeformed" if time.follows_step else ""
                seconds = time.seconds(units)
                times.append(f"{name} {time.c:.4g} {time.unit} = {seconds:.4g} s{at}")
            elif name in ("tau_F", "tau_p"):
                times.append(f"{name} 0")
        return (
            f"{s.name}, {type(s.fine_scale).__name__}, " + ", ".join(times)
            + ("" if s.damps_J else " (no R_p pass)")
            + f", xi_F {s.xi_F:g}, {type(s.weighting).__name__}; {len(self.secondary.X)} secondary "
            f"particles, {self.secondary.sampling.mean_neighbours:.1f} neighbours"
        )
