"""What is known on the faces of the boundary: prescribed velocities and tractions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference.touch_mesh import Faces
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.constraint import EssentialPart, part_of, prescribed_parts
from sphsolid.scenes.scene import Scene

Array = NDArray[np.float64]


class TouchBoundary:
    """Conditions of ``scene`` on the ``n`` boundary faces of ``mesh``.

    ``Q (n, 3, 3)`` projects on the directions in which the velocity is prescribed.  Raises
    ``InputError`` for an unknown tag.
    """

    def __init__(self, scene: Scene, mesh: Mesh, faces: Faces) -> None:
        self.X, self.size = faces.X[faces.inner :], faces.size[faces.inner :]
        self.N = faces.area[faces.inner :] / self.size[:, None]
        self.Q = np.zeros((len(self.X), 3, 3))
        self._parts: list[EssentialPart] = []
        for constraint in scene.constraints:
            at = faces.numbers(mesh.face(constraint.face))
            self._parts.append(part_of(constraint, at, self.N[at], self.Q))
        self._tractions = [
            (traction, faces.numbers(mesh.face(traction.face))) for traction in scene.tractions
        ]
        #: Faces with a prescribed component.
        self.held = np.flatnonzero(np.abs(self.Q).sum(axis=(1, 2)) > 0.0)

    def velocity(self, t: float) -> Array:
        """Prescribed part ``(n, 3)`` [m/s] of the velocities at time ``t`` [s]."""
        v = np.zeros_like(self.X)
        for rows, given in prescribed_parts(self._parts, self.X, t):
            v[rows] += given
        return v

    def traction(self, t: float) -> Array:
        """``t_B (n, 3)`` [Pa] at time ``t`` [s], zero where none is given."""
        total = np.zeros_like(self.X)
        for traction, at in self._tractions:
            total[at] += traction.at(self.X[at], self.N[at], t)
        return total

    def states(
        self, v: Array, t_in: Array, S: Array, prescribed: Array, given: Array
    ) -> tuple[Array, Array]:
        """``v^C`` and ``t^C`` of the faces from the state inside.

        ``t^C = t + S (v^C - v)``, with ``Q v^C`` as prescribed and ``t^C`` as given in all other
        directions; ``S (n, 3, 3)`` [kg/(m^2 s)] is the impedance.
        """
        free = np.eye(3) - self.Q
        lacking = given - t_in + _times(S, v - prescribed)
        A = free @ S @ free + self.Q
        found = np.linalg.solve(A, _times(free, lacking)[..., None])[..., 0] + prescribed
        return found, t_in + _times(S, found - v)

    def by_face(self, reaction: Array) -> dict[str, Array]:
        """Sum over a constrained tag of its share of ``reaction`` at the held faces."""
        whole = np.zeros_like(self.X)
        whole[self.held] = reaction
        sums: dict[str, Any] = {}
        for part in self._parts:
            share = np.einsum("nij,nj->i", part.projector, whole[part.particles])
            sums[part.face] = sums.get(part.face, np.zeros(3)) + share
        return sums


def _times(A: Array, f: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", A, f))
