"""The bending column: a clamped column set in motion sideways, ``v0 = (5/3 Y, 0, 0)`` m/s.

The 1 x 6 x 1 m column of the twisting column, clamped at its base, bends until its top centre has
moved by about half its length, and swings back.  A benchmark common among the formulations that
[Lee2017] belongs to, but not one of its examples.  No exact solution; what is compared is the first
peak of ``u_x`` at the top centre (B-bar on 8 x 48 x 8 cells: 2.989 m at 0.453 s).

Ours: E and rho0 of the twisting column with nu = 0.45, and the end of the run, which is past the
first peak.
"""

from __future__ import annotations

import math
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
class Sideways:
    """``(gradient Y, 0, 0)`` [m/s], ``gradient`` [1/s]."""

    gradient: float

    def __call__(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        """The velocity ``(n, 3)``."""
        return np.stack([self.gradient * X[:, 1], *np.zeros((2, len(X)))], axis=1)


def bending_column(
    *,
    velocity_gradient: float = 5.0 / 3.0,
    young_modulus: float = 17.0e6,
    poisson_ratio: float = 0.45,
    density: float = 1100.0,
    end_time: float = 0.6,
) -> Scene:
    """The column with ``v0 = (velocity_gradient Y, 0, 0)``, ``velocity_gradient`` [1/s].

    Raises ``InputError`` for a non-finite ``velocity_gradient``.
    """
    require(
        math.isfinite(velocity_gradient),
        f"bending_column: velocity_gradient = {velocity_gradient} 1/s must be finite",
    )

    return Scene(
        name="bending_column",
        body=Box((-0.5, 0.0, -0.5), (0.5, LENGTH, 0.5)),
        material=NeoHookean.from_young(
            young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
        ),
        end_time=end_time,
        initial_velocity=Sideways(velocity_gradient),
        constraints=(Constraint("Y-", "all"),),
        probes={"top_centre": (0.0, LENGTH, 0.0), "top_corner": (0.5, LENGTH, 0.5)},
        provenance=(
            "Not in [Lee2017]; a common benchmark of its family. Chosen: E and rho0 of the "
            "twisting column, nu = 0.45, end time."
        ),
    )
