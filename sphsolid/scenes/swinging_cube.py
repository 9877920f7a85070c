"""The swinging cube ([Lee2017] section 8.1, Fig. 3): a standing wave with a known solution.

On the unit cube, with ``s_i = sin(pi X_i / 2)`` and ``c_i = cos(pi X_i / 2)``,

    u = U0 cos(w t) [A s1 c2 c3, B c1 s2 c3, C c1 c2 s3].

There are rollers on ``X = 0, Y = 0, Z = 0``, and the faces ``X = 1, Y = 1, Z = 1`` are fixed
tangentially.

Published: geometry, conditions, E, nu, rho0.  Not published: the amplitude ``U0``, the
coefficients of the convergence figure and the instant at which its error is taken.  Ours: ``U0``
defaults to 5e-4 m, the error is averaged over a period (see ``sphsolid.record.norms``).

The field is an exact solution of *linear* elasticity in two families only: ``A = B = C`` (a
p-wave, ``w = sqrt(3)/2 pi c_p``) and ``A + B + C = 0`` (a divergence-free s-wave,
``w = sqrt(3)/2 pi c_s``).  For the neo-Hookean solid it is exact as ``U0 -> 0``, or at any
amplitude with ``manufactured=True``: then the body force and the boundary tractions that the
motion implies are applied (see ``manufactured``).

``start="moving"`` shifts the wave by a quarter of its period, ``sin(w t)`` for ``cos(w t)``: it
begins at ``u = 0`` with all of its energy in the velocity.  A start at full displacement is no
state of rest of the *discrete* body.  The difference is a truncation error that becomes waves, and
a method without damping carries them for ever.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.moduli import first_lame
from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Box
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.manufactured import manufactured_body_force, nonlinear_first_piola
from sphsolid.scenes.scene import NoBodyForce, Scene, Traction

Array = NDArray[np.float64]
Family = Literal["A=B=C", "A+B+C=0"]
Start = Literal["displaced", "moving"]
COEFFICIENTS: dict[str, tuple[float, float, float]] = {
    "A=B=C": (1.0, 1.0, 1.0),
    "A+B+C=0": (1.0, 1.0, -2.0),
}


@dataclass(frozen=True)
class StandingWave:
    """The motion, with the linear or (``nonlinear=True``) the full stress of its deformation.

    ``amplitude`` ``U0`` [m]; ``coefficients`` ``(A, B, C)``; ``frequency`` ``w`` [rad/s].
    ``start`` is ``"displaced"``, ``cos(w t)``, or ``"moving"``, ``sin(w t)``.
    """

    amplitude: float
    coefficients: tuple[float, float, float]
    frequency: float
    material: NeoHookean
    nonlinear: bool
    start: Start = "displaced"

    @property
    def period(self) -> float:
        """``2 pi / w`` [s]."""
        return 2.0 * math.pi / self.frequency

    @property
    def momentum_scale(self) -> float:
        """``rho0 w |U0| max|A, B, C| / sqrt(8)``: each shape has norm 1/sqrt(8) over the cube."""
        largest = max(abs(c) for c in self.coefficients)
        size = abs(self.amplitude) * largest / math.sqrt(8.0)
        return self.material.density * self.frequency * size

    @property
    def stress_scale(self) -> float:
        """``mu pi |U0| / sqrt(8)``, one scale for all nine components (some of them are zero)."""
        return self.material.mu * math.pi * abs(self.amplitude) / math.sqrt(8.0)

    def displacement(self, X: Array, t: float) -> Array:
        """``u (n, 3)`` [m]."""
        return self._swing(t) * self._shape(X)

    def velocity(self, X: Array, t: float) -> Array:
        """``du/dt (n, 3)`` [m/s]."""
        phase = self.frequency * t
        rate = math.cos(phase) if self.start == "moving" else -math.sin(phase)
        return self.frequency * self.amplitude * rate * self._shape(X)

    def displacement_gradient(self, X: Array, t: float) -> Array:
        """``du_i/dX_I (n, 3, 3)``."""
        s, c = np.sin(0.5 * np.pi * X), np.cos(0.5 * np.pi * X)
        gradient = np.empty((len(X), 3, 3))
        for i, coefficient in enumerate(self.coefficients):
            for k in range(3):
                factor = np.ones(len(X))
                for d in range(3):
                    if d == k:
                        factor = factor * (c[:, d] if d == i else -s[:, d])
                    else:
                        factor = factor * (s[:, d] if d == i else c[:, d])
                gradient[:, i, k] = coefficient * factor
        return 0.5 * np.pi * self._swing(t) * gradient

    def deformation_gradient(self, X: Array, t: float) -> Array:
        """``F = I + grad u (n, 3, 3)``."""
        return np.eye(3) + self.displacement_gradient(X, t)

    def first_piola(self, X: Array, t: float) -> Array:
        """``P (n, 3, 3)`` [Pa]: linear elasticity, or the material's own stress."""
        if self.nonlinear:
            return nonlinear_first_piola(self.material, self.deformation_gradient(X, t))
        gradient = self.displacement_gradient(X, t)
        lam = first_lame(self.material.mu, self.material.kappa)
        trace = np.trace(gradient, axis1=1, axis2=2)
        strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
        return lam * trace[:, None, None] * np.eye(3) + 2.0 * self.material.mu * strain

    def body_force(self, X: Array, t: float) -> Array:
        """``f0 = rho0 d2u/dt2 - DIV P (n, 3)`` [N/m^3] that makes the motion exact."""
        return manufactured_body_force(
            self.material,
            X,
            self._swing(t),
            self.coefficients,
            self.frequency,
        )

    def traction(self, X: Array, N: Array, t: float) -> Array:
        """``t_B = P N (n, 3)`` [Pa]."""
        return np.einsum("nij,nj->ni", self.first_piola(X, t), N)

    def _swing(self, t: float) -> float:
        """``U0 cos(w t)`` or ``U0 sin(w t)`` [m]: exactly zero at the start of a moving one."""
        swing = math.sin if self.start == "moving" else math.cos
        return self.amplitude * swing(self.frequency * t)

    def _shape(self, X: Array) -> Array:
        s, c = np.sin(0.5 * np.pi * X), np.cos(0.5 * np.pi * X)
        A, B, C = self.coefficients
        return np.stack(
            [
                A * s[:, 0] * c[:, 1] * c[:, 2],
                B * c[:, 0] * s[:, 1] * c[:, 2],
                C * c[:, 0] * c[:, 1] * s[:, 2],
            ],
            axis=1,
        )


def amplitude_of_gradient(family: Family, largest_gradient: float) -> float:
    """``U0`` [m] at which the largest principal value of ``grad u`` is ``largest_gradient``.

    At the origin ``grad u = U0 pi/2 diag(A, B, C)``.
    """
    return largest_gradient / (0.5 * math.pi * max(abs(c) for c in COEFFICIENTS[family]))


@dataclass(frozen=True)
class AtStart:
    """A field of the wave at ``t = 0``."""

    field: Callable[[Array, float], Array]

    def __call__(self, X: Array) -> Array:
        """Its values at ``X (n, 3)``."""
        return self.field(X, 0.0)


def swinging_cube(
    *,
    family: Family = "A+B+C=0",
    amplitude: float = 5.0e-4,
    manufactured: bool = False,
    young_modulus: float = 17.0e6,
    poisson_ratio: float = 0.3,
    density: float = 1100.0,
    start: Start = "displaced",
    jitter: float = 0.0,
    seed: int = 0,
) -> Scene:
    """The swinging cube of ``family`` with amplitude ``U0`` [m], to the end of one period.

    It begins ``"displaced"`` and at rest, or ``"moving"`` through ``u = 0``.  ``jitter`` disorders
    the interior particles (see ``box_mesh``).  Raises ``InputError`` for an unknown family or
    start, a zero or non-finite amplitude, or one so large that the motion turns a volume inside out
    (``pi/2 U0 max|A, B, C| >= 0.5``).
    """
    if family not in COEFFICIENTS:
        raise InputError(
            f"swinging_cube: family {family!r} is not one of {sorted(COEFFICIENTS)}; other "
            "coefficients are no solution of linear elasticity"
        )
    require(
        start in ("displaced", "moving"),
        f"swinging_cube: start = {start!r} must be 'displaced' or 'moving'",
    )
    coefficients = COEFFICIENTS[family]
    gradient = 0.5 * math.pi * abs(amplitude) * max(abs(c) for c in coefficients)
    require(
        0.0 < gradient < 0.5,
        f"swinging_cube: amplitude = {amplitude} m gives max |grad u| = {gradient:.3g}, which must "
        "lie in (0, 0.5); use 1e-7 for the linear limit, about 0.1 for large strains",
    )
    material = NeoHookean.from_young(
        young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density
    )
    speed = (
        reference_p_wave_speed(material)
        if family == "A=B=C"
        else math.sqrt(material.mu / material.density)
    )
    frequency = 0.5 * math.sqrt(3.0) * math.pi * speed
    wave = StandingWave(float(amplitude), coefficients, frequency, material, manufactured, start)
    rollers = tuple(Constraint(face, "normal") for face in ("X-", "Y-", "Z-"))
    skew = tuple(Constraint(face, "tangential") for face in ("X+", "Y+", "Z+"))
    loaded = ("X-", "Y-", "Z-", "X+", "Y+", "Z+") if manufactured else ()
    return Scene(
        name="swinging_cube_manufactured" if manufactured else "swinging_cube",
        body=Box(jitter=jitter, seed=seed),
        material=material,
        end_time=wave.period,
        initial_displacement=AtStart(wave.displacement),
        initial_velocity=AtStart(wave.velocity),
        initial_deformation_gradient=AtStart(wave.deformation_gradient),
        constraints=rollers + skew,
        tractions=tuple(Traction(face, wave.traction) for face in loaded),
        body_force=wave.body_force if manufactured else NoBodyForce(),
        exact=wave,
        probes={"corner": (1.0, 1.0, 1.0)},
        provenance=(
            "Published: geometry, boundary conditions, E, nu, rho0 [Lee2017 section 8.1]. "
            "Chosen: U0, coefficients (A, B, C), error averaged over one period"
            + ("; body force and tractions manufactured." if manufactured else ".")
        ),
    )
