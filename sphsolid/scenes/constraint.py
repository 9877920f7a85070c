"""Essential conditions: which velocity components a boundary region prescribes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
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
    ``Q_a`` on the directions that it adds to those of parts before it.  Projectors of different
    parts at one particle are mutually orthogonal.

    The directions that are wanted need not be orthogonal: two sides may meet at any angle.  Then
    ``lift (n, 3, 3)`` takes what the wanted components lack of the prescribed ones, with the parts
    before it, to the velocity along the added directions.  ``is_oblique`` says that one particle at
    least needs it; else ``lift`` is the projector.
    """

    face: str
    particles: NDArray[np.int64]
    projector: Array
    velocity: VelocityField
    lift: Array
    is_oblique: bool

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

    A tag that goes round a sharp edge is as if each of its sides had a tag.  Raises ``InputError``
    for a motion that nothing is left of: constraints before it have taken all of its directions.
    """
    taken = np.zeros((len(mesh.vertices), 3, 3))
    parts = list[EssentialPart]()
    for constraint in constraints:
        sides = vertex_normals(mesh, constraint.face)
        added = [part_of(constraint, *side, taken) for side in sides]
        if not any(np.any(part.projector) for part in added):
            _refuse_motion_left_out(constraint, added, parts)
        parts += added
    return parts


def _refuse_motion_left_out(
    constraint: Constraint, added: list[EssentialPart], before: list[EssentialPart]
) -> None:
    """Two that hold a region still may overlap; two motions, or one and a hold, may not."""
    own = np.concatenate([part.particles for part in added])
    others = [part for part in before if np.any(np.isin(part.particles, own))]
    moving = {part.face for part in others if not part.is_fixed}
    if isinstance(constraint.velocity, Fixed) and not moving:
        return
    raise InputError(
        f"constraint on {constraint.face!r}, {constraint.direction!r}: constraints before it, on "
        f"{', '.join(sorted({part.face for part in others}))}, prescribe all of its directions, so "
        "that nothing of it would be done; leave one of them out, or put this one first"
    )


def part_of(
    constraint: Constraint, particles: NDArray[np.int64], normal: Array, taken: Array
) -> EssentialPart:
    """``constraint`` at ``particles (n,)`` with unit normals ``(n, 3)``.

    ``taken (N, 3, 3)`` are projectors on the directions that parts before it have; those that it
    adds are added there.
    """
    nn = normal[:, :, None] * normal[:, None, :]
    wanted = {
        "normal": nn,
        "tangential": np.eye(3) - nn,
        "all": np.broadcast_to(np.eye(3), nn.shape),
    }[constraint.direction]
    before = taken[particles]
    # Directions that this constraint adds to those already taken: the range of
    # (I - T) wanted (I - T), made an orthogonal projector by its eigenvectors.
    free = np.eye(3) - before
    value, vector = np.linalg.eigh(free @ wanted @ free)
    kept = vector * (value > 1e-8)[:, None, :]
    projector = kept @ np.swapaxes(kept, 1, 2)
    # w m = w (v_prescribed - v_before) for the m along the added directions.
    lift = kept @ np.linalg.pinv(wanted @ kept, rcond=1e-5) @ wanted
    is_oblique = max(np.abs(lift - projector).max(), np.abs(lift @ before).max()) > 1e-9
    taken[particles] += projector
    return EssentialPart(
        constraint.face, particles, projector, constraint.velocity,
        lift if is_oblique else projector, bool(is_oblique),
    )  # fmt: skip


def prescribed_parts(
    parts: Sequence[EssentialPart], X: Array, t: float
) -> Iterator[tuple[NDArray[np.int64], Array]]:
    """What is prescribed at time ``t`` [s] of the constrained components: rows, ``(n, 3)`` [m/s].

    What is handed out adds up.  ``X (N, 3)`` [m] are all particles.
    """
    if not any(part.is_oblique for part in parts):
        for part in parts:
            if not part.is_fixed:
                given = part.prescribed(X[part.particles], t)
                yield part.particles, np.einsum("nij,nj->ni", part.projector, given)
        return
    whole = np.zeros_like(X)
    for part in parts:
        rows = part.particles
        wanted = np.zeros((len(rows), 3)) if part.is_fixed else part.prescribed(X[rows], t)
        whole[rows] += np.einsum("nij,nj->ni", part.lift, wanted - whole[rows])
    rows = np.unique(np.concatenate([part.particles for part in parts]))
    yield rows, whole[rows]
