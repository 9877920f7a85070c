"""Essential conditions: which velocity components a boundary region prescribes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh
from sphsolid.geometry.patches import smooth_patches
from sphsolid.scenes import checks
from sphsolid.scenes.callbacks import asked

Array = NDArray[np.float64]
#: Velocity field ``v(X (n, 3), t) -> (n, 3)`` [m/s].
VelocityField = Callable[[Array, float], Array]
Direction = Literal["normal", "tangential", "all"]


@dataclass(frozen=True)
class Fixed:
    """The constrained components do not move."""

    def __call__(self, X: Array, t: float) -> Array:
        """Zero velocity ``(n, 3)``."""
        return np.zeros_like(X)


@dataclass(frozen=True)
class Constraint:
    """On the boundary tag ``face`` the ``direction`` components of velocity equal ``velocity``.

    ``normal`` is a roller (symmetry plane), ``tangential`` a skew-symmetry plane, ``all`` a
    clamp.  Directions refer to the undeformed body.
    """

    face: str
    direction: Direction
    velocity: VelocityField = Fixed()

    def __post_init__(self) -> None:
        """Refuse an unknown direction and a velocity that is no function."""
        if not isinstance(self.face, str):
            raise InputError(f"Constraint: face = {self.face!r} is not the name of a boundary tag")
        checks.function(f"constraint on {self.face!r}: velocity", self.velocity, "lambda X, t")
        if self.direction not in ("normal", "tangential", "all"):
            raise InputError(
                f"constraint on {self.face!r}: direction {self.direction!r} is not one of "
                "'normal', 'tangential', 'all'"
            )


@dataclass(frozen=True)
class EssentialPart:
    """One constraint ready to apply: ``v <- (I - Q_a) v + Q_a v_prescribed`` at ``particles``.

    ``face`` is its boundary tag; ``particles (n,)``; ``projector (n, 3, 3)`` orthogonal projectors
    ``Q_a``.  Projectors of different parts at one particle are mutually orthogonal, so the order
    does not matter.
    """

    face: str
    particles: NDArray[np.int64]
    projector: Array
    velocity: VelocityField

    def prescribed(self, X: Array, t: float) -> Array:
        """Checked velocity ``(n, 3)`` [m/s] at ``X (n, 3)``; see :func:`callbacks.asked`."""
        return asked(self.velocity, X, what=f"prescribed velocity on {self.face}", t=t)

    @property
    def is_fixed(self) -> bool:
        """True when the prescribed velocity is zero at all times."""
        return isinstance(self.velocity, Fixed)


def vertex_normals(mesh: Mesh, face: str) -> list[tuple[NDArray[np.int64], Array]]:
    """Unit outward normals at the vertices of a tag, area-weighted: ``(n,), (n, 3)`` a patch.

    A vertex on a sharp edge of the tag is in the patches of all its sides
    (:func:`~sphsolid.geometry.patches.smooth_patches`).
    """
    found = []
    for facets in smooth_patches(mesh, mesh.face(face)):
        particles = np.unique(facets)
        area = area_vectors(mesh, facets)[particles]
        found.append((particles, area / np.linalg.norm(area, axis=1, keepdims=True)))
    return found


def essential_parts(constraints: tuple[Constraint, ...], mesh: Mesh) -> list[EssentialPart]:
    """Projectors of every constraint; a later one only adds directions still free at a particle.

    A tag that goes round a sharp edge is as if each of its sides had a tag.
    """
    taken = np.zeros((len(mesh.vertices), 3, 3))
    parts = []
    sides = [
        (constraint, *side)
        for constraint in constraints
        for side in vertex_normals(mesh, constraint.face)
    ]
    for constraint, particles, normal in sides:
        nn = normal[:, :, None] * normal[:, None, :]
        wanted = {
            "normal": nn,
            "tangential": np.eye(3) - nn,
            "all": np.broadcast_to(np.eye(3), nn.shape),
        }[constraint.direction]
        # Directions that this constraint adds to those already taken: the range of
        # (I - T) wanted (I - T), made an orthogonal projector by its eigenvectors.
        free = np.eye(3) - taken[particles]
        value, vector = np.linalg.eigh(free @ wanted @ free)
        kept = vector * (value > 1e-8)[:, None, :]
        projector = kept @ np.swapaxes(kept, 1, 2)
        taken[particles] += projector
        parts.append(EssentialPart(constraint.face, particles, projector, constraint.velocity))
    return parts
