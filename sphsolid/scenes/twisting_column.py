"""The twisting column ([Lee2017] section 8.3, Figs. 13-15): large strain near incompressibility.

A 1 x 6 x 1 m column along Y, clamped at its base, starts with the angular velocity
``w0 = (0, Omega sin(pi Y / 2 L), 0)``, ``L = 6`` m.  Published: geometry, material, ``Omega``,
``nu``, the lattices 4x19x4, 5x25x5 and 6x31x6.  No exact solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import require
from sphsolid.geometry.body import Box
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene

LENGTH = 6.0


@dataclass(frozen=True)
class Twist:
    """``w0 x X`` [m/s] with the angular velocity of the module's docstring, ``Omega`` [rad/s]."""

    angular_velocity: float

    def __call__(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        """The velocity ``(n, 3)``."""
        spin = self.angular_velocity * np.sin(0.5 * np.pi * X[:, 1] / LENGTH)
        return np.stack([spin * X[:, 2], np.zeros(len(X)), -spin * X[:, 0]], axis=1)


def twisting_column(
    *,
    angular_velocity: float = 105.0,
    poisson_ratio: float = 0.495,
    young_modulus: float = 17.0e6,
    density: float = 1100.0,
    end_time: float = 0.1,
) -> Scene:
    """The column with ``Omega`` [rad/s]; raises ``InputError`` for a non-finite ``Omega``."""
    require(
        bool(np.isfinite(angular_velocity)),
        f"twisting_column: angular_velocity = {angular_velocity} rad/s must be finite",
    )

    return Scene(
        name="twisting_column",
        body=Box(lower=(-0.5, 0.0, -0.5), upper=(0.5, LENGTH, 0.5)),
        material=NeoHookean.from_young(
            young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
        ),
        end_time=end_time,
        initial_velocity=Twist(angular_velocity),
        constraints=(Constraint("Y-", "all"),),
        probes={"top_centre": (0.0, LENGTH, 0.0), "top_corner": (0.5, LENGTH, 0.5)},
        provenance="Published: everything but the sense of rotation [Lee2017 section 8.3].",
    )
