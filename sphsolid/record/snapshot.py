"""What either solver hands out at an instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointField:
    """Values at points that carry volume, so that it can be integrated.

    ``X (n, 3)`` [m] reference positions, ``V (n,)`` [m^3], ``values (n, ...)``.
    """

    X: Array
    V: Array
    values: Array


@dataclass(frozen=True)
class Snapshot:
    """The state of a body at ``time`` [s] after ``step`` steps.

    ``X, x, velocity (N, 3)`` and ``V (N,)`` at the primary points (particles, or nodes with their
    tributary volume); ``density`` [kg/m^3].  ``stress_X (M, 3)``, ``stress_V (M,)``,
    ``F (M, 3, 3)``, ``J (M,)``, ``P (M, 3, 3)`` where the method evaluates the constitutive law:
    the particles themselves, or the element centroids of a finite element method (its
    superconvergent points).  ``strain_energy`` [J], zero in the undeformed state, and
    ``kinetic_energy`` [J] are totals with the method's own quadrature.
    """

    time: float
    step: int
    density: float
    X: Array
    V: Array
    x: Array
    velocity: Array
    stress_X: Array
    stress_V: Array
    F: Array
    J: Array
    P: Array
    strain_energy: float

    @property
    def momentum(self) -> Array:
        """``p = rho0 v (N, 3)`` [kg/(m^2 s)] per undeformed volume."""
        return self.density * self.velocity

    @property
    def displacement(self) -> Array:
        """``u = x - X (N, 3)`` [m]."""
        return self.x - self.X

    @property
    def kinetic_energy(self) -> float:
        """``sum V rho0 |v|^2 / 2`` [J]."""
        return float(0.5 * self.density * np.sum(self.V[:, None] * self.velocity**2))

    def field(self, name: str) -> PointField:
        """``p``, ``u``, ``v``, ``P``, ``F`` or ``J`` with the points it lives on."""
        if name in ("p", "u", "v"):
            values = {"p": self.momentum, "u": self.displacement, "v": self.velocity}[name]
            return PointField(self.X, self.V, values)
        if name in ("P", "F", "J"):
            return PointField(self.stress_X, self.stress_V, getattr(self, name))
        raise InputError(f"snapshot has no field {name!r}; choose one of p, u, v, P, F, J")
