"""The door to the sums between primary and secondary particles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud, Secondary
from sphsolid.fields import as_field, components, tensor_field, vector_field
from sphsolid.scheme import fine_scale, galerkin, pressure
from sphsolid.scheme.fine_scale import Coefficients, Evolved, Forms, Matched, Rates, Simplified
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.tile import make_scratch

Array = NDArray[np.float64]


class SecondarySums:
    """Sampling at the secondary particles and spreading back, on fields as everybody sees them."""

    def __init__(self, secondary: Secondary, cloud: Cloud) -> None:
        self.secondary = secondary
        self._cloud = cloud
        self._scratch = make_scratch()

    def tensor(self, *, used: bool = True) -> Array:
        """Zeros ``(M, 3, 3)``, none where they are not ``used``."""
        return tensor_field(self._count(used), particle_major=self._cloud.particle_major)

    def vector(self, *, used: bool = True) -> Array:
        """Zeros ``(M, 3)``, none where they are not ``used``."""
        return vector_field(self._count(used))

    def _count(self, used: bool) -> int:
        return len(self.secondary.X) if used else 0

    def gradient(self, f: Array) -> Array:
        """``sum_a f_a (x) G_a(X_q)  (M, 3, 3)``."""
        out = self.tensor()
        galerkin.gradient(
            self.secondary.sampling, components(as_field(f)), 1.0, components(out), self._scratch
        )
        return out

    def simplified(
        self, stage: Stage, coefficients: Simplified, P_fine: Array, F_x: Array
    ) -> None:
        """Eq. (27) of [Lee2017] into ``P_fine (M, 3, 3)``; see ``fine_scale.simplified``."""
        projected = stage.projected_rate
        rate = projected if len(projected) else stage.rates.F
        p, F, _, _ = stage.state.rows()
        fine_scale.simplified(
            self.secondary.sampling, coefficients, stage.projects,
            Matched(p, components(stage.arms), F, components(rate)),
            components(P_fine), components(F_x), self._scratch,
        )  # fmt: skip

    def general(
        self, material: Any, stage: Stage, forms: tuple[Forms, Coefficients], P_fine: Array,
        F_x: Array,
    ) -> None:  # fmt: skip
        """Eqs. (22)-(23) or (28) of [Lee2017]; see ``fine_scale.general``."""
        rates = stage.rates.rows()
        p, F, H, J = stage.state.rows()
        fine_scale.general(
            self.secondary.sampling, material, *forms,
            Evolved(p, components(stage.arms), F, H, J), Rates(rates.F, rates.H, rates.J,
            components(P_fine), components(F_x)), self._scratch,
        )  # fmt: skip

    def subtract_back(self, stage: Stage, P_fine: Array, P: Array) -> None:
        """``P_a -= B_a`` of the fine stress: see ``fine_scale.subtract_back``."""
        fine_scale.subtract_back(
            self.secondary.spreading, self._cloud.force, stage.projects,
            components(stage.arms), components(P_fine), components(P), self._scratch,
        )  # fmt: skip

    def momentum_dissipation(self, P_fine: Array, rate: Array) -> None:
        """Add ``D(p)`` (34) to ``rate (N, 3)``."""
        fine_scale.momentum_dissipation(
            self.secondary.spreading, components(P_fine), components(rate), self._scratch
        )

    def momentum_residual(
        self, stage: Stage, factor: float, inertia: Array, F_x: Array, flux: Array
    ) -> None:
        """``flux (M, 3) = factor H^T R_p``: see ``pressure.momentum_residual``."""
        pressure.momentum_residual(
            self.secondary.sampling, factor, components(stage.P), components(inertia),
            components(F_x), components(flux), self._scratch,
        )  # fmt: skip

    def volume_dissipation(self, flux: Array, rate: Array) -> None:
        """Add ``D(J)`` (35) to ``rate (N,)``."""
        pressure.volume_dissipation(
            self.secondary.spreading, components(flux), components(rate), self._scratch
        )
