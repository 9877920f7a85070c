"""The spinning cube: a free body whose angular momentum and energy are known and must stay.

A unit cube centred at the origin turns about Z with ``Omega``; no load, no constraint.  At the
start

    L_z = rho0 Omega a^5 / 6 = 19,250 kg m^2/s,   K = L_z Omega / 2 = 1.0106e6 J

(``a = 1`` m, ``rho0 = 1100`` kg/m^3, ``Omega = 105`` rad/s), and linear momentum is zero.  The cube
expands under its own inertia and pulsates, so ``turns`` of the initial speed are somewhat more
time than as many turns of the body.

A common test of conservation for explicit solid dynamics; not in [Lee2017].  Ours: the material of
its twisting column (E, rho0) with nu = 0.45, and the length of the run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import require
from sphsolid.geometry.body import Box
from sphsolid.scenes.scene import Scene


@dataclass(frozen=True)
class Spin:
    """``Omega (-Y, X, 0)`` [m/s], ``Omega`` the ``angular_velocity`` [rad/s]."""

    angular_velocity: float

    def __call__(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        """The velocity ``(n, 3)``."""
        return self.angular_velocity * np.stack([-X[:, 1], X[:, 0], np.zeros(len(X))], axis=1)


def spinning_cube(
    *,
    angular_velocity: float = 105.0,
    turns: float = 10.0,
    young_modulus: float = 17.0e6,
    poisson_ratio: float = 0.45,
    density: float = 1100.0,
    jitter: float = 0.0,
    seed: int = 0,
) -> Scene:
    """The cube with ``Omega`` [rad/s], to the time of ``turns`` turns at that speed.

    Raises ``InputError`` for a zero or non-finite ``Omega`` or a number of turns that is not
    positive.
    """
    require(
        math.isfinite(angular_velocity) and angular_velocity != 0.0,
        f"spinning_cube: angular_velocity = {angular_velocity} rad/s must be finite and not zero",
    )
    require(
        math.isfinite(turns) and turns > 0.0,
        f"spinning_cube: turns = {turns} must be positive and finite",
    )

    return Scene(
        name="spinning_cube",
        body=Box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), jitter=jitter, seed=seed),
        material=NeoHookean.from_young(
            young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
        ),
        end_time=turns * 2.0 * math.pi / abs(angular_velocity),
        initial_velocity=Spin(angular_velocity),
        probes={"corner": (0.5, 0.5, 0.5), "face_centre": (0.5, 0.0, 0.0)},
        provenance=(
            "Not in [Lee2017]; a common conservation test. Chosen: E and rho0 of the twisting "
            "column, nu = 0.45, ten turns."
        ),
    )
