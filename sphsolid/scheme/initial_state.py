"""The state at ``t = 0``: momenta, positions and strains of what the scene says, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.errors import InputError
from sphsolid.scenes.scene import Scene
from sphsolid.scheme.equilibrium import equilibrated
from sphsolid.scheme.initial_strain import Equilibrated, Given, InitialStrain
from sphsolid.scheme.right_hand_side import RightHandSide, State

Array = NDArray[np.float64]


def initial_state(scene: Scene, rhs: RightHandSide, strain: InitialStrain) -> State:
    """Momenta with the constraints imposed, positions, and ``F, H, J`` as ``strain`` says.

    Raises ``InputError`` where the state is inside out or not finite, and as
    :func:`~sphsolid.scheme.equilibrium.equilibrated` does.
    """
    cloud, formulation = rhs.cloud, rhs.formulation
    u, v = scene.initial_state(cloud.X)
    p = scene.material.density * v
    rhs.essential.impose(p, 0.0)
    x = cloud.X + u
    state = State.zeros(cloud.size, formulation, particle_major=cloud.particle_major)
    F = state.F
    if isinstance(strain, Given):
        F[:] = _stated(scene, cloud)
    else:
        rhs.deformation_gradient(x, F)
        if isinstance(strain, Equilibrated):
            _check(scene, cloud, F)
            x = equilibrated(rhs, x, _stated(scene, cloud))
            rhs.deformation_gradient(x, F)
    _check(scene, cloud, F)
    entries = split(F)
    state.p[:], state.x[:] = p, x
    if formulation.evolves_H:
        state.H[:] = join(cofactor(entries))
    if formulation.evolves_J:
        state.J[:] = determinant(entries)
    return state


def _stated(scene: Scene, cloud: Cloud) -> Array:
    stated = scene.stated_deformation(cloud.X)
    _check(scene, cloud, stated)
    return stated


def _check(scene: Scene, cloud: Cloud, F: Array) -> None:
    detF = np.asarray(determinant(split(F)))
    invalid = np.flatnonzero(~(detF > 0.0))
    if len(invalid):
        a = int(invalid[0])
        raise InputError(
            f"scene {scene.name!r}: the initial state is inside out or not finite at "
            f"{len(invalid)} of {cloud.size} particles, the first {a} at X = "
            f"{cloud.X[a].tolist()} m (det F = {detF[a]:.3g}); reduce the initial "
            "displacement or correct the initial deformation gradient"
        )
