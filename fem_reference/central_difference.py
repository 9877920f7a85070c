"""Explicit central differences, in the velocity-Verlet form.

    v_half = v_n + dt/2 a_n,    x_n+1 = x_n + dt v_half,    v_n+1 = v_half + dt/2 a_n+1

Second order; symplectic, so the energy of a free body oscillates but does not drift; with a
lumped mass and an internal force that has no resultant moment it conserves linear and angular
momentum to round-off, because a kick adds ``sum x_n x f_n = 0`` and a drift ``dt sum v x m v = 0``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sphsolid.scenes.constraint import Constraint, EssentialPart, essential_parts
from sphsolid.scenes.hex_mesh import HexMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EssentialConditions:
    """All constraints of a mesh: ``v_a <- (I - Q_a) v_a + Q_a v_prescribed(X_a, t)``.

    ``nodes (n,)`` are the constrained nodes, ``free (n, 3, 3)`` their ``I - Q_a``; ``driven``
    pairs each constraint that moves with its rows among ``nodes``; ``X (N, 3)`` [m].
    """

    nodes: NDArray[np.int64]
    free: Array
    driven: tuple[tuple[NDArray[np.int64], EssentialPart], ...]
    X: Array

    @classmethod
    def of(cls, constraints: tuple[Constraint, ...], mesh: HexMesh) -> EssentialConditions:
        """Collect ``constraints`` on ``mesh``; raises ``InputError`` for an unknown tag."""
        parts = essential_parts(constraints, mesh)
        free = np.tile(np.eye(3), (len(mesh.vertices), 1, 1))
        constrained = np.zeros(len(mesh.vertices), dtype=bool)
        for part in parts:
            free[part.particles] -= part.projector
            constrained[part.particles] = True
        nodes = np.flatnonzero(constrained)
        driven = tuple(
            (np.searchsorted(nodes, part.particles), part) for part in parts if not part.is_fixed
        )
        return cls(nodes, free[nodes], driven, mesh.vertices)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays held."""
        return self.nodes.nbytes + self.free.nbytes

    def apply(self, velocity: Array, t: float) -> None:
        """Overwrite the constrained components of ``velocity (N, 3)`` [m/s] at time ``t``."""
        if len(self.nodes) == 0:
            return
        value = np.einsum("nij,nj->ni", self.free, velocity[self.nodes])
        for rows, part in self.driven:
            prescribed = part.velocity(self.X[part.particles], t)
            # Projectors of different parts are orthogonal, so their sum is the whole condition.
            value[rows] += np.einsum("nij,nj->ni", part.projector, prescribed)
        velocity[self.nodes] = value


def central_difference_step(
    x: Array,
    velocity: Array,
    acceleration: Array,
    *,
    t: float,
    dt: float,
    accelerate: Callable[[Array, float, Array], None],
    essential: EssentialConditions,
) -> None:
    """Advance ``x``, ``velocity``, ``acceleration`` ``(N, 3)`` in place from ``t`` to ``t + dt``.

    ``accelerate(x, t, a)`` writes ``a = (f_external(t) - f_internal(x)) / m``.  One call of it a
    step: the acceleration at the end of a step is the one at the start of the next.  Components
    that constraints prescribe are overwritten in the velocities, which is the same as projecting
    the acceleration.
    """
    velocity += 0.5 * dt * acceleration
    essential.apply(velocity, t + 0.5 * dt)
    x += dt * velocity
    accelerate(x, t + dt, acceleration)
    velocity += 0.5 * dt * acceleration
    essential.apply(velocity, t + dt)
