"""The state at ``t = 0``: momenta, positions and strains of what the scene says, checked."""

from __future__ import annotations

from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.scenes.scene import Scene
from sphsolid.scheme.initial_strain import InitialStrain, Start
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import Field, State


def initial_state(scene: Scene, rhs: RightHandSide, strain: InitialStrain) -> State:
    """Momenta with the constraints imposed, positions, and ``F, H, J`` as ``strain`` says.

    Every term fills its own fields.  Raises ``InputError`` where the state is inside out or not
    finite, and as :func:`~sphsolid.scheme.equilibrium.equilibrated` does.
    """
    X, formulation = rhs.set_up.cloud.X, rhs.formulation
    u, v = scene.initial_state(X)
    p = scene.material.density * v
    rhs.essential.impose(p, 0.0)
    state = rhs.zeros()
    start = Start(scene, rhs, X + u)
    # A form that stores no F has one here alone.
    F = state.F if len(state.F) else rhs.operator.zeros(Field("F", "tensor"))
    x = strain.start(start, F)
    start.check(F)
    entries = split(F)
    state.p[:], state.x[:] = p, x
    if formulation.evolves_H:
        state.H[:] = join(cofactor(entries))
    if formulation.evolves_J:
        state.J[:] = determinant(entries)
    rhs.start(state)
    return state
