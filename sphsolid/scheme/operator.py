"""What the scheme needs of a discrete gradient: the only door to the sums over pairs.

Terms, integrators and the right-hand side see fields as ``(N,)``, ``(N, 3)`` and ``(N, 3, 3)``.
How these lie in memory, and which kernel sums over whom, is known behind this door alone.
``pair_sums`` is the operator of every cloud; one of another kind (differences along the axes of a
lattice) keeps the same protocol.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field

Array = NDArray[np.float64]


class Operator(Protocol):
    """A gradient, the divergence that is its adjoint, and the passes made of them."""

    @property
    def size(self) -> int:
        """Number of particles ``N``."""
        ...

    @property
    def is_adjoint(self) -> bool:
        """True where kinematics and force share one gradient."""
        ...

    def zeros(self, field: Field) -> Array:
        """A field of zeros, laid out as the passes want it."""
        ...

    def arms(self, x: Array) -> Array:
        """Positions from the middle of the body ``(N, 3)`` [m], one array for all calls.

        ``sum_b G_b`` is zero to round-off, which positions far from the origin would multiply.
        """
        ...

    def gradient(self, f: Array, factor: float, out: Array) -> None:
        """``out_a = factor sum_b f_b (x) G_b(X_a)  (N, 3, 3)`` with the kinematic gradient."""
        ...

    def force_gradient(self, f: Array, factor: float, out: Array) -> None:
        """The same with the gradient whose adjoint makes the force."""
        ...

    def internal_force(self, P: Array, out: Array) -> None:
        """``out_a = -sum_b V_b P_b G_a(X_b) / V_a  (N, 3)`` [N/m^3]: minus the adjoint."""
        ...

    def rates_and_stress(
        self, material: Any, stage: Stage, *, needs_rates: bool, knows_L: bool
    ) -> None:
        """Eqs. (31b)-(31d) and the stress (9) of [Lee2017], projected by (40), into ``stage``.

        ``needs_rates``: ``grad v`` and the rates of ``H`` and ``J`` are wanted;  ``knows_L``:
        ``stage.rates.F`` is ``grad v`` already.
        """
        ...
