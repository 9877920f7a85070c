"""Small scenes that the checks share: nothing in them is zero or equal by symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.cloud.cloud import Cloud
from sphsolid.continuum import law
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.geometry.integrals import area_vectors
from sphsolid.scenes import Box, Constraint, Scene, Traction

Array = NDArray[np.float64]
FACES = ("X-", "X+", "Y-", "Y+", "Z-", "Z+")
MOONEY = sph.MooneyRivlin.from_young(
    young_modulus=17.0e6, poisson_ratio=0.4, density=1100.0, cofactor_share=0.4
)
RUBBER = sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.45, density=1100.0)
FORMULATIONS = (sph.PF(), sph.PFJ(), sph.PFHJ(), sph.PJ(), sph.Displacement())


def stress_of(material: Any, F: Array) -> Array:
    """``P(F, cof F, det F) (3, 3)`` [Pa]."""
    entries = split(F)
    return join(law.first_piola(material, entries, cofactor(entries), determinant(entries)))


# ------------------------------------------------------------- every kind of load at once
TRACTION = np.array([3.0e5, -2.0e5, 1.0e5])


def pulled(X: Array, N: Array, t: float) -> Array:
    """A traction that varies over the face and in time."""
    return TRACTION * (1.0 + X[:, [1]]) * (1.0 + 300.0 * t)


def pressed(X: Array, N: Array, t: float) -> Array:
    """A pressure along the undeformed normal."""
    return -2.0e5 * N


def weight(X: Array, t: float) -> Array:
    """A body force that varies in space and time."""
    return 1.0e6 * (1.0 + 200.0 * t) * np.stack([X[:, 1], -X[:, 2], X[:, 0] ** 2], axis=1)


def driven(X: Array, t: float) -> Array:
    """Velocity of the driven face."""
    return np.stack([1.0 + 200.0 * t + X[:, 1], -X[:, 2], 0.5 * X[:, 1]], axis=1)


def _velocity(X: Array) -> Array:
    return 20.0 * np.stack([X[:, 1] ** 2, X[:, 0] * X[:, 2], -X[:, 0]], axis=1)


def _displacement(X: Array) -> Array:
    return 0.1 * np.stack([X[:, 1] * X[:, 2], X[:, 0] ** 2, X[:, 2] - X[:, 1]], axis=1)


def loaded_block(material: Any = MOONEY, *, jitter: float = 0.3) -> Scene:
    """Driven at ``X-``, on rollers at ``Y-``, pulled at ``X+`` and ``Z+``, pressed at ``Y+``."""
    return Scene(
        name="loaded block",
        body=Box(upper=(1.0, 0.8, 1.2), jitter=jitter, seed=5),
        material=material,
        end_time=1.0,
        initial_velocity=_velocity,
        initial_displacement=_displacement,
        constraints=(Constraint("X-", "all", driven), Constraint("Y-", "normal")),
        tractions=(Traction("X+", pulled), Traction("Z+", pulled), Traction("Y+", pressed)),
        body_force=weight,
    )


def held_in_loaded_block(X: Array) -> NDArray[np.bool_]:
    """The prescribed components ``(N, 3)``, said again from the coordinates."""
    held = np.zeros(X.shape, dtype=bool)
    held[np.isclose(X[:, 1], 0.0), 1] = True
    held[np.isclose(X[:, 0], 0.0)] = True
    return held


def velocity_in_loaded_block(X: Array, t: float) -> Array:
    """The driven face as ``driven`` says, the rollers zero."""
    return np.where(np.isclose(X[:, [0]], 0.0), driven(X, t), 0.0)


def loads_in_loaded_block(cloud: Cloud, t: float) -> tuple[Array, Array]:
    """``E_a`` and ``f0_a`` by eq. (32), said again face by face."""
    f0 = weight(cloud.X, t)
    E = f0.copy()
    for face in ("X+", "Z+", "Y+"):
        axis = "XYZ".index(face[0])
        N = np.broadcast_to(np.eye(3)[axis], cloud.X.shape)
        # Faces are plane, so the size of the area vector is its component along the axis.
        size = area_vectors(cloud.mesh, cloud.mesh.face(face))[:, [axis]]
        t_B = (pressed if face == "Y+" else pulled)(cloud.X, N, t)
        E += size * t_B / cloud.V[:, None]
    return E, f0


# ------------------------------------------------------------- free motion
def spinning_block(*, jitter: float = 0.2, end_time: float = 0.03) -> Scene:
    """Spin about no principal axis, drift, and a start that is strained and straining."""

    def spin(X: Array) -> Array:
        return np.cross([40.0, -30.0, 105.0], X - 0.5) + [5.0, 3.0, -2.0] + 40.0 * (X - 0.5) ** 2

    def bent(X: Array) -> Array:
        return 0.15 * np.stack([X[:, 1] * X[:, 2], X[:, 0] ** 2, X[:, 2] - X[:, 1]], axis=1)

    return Scene(
        name="spinning block",
        body=Box(jitter=jitter, seed=1),
        material=RUBBER,
        end_time=end_time,
        initial_velocity=spin,
        initial_displacement=bent,
    )


# ------------------------------------------------------------- affine motion
AFFINE = np.array([[1.3, 0.4, 0.0], [-0.1, 0.7, 0.2], [0.1, 0.0, 1.1]])


def stretched_block(
    F: Array = AFFINE, *, jitter: float = 0.0, material: Any = MOONEY, loaded: bool = True
) -> Scene:
    """``x = F X``, held in equilibrium by ``t = P N`` on every face when ``loaded``."""
    P = stress_of(material, F)
    return Scene(
        name="stretched block",
        body=Box(upper=(1.0, 0.8, 1.2), jitter=jitter, seed=3),
        material=material,
        end_time=1.0,
        initial_displacement=lambda X: X @ (F - np.eye(3)).T,
        tractions=tuple(Traction(face, lambda X, N, t: N @ P.T) for face in FACES if loaded),
    )
