"""Positions whose discrete strain exerts the force of a stated strain.

A scene with an initial deformation states positions and their exact deformation gradient ``F^0``.
On the exact positions the discrete gradient differs from ``F^0`` by its truncation error, rough
from one particle to the next on a disordered cloud and ``O(dx)``.  Released at ``t = 0`` that error
sets off waves as short as the spacing whose velocities are ``O(dx)`` too, larger than any error of
the scheme itself.  They are not there if the body starts from the *elliptic projection* of the
exact displacement ([Dupont1973], [Baker1976]): the nearby positions ``x^0`` with

    sum_b V_b [ P(sum_c x^0_c (x) G_c(X_b)) - P(F^0_b) ] G_a(X_b) = 0    at every free particle,

``O(dx^2)`` away from the stated ones.  Newton's method; the tangent is symmetric where force and
gradient are adjoint, so its systems are solved by conjugate gradients without a matrix.  Rigid
motions that the constraints leave free store no energy, and are left alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.law import first_piola, tangent_action
from sphsolid.continuum.tensor import Tensor, cofactor, determinant, join, split
from sphsolid.errors import InputError
from sphsolid.scheme.elastic_response import ElasticResponse
from sphsolid.scheme.right_hand_side import RightHandSide

Array = NDArray[np.float64]
#: Force left over what it was: far below what the truncation error does later.
REMAINDER = 1.0e-4
#: A tenth of the spacing: truncation moves particles by a hundredth even on the coarsest clouds.
LARGEST_MOVE = 0.1
#: A strain this close to the stated one is round-off.
_SAME = 1.0e-13
_MOST_STEPS, _MOST_ITERATIONS = 10, 2000


def equilibrated(rhs: RightHandSide, x: Array, stated: Array) -> Array:
    """``x^0 (N, 3)`` [m] near to ``x (N, 3)`` [m] for the stated ``F^0 (N, 3, 3)``.

    Constrained components stay.  Raises ``InputError`` where a particle would have to move by more
    than a tenth of the spacing, or no such positions are found: then ``stated`` is not the
    deformation gradient of ``x``.
    """
    problem = _Equilibrium(rhs, x)
    target = _piola(rhs, split(stated))
    moved = x.copy()
    first = 0.0
    for _ in range(_MOST_STEPS):
        F = problem.gradient(moved - rhs.set_up.cloud.middle)
        if np.max(np.abs(join(F) - stated)) <= _SAME:
            return moved
        lack = problem.force(tuple(s - p for s, p in zip(target, _piola(rhs, F), strict=True)))
        size = float(np.sqrt(np.sum(lack**2)))
        first = first or size
        if size <= REMAINDER * first:
            return _checked(moved, x, rhs)
        moved += problem.solve(F, lack)
        if not np.all(np.abs(moved - x) <= LARGEST_MOVE * rhs.set_up.cloud.spacing):
            break
    return _checked(np.full_like(x, np.nan), x, rhs)


def _checked(moved: Array, x: Array, rhs: RightHandSide) -> Array:
    far = np.abs(moved - x) <= LARGEST_MOVE * rhs.set_up.cloud.spacing
    if not np.all(far):
        raise InputError(
            "initial_strain = Equilibrated(): no positions within a tenth of the spacing exert the "
            "force of the scene's initial_deformation_gradient, which is then not that of its "
            "initial_displacement; correct the scene, refine the spacing, or use Given() (stored "
            "energy without a displacement) or Compatible()"
        )
    return moved


def _piola(rhs: RightHandSide, F: Tensor) -> Tensor:
    return first_piola(rhs.material, F, cofactor(F), determinant(F))


def _free_rigid_motions(rhs: RightHandSide, x: Array) -> list[Array]:
    """Orthonormal translations and rotations ``(N, 3)`` that no constraint hinders."""
    arm = x - x.mean(axis=0)
    arm /= np.max(np.abs(arm))
    motions = [np.broadcast_to(e, x.shape) for e in np.eye(3)]
    motions += [np.cross(e, arm) for e in np.eye(3)]
    hindered = []
    for motion in motions:
        kept = motion.copy()
        rhs.essential.release(kept)
        hindered.append(motion - kept)
    blocked = np.array([[np.sum(a * b) for b in hindered] for a in hindered])
    value, vector = np.linalg.eigh(blocked)
    free: list[Array] = []
    for combination in vector.T[value <= 1.0e-9 * len(x)]:
        motion = sum(c * m for c, m in zip(combination, motions, strict=True))
        for other in free:
            motion = motion - np.sum(other * motion) * other
        free.append(motion / np.sqrt(np.sum(motion**2)))
    return free


class _Equilibrium:
    """Forces but for those that move the body rigidly, and the system for a small change."""

    def __init__(self, rhs: RightHandSide, x: Array) -> None:
        self._rhs = rhs
        self._rigid = _free_rigid_motions(rhs, x)
        self._response = ElasticResponse(rhs)
        self._V = self._response.V
        self.gradient = self._response.gradient

    def force(self, P: Tensor) -> Array:
        """``sum_b V_b P_b G_a(X_b)  (N, 3)`` [N] at free components, less what moves rigidly."""
        force = self._response.force(P)
        for motion in self._rigid:
            force -= np.sum(motion * force) * motion
        return force

    def solve(self, F: Tensor, lack: Array) -> Array:
        """The change of positions whose stresses exert ``lack``, to a thousandth."""
        change = np.zeros_like(lack)
        residual = lack.copy()
        z = residual / self._V
        direction = z.copy()
        rz = float(np.sum(residual * z))
        stop = 1.0e-6 * rz
        for _ in range(_MOST_ITERATIONS):
            stress = tangent_action(self._rhs.material, F, self.gradient(direction))
            applied = self.force(stress)
            curvature = float(np.sum(direction * applied))
            if not curvature > 0.0:
                break
            step = rz / curvature
            change += step * direction
            residual -= step * applied
            z = residual / self._V
            fresh = float(np.sum(residual * z))
            if fresh <= stop:
                break
            direction = z + (fresh / rz) * direction
            rz = fresh
        return change
