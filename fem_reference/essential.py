"""Essential conditions of a mesh: prescribed velocity components."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_reference.updates import keep_free
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.constraint import (
    Constraint,
    EssentialPart,
    essential_parts,
    prescribed_parts,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EssentialConditions:
    """All constraints of a mesh: ``v_a <- (I - Q_a) v_a + Q_a v_prescribed(X_a, t)``.

    ``nodes (n,)`` are the constrained nodes, ``free (n, 3, 3)`` their ``I - Q_a``; ``parts`` the
    constraints; ``X (N, 3)`` [m].
    """

    nodes: NDArray[np.int64]
    free: Array
    parts: tuple[EssentialPart, ...]
    X: Array

    @classmethod
    def of(cls, constraints: tuple[Constraint, ...], mesh: Mesh) -> EssentialConditions:
        """Collect ``constraints`` on ``mesh``; raises ``InputError`` for an unknown tag."""
        parts = essential_parts(constraints, mesh)
        free = np.tile(np.eye(3), (len(mesh.vertices), 1, 1))
        constrained = np.zeros(len(mesh.vertices), dtype=bool)
        for part in parts:
            free[part.particles] -= part.projector
            constrained[part.particles] = True
        nodes = np.flatnonzero(constrained)
        return cls(nodes, free[nodes], tuple(parts), mesh.vertices)

    @property
    def driven(self) -> tuple[EssentialPart, ...]:
        """Those that move."""
        return tuple(part for part in self.parts if not part.is_fixed)

    def apply(self, velocity: Array, t: float) -> None:
        """Overwrite the constrained components of ``velocity (N, 3)`` [m/s] at time ``t``."""
        if len(self.nodes) == 0:
            return
        keep_free(self.nodes, self.free, velocity)
        for rows, prescribed in prescribed_parts(self.parts, self.X, t):
            velocity[rows] += prescribed

    def by_face(self, reaction: Array) -> dict[str, Array]:
        """Sum over a constrained face of its share of ``reaction (n, 3)`` at ``nodes``."""
        sums: dict[str, Array] = {}
        for part in self.parts:
            rows = np.searchsorted(self.nodes, part.particles)
            share = np.einsum("nij,nj->i", part.projector, reaction[rows])
            sums[part.face] = sums.get(part.face, np.zeros(3)) + share
        return sums
