"""Constrained TOUCH: cell-centred upwind finite volumes {p, F} on hexahedra ([Haider2017]).

Velocities ``v_e`` live in the cells, positions at the nodes.  With the outward area vector ``A N``
of a face and the flux of the acoustic Riemann problem ([Lee2013]),

    rho0 V_e dv_e/dt = sum_f t^C A + V_e f0,      t^C = mean t + S/2 (v+ - v-),
                                                  v^C = mean v + S^-1/2 (t+ - t-),
    S = rho0 [U_p n (x) n + U_s (I - n (x) n)],   n = H N / |H N|,   U = c |H N| / J,

where ``v`` and ``t = P N`` are reconstructed at both sides of the face with least-squares slopes of
``v`` and of the rows of ``P``.  ``F`` is constrained: the ``v^C``, carried to the nodes along the
slopes, move the nodes, and ``F_e = 1/V_e integral grad x`` follows from their positions.  So
``CURL F = 0`` stays, and ``J_e = det F_e``.  There is one volume a cell, and nothing locks.

Cells have positions ``x_e`` of their own, moved by ``v_e``.  Of all changes of the forces that keep
their sum, the least one makes the moment about ``x_e`` that of the boundary, at the positions that
the integrator asks for; so angular momentum is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference.cell_tables import CellTables, Hexahedra
from fem_reference.touch_boundary import TouchBoundary
from fem_reference.touch_mesh import touch_mesh
from sphsolid.continuum import law, reference_p_wave_speed
from sphsolid.continuum.kept_momenta import moment_correction
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.continuum.wave_speed import moduli_at_rest
from sphsolid.errors import InputError, require
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConstrainedTOUCH:
    """Options: linear or constant reconstruction, the share of upwinding, and the projection.

    ``upwind`` in (0, 1] is the share of the jumps in the fluxes; 1 is the Riemann solution.  With
    ``linear = False`` the method is of first order.  Raises ``InputError`` for any other value.
    """

    linear: bool = True
    upwind: float = 1.0
    projects: bool = True

    def __post_init__(self) -> None:
        for name in ("linear", "projects"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(
                    f"ConstrainedTOUCH: {name} = {getattr(self, name)!r} must be True or False"
                )
        known = isinstance(self.upwind, int | float) and not isinstance(self.upwind, bool)
        require(
            known and math.isfinite(self.upwind) and 0.0 < self.upwind <= 1.0,
            f"ConstrainedTOUCH: upwind = {self.upwind!r} is outside (0, 1]; 1 is usual",
        )

    @property
    def name(self) -> str:
        """``constrained_touch``."""
        return "constrained_touch"

    def discretise(self, *, scene: Scene, mesh: Mesh, material: Any) -> TouchCells:
        """See :class:`TouchCells`; raises ``InputError`` for cells that are no hexahedra."""
        return TouchCells(Hexahedra().tables(mesh), scene, material, self)


@dataclass(frozen=True)
class TouchRates:
    """Of one evaluation: ``v (E, 3)`` [m/s^2] of cells, ``x (N, 3)`` [m/s] of nodes, boundary.

    ``force (n, 3)`` [N] and ``velocity (n, 3)`` of the boundary faces, ``arms (n, 3)`` [m] their
    positions; ``change (E, 3)`` [m/s^2] is the part of ``v`` that the projection made.
    """

    v: Array
    x: Array
    force: Array
    velocity: Array
    arms: Array
    change: Array
    body: Array


class TouchCells:
    """Cells of one scene and material, and their rates."""

    def __init__(
        self, cells: CellTables, scene: Scene, material: Any, options: ConstrainedTOUCH
    ) -> None:
        self.cells, self.options, self.scene = cells, options, scene
        self.material = material
        self.maps = touch_mesh(cells, linear=options.linear)
        self.boundary = TouchBoundary(scene, cells.mesh, self.maps.faces)
        self.c_p = reference_p_wave_speed(material)
        self.c_s = math.sqrt(moduli_at_rest(material)[0] / material.density)
        self._nodes = cells.mesh.cells
        self._has_body = not isinstance(scene.body_force, NoBodyForce)

    def deformation(self, x: Array) -> Array:
        """``F (E, 3, 3)`` of nodal positions ``x (N, 3)``."""
        return np.einsum("eni,enk->eik", x[self._nodes], self.maps.gradients)

    def strains(self, x: Array) -> tuple[Array, Array, Array]:
        """``F, H (E, 3, 3)`` and ``J (E,)``."""
        F = self.deformation(x)
        entries = split(F)
        return F, join(cofactor(entries)), np.asarray(determinant(entries))

    def stress(self, F: Array, H: Array, J: Array) -> Array:
        """``P (E, 3, 3)`` [Pa]."""
        return np.asarray(join(law.first_piola(self.material, split(F), split(H), J)))

    def energy(self, x: Array) -> float:
        """``sum_e V_e W(F_e)`` [J]."""
        F, H, J = self.strains(x)
        W = law.stored_energy(self.material, split(F), split(H), J)
        return float(np.sum(self.maps.V * W))

    def evaluate(self, v: Array, x: Array, arms: Array, t: float) -> TouchRates:
        """Rates of cells with velocities ``v (E, 3)`` and nodes at ``x (N, 3)``.

        ``arms (E, 3)`` [m] are the positions of the cells about which the moment is made right.
        """
        maps, faces, rho = self.maps, self.maps.faces, self.material.density
        F, H, J = self.strains(x)
        P = self.stress(F, H, J).reshape(-1, 9)
        inner, N = faces.inner, faces.area / faces.size[:, None]
        v_left, t_left = maps.to_left @ v, _traction(maps.to_left @ P, N)
        v_right, t_right = maps.to_right @ v, _traction(maps.to_right @ P, N)
        mean_H = 0.5 * (H[faces.left] + H[faces.right])
        HN = np.einsum("fij,fj->fi", mean_H, N)
        size = np.linalg.norm(HN, axis=1)
        stretch = rho * size / (0.5 * (J[faces.left] + J[faces.right]))
        n = HN / size[:, None]
        z_p, z_s = self.c_p * stretch, self.c_s * stretch
        v_C, t_C = 0.5 * (v_left + v_right), 0.5 * (t_left + t_right)
        share = 0.5 * self.options.upwind
        seen = slice(0, inner)
        jump_v, jump_t = (v_right - v_left)[seen], (t_right - t_left)[seen]
        t_C[seen] += share * _split(z_p[seen], z_s[seen], n[seen], jump_v)
        v_C[seen] += share * _split(1.0 / z_p[seen], 1.0 / z_s[seen], n[seen], jump_t)
        edge = slice(inner, None)
        nn = n[edge, :, None] * n[edge, None, :]
        S = z_s[edge, None, None] * np.eye(3) + (z_p - z_s)[edge, None, None] * nn
        v_C[edge], t_C[edge] = self.boundary.states(
            v_left[edge], t_left[edge], S, self.boundary.velocity(t), self.boundary.traction(t)
        )
        pushed = maps.balance @ (t_C * faces.size[:, None])
        outside = t_C[edge] * self.boundary.size[:, None]
        at = faces.centroids(x)[edge]
        change = self._change(arms, pushed, np.cross(at, outside).sum(axis=0))
        body = self.scene.body_force_at(maps.X, t) if self._has_body else np.zeros_like(v)
        rate = (pushed / maps.V[:, None] + body) / rho + change
        x_rate = maps.from_faces @ v_C + maps.from_cells @ v
        return TouchRates(rate, x_rate, outside, v_C[edge], at, change, body)

    def _change(self, arms: Array, pushed: Array, moment: Array) -> Array:
        """``(E, 3)`` [m/s^2] that gives ``pushed`` the ``moment`` [N m] of the boundary."""
        if not self.options.projects:
            return np.zeros_like(pushed)
        lacking = moment - np.cross(arms, pushed).sum(axis=0)
        return moment_correction(self.maps.V, arms, lacking) / self.material.density

    def smallest_stretch(self, x: Array) -> Array:
        """Of each cell ``(E,)``; -1 where ``J <= 0``."""
        F, _, J = self.strains(x)
        with np.errstate(invalid="ignore"):
            C = np.where(np.isfinite(F), F, 0.0)
            least = np.sqrt(np.linalg.eigvalsh(np.swapaxes(C, 1, 2) @ C)[:, 0].clip(0.0))
        return np.where(np.isfinite(J), np.where(J > 0.0, least, -1.0), -2.0)

    def description(self) -> str:
        """One line for the plan of a run."""
        kind = "linear" if self.options.linear else "constant"
        return (
            f"{self.cells.count} hexahedra, {len(self.maps.faces.left)} faces, {kind} "
            f"reconstruction, acoustic Riemann fluxes, upwind {self.options.upwind:g}"
            + ("" if self.options.projects else ", no projection")
        )


def _traction(P: Array, N: Array) -> Array:
    return np.asarray(np.einsum("fij,fj->fi", P.reshape(-1, 3, 3), N))


def _split(along: Array, across: Array, n: Array, f: Array) -> Array:
    """``[along n (x) n + across (I - n (x) n)] f``."""
    normal = np.sum(n * f, axis=1, keepdims=True) * n
    return np.asarray(along[:, None] * normal + across[:, None] * (f - normal))
