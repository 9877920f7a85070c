"""The operator of a cloud: sums over pairs, fused into as few passes as possible."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.cloud.pairs.pair_operator import PairOperator
from sphsolid.fields import as_field, components, vector_field
from sphsolid.scheme import galerkin
from sphsolid.scheme.galerkin import Found, Given, Passes
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, zeros_of
from sphsolid.scheme.tile import make_scratch

Array = NDArray[np.float64]


class PairSums:
    """Keeps the protocol ``scheme.operator.Operator`` with the pair operators of a cloud."""

    def __init__(self, cloud: Cloud) -> None:
        self.cloud = cloud
        self.size = cloud.size
        self.is_adjoint = cloud.is_adjoint
        self.scratch = make_scratch()
        self._middle = cloud.middle
        self._arms = vector_field(cloud.size)

    def zeros(self, field: Field) -> Array:
        """A field of zeros."""
        return zeros_of(field, self.size, particle_major=self.cloud.particle_major)

    def arms(self, x: Array) -> Array:
        """Positions from the middle of the body ``(N, 3)`` [m]."""
        np.subtract(x, self._middle, out=self._arms)
        return self._arms

    def gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor sum_b f_b (x) G_b(X_a)`` with the kinematic gradient."""
        self.sum_of(self.cloud.kinematic, f, factor, out)

    def force_gradient(self, f: Array, factor: float, out: Array) -> None:
        """The same with the gradient whose adjoint makes the force."""
        self.sum_of(self.cloud.force, f, factor, out)

    def sum_of(self, G: PairOperator, f: Array, factor: float, out: Array) -> None:
        """``out_r = factor sum_b f_b (x) G_rb``; neither array need be a field."""
        if len(out) != G.rows:
            # A kernel does not ask how long an array is.
            raise ValueError(f"room for {len(out)} particles where {G.rows} rows are written")
        result = as_field(out)
        galerkin.gradient(G, components(as_field(f)), factor, components(result), self.scratch)
        if result is not out:
            out[:] = result

    def internal_force(self, P: Array, out: Array) -> None:
        """``out_a = -sum_b P_b g_ab  (N, 3)`` [N/m^3]."""
        galerkin.internal_force(self.cloud.adjoint, components(P), components(out), self.scratch)

    def rates_and_stress(
        self, material: Any, stage: Stage, *, needs_rates: bool, knows_L: bool
    ) -> None:
        """Rates of ``F``, ``H``, ``J`` and the projected stress, in one pass."""
        rates = stage.rates.rows()
        galerkin.coarse(
            material, self.cloud.kinematic, self.cloud.force,
            Passes(self.is_adjoint, needs_rates, knows_L, stage.projects),
            Given(components(stage.arms), *stage.state.rows()),
            Found(components(stage.P), rates.F, rates.H, rates.J,
                  components(stage.projected_rate)),
            self.scratch,
        )  # fmt: skip
