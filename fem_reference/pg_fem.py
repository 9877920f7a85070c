"""The stabilised Petrov-Galerkin method {p, F, H, J} of nodes and cells ([Lee2014], [Gil2014]).

All fields live at the nodes, mass is lumped, and with ``L = grad v`` at the points of the cells

    V_a dF_a/dt = sum_q w_q N_a L,                V_a dH_a/dt = sum_q w_q N_a (F x L),
    V_a dJ_a/dt = sum_q w_q N_a (H : L) - (tau_p/rho0) sum_q w_q grad N_a . H^T R_p,
    V_a dp_a/dt = E_a - sum_q w_q P^C(F_st, H_st, J_st) grad N_a.

The stress is that of the stabilised strains of [Lee2017] eq. (28),

    F_st = F + tau_F (L - dF/dt) + xi_F (F_x - F),                      F_x = grad x,
    H_st = H + tau_H (F x L - dH/dt) + xi_H (cof F_x - H),
    J_st = J + tau_J (H : L - dJ/dt) + xi_J (det F_x - J),

and the nodes' forces are those nearest to it that have no moment (least squares, [Lee2016]), which
makes angular momentum exact.  The local projection of [Lee2017] section 6, the nearest ``P^C`` at
every point, does not serve here: nodal ``F`` and ``grad x`` part, and where a body twists it brings
energy in.  ``R_p = DIV P + f0 - dp/dt`` of eq. (29c) has the divergence of
the nodes' own stresses and the rate of this stage.  Fields are interpolated from the nodes.

Integrals of shape functions make force and rate of ``F`` adjoint; what is left of the chain rule
(products and the law at points instead of nodes) is a work of its own in the budget.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_reference import pg_fem_kernels as kernels
from fem_reference.cell_tables import CellKind, CellTables, Tetrahedra
from fem_reference.pg_fem_kernels import STRAINS, Coefficients, Fields
from sphsolid.continuum import law
from sphsolid.continuum.kept_momenta import momentum_correction
from sphsolid.continuum.tensor import cofactor, determinant, join, split
from sphsolid.continuum.wave_speed import moduli_at_rest
from sphsolid.errors import InputError, require
from sphsolid.geometry.mesh import Mesh
from sphsolid.protocols import check_protocol

Array = NDArray[np.float64]
#: Options are immutable objects, so one default serves every method.
TETRAHEDRA = Tetrahedra()


@dataclass(frozen=True)
class PGFEM:
    """Options: the cells, ``tau`` in stable steps, ``xi`` pure numbers, and the projection.

    ``tau_F, tau_H, tau_J, tau_p >= 0`` are multiples of the stable step of a run, whose last step
    before a record may be shorter; ``xi_F, xi_H, xi_J`` lie in [0, 0.5].  The values published are
    ``tau_F = 1``; the others are of this package.  Raises ``InputError`` for any other value.

    At rest a residual ``r I`` of the gradients is answered by the stress ``r [3 (kappa + mu) xi_J -
    mu (xi_F + 2 xi_H)] I``: without ``xi_J`` the wrong way, and likewise with ``tau``.  Where it is
    None, ``xi_J = (xi_F + 2 xi_H) mu / kappa``, which answers it as shear is answered; a larger one
    resists changes of volume of single points, and locks.  ``tau_H = tau_J = 1`` are needed near
    incompressibility: nothing else resists residuals of ``H`` and ``J``, and pressures grow.
    """

    cells: CellKind = TETRAHEDRA
    tau_F: float = 1.0
    xi_F: float = 0.1
    tau_p: float = 0.1
    tau_H: float = 1.0
    xi_H: float = 0.0
    tau_J: float = 1.0
    xi_J: float | None = None
    projects: bool = True

    def __post_init__(self) -> None:
        check_protocol(
            "cells", self.cells, ("name", "tables"), "use Tetrahedra() or Hexahedra()"
        )
        for each in fields(self):
            value = getattr(self, each.name)
            top = {"tau": math.inf, "xi": 0.5}.get(each.name.split("_")[0])
            if top is None or (value is None and each.name == "xi_J"):
                continue
            number = isinstance(value, int | float) and not isinstance(value, bool)
            require(
                number and math.isfinite(value) and 0.0 <= value <= top,
                f"PGFEM: {each.name} = {value!r} must be a number from 0 to {top:g}; tau_F = 1, "
                "xi_F = 0.1, tau_p = 0.1 are usual",
            )
        if not isinstance(self.projects, bool):
            raise InputError(f"PGFEM: projects = {self.projects!r} must be True or False")

    @property
    def name(self) -> str:
        """``pg_fem_tetrahedra`` or ``pg_fem_hexahedra``."""
        return f"pg_fem_{self.cells.name}"

    def discretise(self, *, mesh: Mesh, material: Any) -> PGFEMCells:
        """See :class:`PGFEMCells`; raises ``InputError`` for a folded or flat cell."""
        return PGFEMCells(self.cells.tables(mesh), material, self)


class PGFEMCells:
    """Cells of one body and material, and the rates of the nodes' fields.

    ``strains (N, 19)``: ``F``, ``H``, ``J`` of a node in a row.  After :meth:`evaluate` the rates
    ``v_dot (N, 3)`` [m/s^2] and ``strains_dot (N, 19)`` [1/s] are those of its arguments.
    """

    def __init__(self, cells: CellTables, material: Any, options: PGFEM) -> None:
        self.cells, self.options = cells, options
        self.material = law.in_kernels(material)
        mu, kappa = moduli_at_rest(material)
        self._softness = mu / kappa
        nodes, (count, corners) = len(cells.V), cells.tables.nodes.shape
        self.v_dot = np.zeros((nodes, 3))
        self.strains_dot = np.zeros((nodes, STRAINS))
        self._force, self._correction = np.zeros((nodes, 3)), np.zeros((nodes, 3))
        self._J_dot = np.zeros((nodes, 1))
        self._stress = np.zeros((nodes, 9))
        self._smallest = np.ones(nodes)
        self._given = np.zeros((count, corners, STRAINS))
        self._given_force = np.zeros((count, corners, 3))
        self._given_J = np.zeros((count, corners, 1))
        self._step = 0.0

    @property
    def coefficients(self) -> Coefficients:
        """``tau`` [s] of the step begun last."""
        o, dt = self.options, self._step
        xi_J = (o.xi_F + 2.0 * o.xi_H) * self._softness if o.xi_J is None else o.xi_J
        return Coefficients(
            o.tau_F * dt, o.tau_H * dt, o.tau_J * dt, o.xi_F, o.xi_H, xi_J
        )

    def start(self, x: Array) -> Array:
        """Strains ``(N, 19)`` of positions ``x (N, 3)``: ``F`` the projection of ``grad x``."""
        F = np.zeros((len(x), STRAINS))
        kernels.strain_rates(self.cells.tables, x, F, self._given)
        self._gather(self._given, F)
        entries = split(F[:, :9].reshape(-1, 3, 3))
        F[:, 9:18] = join(cofactor(entries)).reshape(-1, 9)
        F[:, 18] = determinant(entries)
        return F

    def begin_step(self, stable: float) -> None:
        """Intrinsic times follow the stable step ``stable`` [s]."""
        self._step = stable

    def galerkin_rates(self, v: Array, strains: Array) -> None:
        """``strains_dot`` without the term of ``tau_p``."""
        kernels.strain_rates(self.cells.tables, v, strains, self._given)
        self._gather(self._given, self.strains_dot)

    def internal_force(self, x: Array, v: Array, strains: Array) -> Array:
        """``(N, 3)`` [N/m^3]: minus what the stresses push each node with, over its volume.

        Its moment is taken out.
        """
        given = Fields(x, v, strains, self.strains_dot)
        kernels.stress_forces(
            self.cells.tables, self.material, self.coefficients, given, self._given_force
        )
        self._gather(self._given_force, self._force)
        if self.options.projects:
            self._correction[:] = momentum_correction(self.cells.V, x, self._force)
            self._force += self._correction
        return self._force

    def volume_dissipation(self, strains: Array, inertia: Array) -> Array:
        """``D(J) (N, 1)`` [1/s] of ``inertia = dp/dt - f0 (N, 3)`` [N/m^3]; it is added."""
        if self.options.tau_p == 0.0:
            self._J_dot[:] = 0.0
            return self._J_dot
        self.look(strains)
        factor = self.options.tau_p * self._step / self.material.density
        kernels.volume_residuals(
            self.cells.tables, factor, strains, self._stress, inertia, self._given_J
        )
        self._gather(self._given_J, self._J_dot)
        self.strains_dot[:, 18:] += self._J_dot
        return self._J_dot

    def look(self, strains: Array) -> Array:
        """Smallest stretch of each node ``(N,)``; -1 where ``J`` or ``det F`` is not positive."""
        kernels.nodal_stress(self.material, strains, self._stress, self._smallest)
        return self._smallest

    def stress(self, strains: Array) -> Array:
        """``P (N, 3, 3)`` [Pa] of the nodes' own strains."""
        self.look(strains)
        return self._stress.reshape(-1, 3, 3).copy()

    def energy(self, strains: Array) -> float:
        """``sum_a V_a W(F_a, H_a, J_a)`` [J], zero in the undeformed body."""
        F, H = (split(strains[:, k : k + 9].reshape(-1, 3, 3)) for k in (0, 9))
        W = law.stored_energy(self.material, F, H, strains[:, 18])
        return float(np.sum(self.cells.V * W))

    def stress_powers(self, x: Array, v: Array, strains: Array) -> dict[str, float]:
        """Powers [W] of what is no load: they add up to the change of energy by the chain rule.

        ``adjoint_defect``: the law and products at points of cells, where the energy has nodes.
        """
        taken = np.empty((self.cells.count, 2))
        # The rates that the stabilised strains saw had no term of tau_p yet.
        rates = self.strains_dot.copy()
        rates[:, 18:] -= self._J_dot
        given = Fields(x, v, strains, rates)
        kernels.powers(self.cells.tables, self.material, self.coefficients, given, taken)
        coarse, fine = taken.sum(axis=0)
        projected = self.cells.V @ np.sum(self._correction * v, axis=1)
        F, H = (split(strains[:, k : k + 9].reshape(-1, 3, 3)) for k in (0, 9))
        Sigma = law.conjugate_stresses(self.material, F, H, strains[:, 18])
        return {
            "projection": -float(projected),
            "adjoint_defect": self._nodal_power(Sigma, rates) - float(coarse),
            "dissipation_p": -float(fine),
            "dissipation_J": float(np.sum(self.cells.V * Sigma[2] * self._J_dot[:, 0])),
        }

    def _nodal_power(self, Sigma: Any, rates: Array) -> float:
        """``sum V (Sigma_F : dF + Sigma_H : dH + Sigma_J dJ)`` [W]."""
        total = Sigma[2] * rates[:, 18]
        for k in range(9):
            total = total + Sigma[0][k] * rates[:, k] + Sigma[1][k] * rates[:, 9 + k]
        return float(np.sum(self.cells.V * total))

    def _gather(self, given: Array, rate: Array) -> None:
        cells = self.cells
        flat = given.reshape(-1, given.shape[2])
        kernels.gather(cells.start, cells.entries, cells.V, flat, rate)

    def description(self) -> str:
        """One line for the plan of a run."""
        o, points = self.options, self.cells.tables.N.shape[0]
        return (
            f"{self.cells.count} {o.cells.name}, {points} points each, nodal {{p,F,H,J}}; "
            f"tau_F {o.tau_F:g} dt, xi_F {o.xi_F:g}, tau_p {o.tau_p:g} dt"
            + ("" if o.projects else ", no projection")
        )
