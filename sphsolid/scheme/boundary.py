"""Loads ``E_a`` of eq. (32) and essential conditions on ``p``, [Lee2017] section 5."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud
from sphsolid.compiled import kernel, prange
from sphsolid.scenes.constraint import essential_parts, prescribed_parts
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]


@kernel
def _reaction(particles, free, rate, out):  # type: ignore[no-untyped-def]
    for n in prange(len(particles)):
        a = particles[n]
        r0, r1, r2 = rate[a, 0], rate[a, 1], rate[a, 2]
        for i in range(3):
            kept = free[n, i, 0] * r0 + free[n, i, 1] * r1 + free[n, i, 2] * r2
            out[n, i] = kept - rate[a, i]


@kernel
def _keep_free(particles, free, rate):  # type: ignore[no-untyped-def]
    for n in prange(len(particles)):
        a = particles[n]
        r0, r1, r2 = rate[a, 0], rate[a, 1], rate[a, 2]
        for i in range(3):
            rate[a, i] = free[n, i, 0] * r0 + free[n, i, 1] * r1 + free[n, i, 2] * r2


class Loads:
    """``E_a = (A_a / V_a) t_B + f0`` and its body-force part, evaluated once per instant."""

    def __init__(self, scene: Scene, cloud: Cloud) -> None:
        self._scene = scene
        self._X = cloud.X
        self._patches = []
        for traction in scene.tractions:
            for area in cloud.areas_of_sides(traction.face):
                particles = np.flatnonzero(np.linalg.norm(area, axis=1) > 0.0)
                size = np.linalg.norm(area[particles], axis=1)
                normal = area[particles] / size[:, None]
                per_volume = (size / cloud.V[particles])[:, None]
                self._patches.append((traction, particles, normal, per_volume))
        self._at: float | None = None
        # Nothing writes into them: one zero for all.
        self._total = self._body = np.broadcast_to(np.zeros(3), cloud.X.shape)

    @property
    def any(self) -> bool:
        """False when neither a traction nor a body force acts."""
        return bool(self._patches) or self.has_body_force

    @property
    def has_body_force(self) -> bool:
        """True when the scene has a body force."""
        return not isinstance(self._scene.body_force, NoBodyForce)

    def at(self, t: float) -> tuple[Array, Array]:
        """``E_a`` and ``f0_a`` ``(N, 3)`` [N/m^3] at time ``t``; do not write into them."""
        if t != self._at:
            if self.has_body_force:
                self._body = self._scene.body_force_at(self._X, t)
            self._total = self._body.copy() if self._patches else self._body
            for traction, particles, normal, per_volume in self._patches:
                value = traction.at(self._X[particles], normal, t)
                self._total[particles] += per_volume * value
            self._at = t
        return self._total, self._body


class EssentialConditions:
    """Projectors of the scene's constraints on the cloud's boundary particles."""

    def __init__(self, scene: Scene, cloud: Cloud) -> None:
        parts = essential_parts(scene.constraints, cloud.mesh)
        self._density = scene.material.density
        self._X = cloud.X
        self._parts = parts
        constrained = [part.particles for part in parts]
        self.particles = np.unique(np.concatenate(constrained)) if parts else np.zeros(0, np.int64)
        taken = np.zeros((cloud.size, 3, 3))
        for part in parts:
            taken[part.particles] += part.projector
        free = np.eye(3) - taken[self.particles]
        #: Projectors ``(n, 3, 3)`` at ``particles`` on what no condition takes.  Axis-aligned ones
        #: are exact zeros and ones, so that a fixed component is zero.
        self.free = np.where(np.abs(free) < 1e-14, 0.0, free)

    def impose(self, p: Array, t: float) -> None:
        """Set the constrained components of ``p (N, 3)`` to ``rho0`` times their velocity."""
        self.release(p)
        self.prescribe(p, t)

    def prescribe(self, p: Array, t: float) -> None:
        """Add to the constrained components, which are zero, ``rho0`` times their velocity."""
        for rows, v in prescribed_parts(self._parts, self._X, t):
            p[rows] += self._density * v

    def by_face(self, reaction: Array) -> dict[str, Array]:
        """Sum over a constrained face of its share of ``reaction (n, 3)`` at ``particles``."""
        sums: dict[str, Array] = {}
        for part in self._parts:
            rows = np.searchsorted(self.particles, part.particles)
            share = np.einsum("nij,nj->i", part.projector, reaction[rows])
            sums[part.face] = sums.get(part.face, np.zeros(3)) + share
        return sums

    def reaction(self, rate: Array, out: Array) -> None:
        """``out (n, 3)``: what :meth:`release` will add to ``rate`` at ``particles (n,)``."""
        if len(self.particles):
            _reaction(self.particles, self.free, rate, out)

    def constrained(self, f: Array) -> Array:
        """The constrained components of vectors ``f (n, 3)`` at ``particles (n,)``."""
        return f - np.einsum("nij,nj->ni", self.free, f)

    def release(self, rate: Array) -> None:
        """Zero the constrained components of a rate ``(N, 3)``."""
        if len(self.particles):
            _keep_free(self.particles, self.free, rate)
