"""The cable: a one-dimensional wave in an elastic bar, d'Alembert's solution.

A bar of ``L = 10`` m along X is fixed at ``X = 0`` and pulled at ``X = L`` by the traction
``s(t)``, ``nu = 0``.  Rollers on the four sides cost nothing then and keep the motion to one
dimension.  With ``c = sqrt(E / rho0)`` (5000 m/s) the wave runs to the wall, where displacement
changes sign and stress doubles, and back to the free end, where stress changes sign:

    u(X, t) = c / E sum_n (-1)^n [ S(t - ((2n+1) L - X) / c) - S(t - ((2n+1) L + X) / c) ],

``S`` the time integral of ``s``.  Everything repeats after ``4 L / c`` = 8 ms where ``S`` does not
outlast the run.

A textbook problem used to test methods of this family; not in [Lee2017].  Taken over: L, E, rho0,
nu and the step of 5e7 Pa.  Ours: the cross-section (``width``), the rollers and the smooth pulse.

The solution is that of *linear* elasticity.  The neo-Hookean bar meets it as ``stress / E -> 0``;
at 5e7 Pa the strain is 2.5e-4, up to 5e-4 at the wall, which bends the wave speed by as much.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import InputError, require
from sphsolid.geometry.body import Box
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene, Traction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Step:
    """``s(t) = 1`` from the start on, times the stress of the scene."""

    def value(self, t: Array) -> Array:
        """``s``, dimensionless; zero before the start."""
        return np.where(t >= 0.0, 1.0, 0.0)

    def integral(self, t: Array) -> Array:
        """``S(t)`` [s], the integral of ``s`` from the start."""
        return np.maximum(t, 0.0)


@dataclass(frozen=True)
class Pulse:
    """``s(t) = sin^4(pi t / duration)`` while it lasts [s]: three derivatives are continuous."""

    duration: float = 2.0e-3

    def __post_init__(self) -> None:
        require(
            math.isfinite(self.duration) and self.duration > 0.0,
            f"cable: duration = {self.duration} s of the pulse must be positive and finite",
        )

    def value(self, t: Array) -> Array:
        """``s``, dimensionless; zero before and after."""
        inside = (t >= 0.0) & (t <= self.duration)
        return np.where(inside, np.sin(math.pi * t / self.duration) ** 4, 0.0)

    def integral(self, t: Array) -> Array:
        """``S(t)`` [s], the integral of ``s`` from the start."""
        T = self.duration
        phase = 2.0 * math.pi * np.clip(t, 0.0, T) / T
        return np.asarray(
            T / (2.0 * math.pi) * (0.375 * phase - 0.5 * np.sin(phase) + np.sin(2 * phase) / 16.0)
        )


Load = Step | Pulse


@dataclass(frozen=True)
class Pull:
    """The traction ``s(t) stress N`` [Pa]."""

    stress: float
    load: Load

    def __call__(self, X: Array, N: Array, t: float) -> Array:
        """The traction ``(n, 3)``."""
        return float(self.load.value(np.asarray(t))) * self.stress * N


@dataclass(frozen=True)
class BarWave:
    """d'Alembert's solution of the pulled bar.

    ``stress`` [Pa] is the traction at ``s = 1``; ``length``, ``area`` of the cross-section.
    """

    stress: float
    load: Load
    length: float
    area: float
    young_modulus: float
    density: float

    @property
    def speed(self) -> float:
        """``c = sqrt(E / rho0)`` [m/s]."""
        return math.sqrt(self.young_modulus / self.density)

    @property
    def period(self) -> float:
        """``4 L / c`` [s]: there and back twice."""
        return 4.0 * self.length / self.speed

    @property
    def momentum_scale(self) -> float:
        """Norm of the momentum ``stress / c`` all over the bar [kg/(m^2 s) m^1.5]."""
        return abs(self.stress) / self.speed * math.sqrt(self.area * self.length)

    @property
    def stress_scale(self) -> float:
        """Norm of ``stress`` all over the bar [Pa m^1.5]."""
        return abs(self.stress) * math.sqrt(self.area * self.length)

    def displacement(self, X: Array, t: float) -> Array:
        """``u (n, 3)`` [m], along X."""
        incoming, reflected = self._waves(X, t, self.load.integral)
        scale = self.stress * self.speed / self.young_modulus
        return self._along_x(scale * (incoming - reflected))

    def velocity(self, X: Array, t: float) -> Array:
        """``du/dt (n, 3)`` [m/s], along X."""
        incoming, reflected = self._waves(X, t, self.load.value)
        scale = self.stress * self.speed / self.young_modulus
        return self._along_x(scale * (incoming - reflected))

    def axial_stress(self, X: Array, t: float) -> Array:
        """``P_xx (n,)`` [Pa]."""
        incoming, reflected = self._waves(X, t, self.load.value)
        return self.stress * (incoming + reflected)

    def deformation_gradient(self, X: Array, t: float) -> Array:
        """``F = I + du/dX e_X (x) e_X (n, 3, 3)``."""
        F = np.tile(np.eye(3), (len(X), 1, 1))
        F[:, 0, 0] += self.axial_stress(X, t) / self.young_modulus
        return F

    def first_piola(self, X: Array, t: float) -> Array:
        """``P (n, 3, 3)`` [Pa] of linear elasticity: only ``P_xx``."""
        P = np.zeros((len(X), 3, 3))
        P[:, 0, 0] = self.axial_stress(X, t)
        return P

    def _waves(
        self, X: Array, t: float, profile: Callable[[Array], Array]
    ) -> tuple[Array, Array]:
        """Sums ``(n,)`` of the waves that run towards the wall and of those that come from it."""
        towards, away = np.zeros(len(X)), np.zeros(len(X))
        sign, distance = 1.0, self.length
        while self.speed * t > distance - self.length - 1.0e-9 * self.length:
            towards += sign * profile(t - (distance - X[:, 0]) / self.speed)
            away += sign * profile(t - (distance + X[:, 0]) / self.speed)
            sign, distance = -sign, distance + 2.0 * self.length
        return towards, away

    def _along_x(self, value: Array) -> Array:
        field = np.zeros((len(value), 3))
        field[:, 0] = value
        return field


def cable(
    *,
    load: Load | None = None,
    stress: float = 5.0e7,
    width: float = 1.0,
    length: float = 10.0,
    young_modulus: float = 2.0e11,
    density: float = 8000.0,
    jitter: float = 0.0,
    seed: int = 0,
) -> Scene:
    """The bar pulled by ``load`` (default ``Step()``) times ``stress`` [Pa], for one period.

    ``width`` [m] of the square cross-section changes nothing but the cost: the spacing must
    divide it at least once.  Raises ``InputError`` for a ``load`` that is not one of the options,
    a zero stress or one beyond 1 % of ``E``, where the linear solution says little.
    """
    load = Step() if load is None else load
    if not isinstance(load, Step | Pulse):
        raise InputError(f"cable: load = {load!r} is not an option; use Step() or Pulse()")
    for name, value in (("width", width), ("length", length)):
        require(
            math.isfinite(value) and value > 0.0,
            f"cable: {name} = {value} m must be positive and finite",
        )
    material = NeoHookean.from_young(
        young_modulus=young_modulus, poisson_ratio=0.0, density=density
    )
    require(
        0.0 < abs(stress) <= 0.01 * young_modulus,
        f"cable: stress = {stress} Pa must be other than zero and at most 1 % of E = "
        f"{young_modulus:g} Pa; use 5e7 for the usual test, 1e4 for the linear limit",
    )
    wave = BarWave(float(stress), load, length, width**2, young_modulus, density)

    sides = tuple(Constraint(face, "normal") for face in ("Y-", "Y+", "Z-", "Z+"))
    return Scene(
        name=f"cable_{type(load).__name__.lower()}",
        body=Box((0.0, 0.0, 0.0), (length, width, width), jitter=jitter, seed=seed),
        material=material,
        end_time=wave.period,
        constraints=(Constraint("X-", "all"), *sides),
        tractions=(Traction("X+", Pull(stress, load)),),
        exact=wave,
        probes={
            "wall": (0.0, 0.0, 0.0),
            "middle": (0.5 * length, 0.0, 0.0),
            "free_end": (length, 0.0, 0.0),
        },
        provenance=(
            "A textbook problem, not in [Lee2017]. Taken over: L, E, rho0, nu = 0, step of 5e7 Pa. "
            f"Chosen: cross-section {width:g} x {width:g} m, rollers on the sides, {load}."
        ),
    )
