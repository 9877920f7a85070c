"""Scenes of the hard cases that are not benchmarks: seeded blocks and a block pulled apart."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.continuum.wave_speed import reference_p_wave_speed
from sphsolid.errors import InputError
from sphsolid.scenes import Box, Constraint, Scene

Array = NDArray[np.float64]
Pattern = Literal["sawtooth", "hourglass", "noise"]
#: Seeds are small beside everything, so the solid answers linearly: velocity over wave speed,
#: or relative change of volume.
SEED = 1.0e-4
#: Noise of the pulled block: velocity over p-wave speed.
PULL_NOISE = 1.0e-3
#: Speed [m/s] of either end of the pulled block: a twentieth of its shear wave speed.
PULL = 5.0
CROSSINGS = 100


def alternating(X: Array, spacing: float, axes: str = "xyz") -> Array:
    """``(-1)^(i+j+k) (n,)`` over the lattice numbers of ``X (n, 3)`` along ``axes``."""
    number = np.rint(X[:, ["xyz".index(axis) for axis in axes]] / spacing)
    return np.asarray((-1.0) ** number.sum(axis=1))


@dataclass(frozen=True)
class Seed:
    """A velocity [m/s] that a sound method damps or at least keeps bounded.

    ``sawtooth``: ``v_x`` alternates along X (no gradient at particles, one at cell centroids);
    ``hourglass``: ``v_x`` alternates along all axes (no gradient at either); ``noise``: random.
    """

    pattern: Pattern
    size: float
    spacing: float

    def __call__(self, X: Array) -> Array:
        """``(n, 3)``."""
        if self.pattern == "noise":
            return self.size * np.random.default_rng(7).standard_normal(X.shape)
        axes = {"sawtooth": "x", "hourglass": "xyz"}.get(self.pattern)
        if axes is None:
            raise InputError(
                f"pattern {self.pattern!r} is not one of 'sawtooth', 'hourglass', 'noise'"
            )
        along = self.size * alternating(X, self.spacing, axes)
        return np.stack([along, *np.zeros((2, len(X)))], axis=1)


def block(*, poisson_ratio: float = 0.495) -> Scene:
    """A unit cube at rest, clamped at ``X = 0``, for :data:`CROSSINGS` transits of a p-wave."""
    material = NeoHookean.from_young(
        young_modulus=17.0e6, poisson_ratio=poisson_ratio, density=1100.0
    )
    return Scene(
        name="seeded_block",
        body=Box(),
        material=material,
        end_time=CROSSINGS / reference_p_wave_speed(material),
        constraints=(Constraint("X-", "all"),),
        provenance="Ours: the twisting column's solid, a seed of 1e-4.",
    )


def seeded_block(*, pattern: Pattern, spacing: float) -> Scene:
    """The block with a :class:`Seed` in its velocity."""
    still = block()
    size = SEED * reference_p_wave_speed(still.material)
    return replace(still, initial_velocity=Seed(pattern, size, spacing))


@dataclass(frozen=True)
class Pulling:
    """``v_x = 2 PULL (X - 1/2)`` at all times: both ends move apart at :data:`PULL` [m/s]."""

    noise: float = 0.0

    def __call__(self, X: Array, t: float = 0.0) -> Array:
        """``(n, 3)`` [m/s]."""
        velocity = np.zeros_like(X)
        velocity[:, 0] = 2.0 * PULL * (X[:, 0] - 0.5)
        return velocity + self.noise * np.random.default_rng(7).standard_normal(X.shape)


def pulled_block(*, noisy: bool, poisson_ratio: float = 0.45) -> Scene:
    """A unit cube pulled along X to twice its length, free to become thinner.

    ``noisy``: the initial velocity has noise of :data:`PULL_NOISE` of the p-wave speed in it.
    """
    material = NeoHookean.from_young(
        young_modulus=17.0e6, poisson_ratio=poisson_ratio, density=1100.0
    )
    noise = PULL_NOISE * reference_p_wave_speed(material) if noisy else 0.0
    return Scene(
        name="pulled_block",
        body=Box(),
        material=material,
        end_time=0.5 / PULL,
        initial_velocity=Pulling(noise),
        constraints=tuple(Constraint(face, "normal", Pulling()) for face in ("X-", "X+")),
        provenance="Ours: uniform tension to stretch 2, the seat of the tensile instability.",
    )
