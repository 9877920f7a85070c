"""The linear tetrahedron with average nodal pressure at finite strain ([Bonet1998]).

A linear tetrahedron has one volume constraint of its own, five to six for every node, and locks
when ``kappa >> mu``.  Here the volumetric energy ``U(J)`` of the law sees the Jacobians of the
nodes, each the mean over the cells around it:

    J_a = sum_e (V_e / 4) det F_e / V_a,    V_a = sum_e V_e / 4,
    Pi  = sum_e V_e [W(F_e, cof F_e, det F_e) - U(det F_e)] + sum_a V_a U(J_a).

The internal force is the exact gradient, with the mean of the four nodal pressures ``U'(J_a)``:

    f_a = sum_e V_e { P(F_e) + (pbar_e - U'(det F_e)) cof F_e } grad N_a.

A pressure that alternates from node to node costs nothing (no stabilisation is added), and shows
as noise near incompressibility.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import ElementTetP1, MeshTet

from fem_reference.assembly import NodeIncidence
from fem_reference.cell_tables import CellKind, Tetrahedra
from fem_reference.element import CentroidStress, first_invalid, mixed_stress
from fem_reference.lanes import LANES, blocks, one_by_one, side_by_side
from fem_reference.load_shapes import LoadShapes
from fem_reference.nodal_pressure_kernels import (
    deformed_volumes,
    element_forces,
    isochoric_energies,
)
from sphsolid.continuum import law
from sphsolid.geometry.mesh import TetMesh

Array = NDArray[np.float64]
#: Options are immutable objects, so one default serves every element.
TETRAHEDRA = Tetrahedra()


@dataclass(frozen=True)
class NodalPressureTet:
    """Four nodes, one point, pressures averaged at the nodes; hexahedra are split into six."""

    cells: CellKind = TETRAHEDRA

    @property
    def name(self) -> str:
        """``nodal_pressure_tet``."""
        return "nodal_pressure_tet"

    def cell_size(self, spacing: float) -> float:
        """``spacing`` [m]."""
        return spacing

    def discretise(self, *, mesh: TetMesh, sk: MeshTet, material: Any) -> NodalPressureElements:
        """See :class:`NodalPressureElements`."""
        return NodalPressureElements(mesh, material)


class NodalPressureElements:
    """All tetrahedra of one mesh and material; positions and forces are ``(N, 3)``."""

    def __init__(self, mesh: TetMesh, material: Any) -> None:
        self.mesh = mesh
        self.material = law.in_kernels(material)
        X = mesh.vertices
        self.load_shapes = LoadShapes(ElementTetP1(), 2, np.arange(len(X)))
        cells = mesh.cells.astype(np.uint32)
        corners = X[mesh.cells]
        inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
        volumes = np.abs(1.0 / np.linalg.det(inverse)) / 6.0
        slopes = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
        self._length = 1.0 / np.linalg.norm(slopes, axis=2).max(axis=1)
        self._volumes = volumes
        self._V = np.bincount(
            mesh.cells.ravel(), weights=np.repeat(0.25 * volumes, 4), minlength=len(X)
        ).astype(np.float64)
        self._nodes = side_by_side(cells)
        self._inverse = side_by_side(inverse.reshape(-1, 9))
        self._lane_volumes = side_by_side(volumes)
        self._at_nodes = NodeIncidence.of(cells, len(X))
        self._scalars_at_nodes = NodeIncidence.of(cells, len(X), components=1)
        count = blocks(len(cells))
        self._given_volume = np.empty((count, 4, LANES))
        self._given_force = np.empty((count, 12, LANES))
        self._J = np.ones(len(X))
        self._smallest_jacobian = np.ones((count, LANES))
        self._shrinkage = np.ones((count, LANES))

    @property
    def count(self) -> int:
        """Number of tetrahedra."""
        return len(self._volumes)

    @property
    def volumes(self) -> Array:
        """Reference volumes ``V_e (E,)`` [m^3]."""
        return self._volumes

    @property
    def nodal_volumes(self) -> Array:
        """A quarter of the volumes around each node ``(N,)`` [m^3]."""
        return self._V

    def nodal_jacobians(self, x: Array) -> Array:
        """``J_a (N,)`` of positions ``x (N, 3)`` [m]."""
        deformed_volumes(x, self._nodes, self._inverse, self._lane_volumes, self._given_volume)
        self._scalars_at_nodes.gather_scalars(self._given_volume, self._J)
        self._J /= self._V
        return self._J

    def internal_force(self, x: Array, force: Array) -> None:
        """``force (N, 3)`` [N] ``= dPi/dx`` at positions ``x (N, 3)`` [m]."""
        pressure = law.volumetric_pressure(self.material, self.nodal_jacobians(x))
        element_forces(
            self.material, (x, np.asarray(pressure)), self._nodes, self._inverse,
            self._lane_volumes, self._smallest_jacobian, self._shrinkage, self._given_force,
        )  # fmt: skip
        self._at_nodes.gather(self._given_force, force)

    def smallest_length(self) -> float:
        """``min_e length_e lambda_e / max(1, s_e J_e)`` [m] at the last force.

        ``length_e`` is the smallest altitude of the undeformed tetrahedron.
        """
        return float(np.min(self._length * one_by_one(self._shrinkage, self.count)))

    def invalid_element(self) -> int:
        """First element with ``J <= 0``, ``nan`` or a stretch below ``THINNEST``, or -1."""
        return first_invalid(self._smallest_jacobian, self._shrinkage)

    def centre(self, element: int) -> Array:
        """Undeformed centre ``(3,)`` [m] of an element."""
        return np.asarray(self.mesh.vertices[self.mesh.cells[element]].mean(axis=0))

    def strain_energy(self, x: Array) -> float:
        """``Pi`` [J]."""
        energies = np.empty_like(self._shrinkage)
        isochoric_energies(
            self.material, x, self._nodes, self._inverse, self._lane_volumes, energies
        )
        return float(np.sum(one_by_one(energies, self.count))) + self.volumetric_energy(x)

    def volumetric_energy(self, x: Array) -> float:
        """``sum_a V_a U(J_a)`` [J]."""
        U = law.volumetric_energy(self.material, self.nodal_jacobians(x))
        return float(np.sum(self._V * U))

    def stress(self, x: Array) -> CentroidStress:
        """``F_e``, ``J`` the mean of the four nodal ones, and the stress with that ``J``."""
        inverse = one_by_one(self._inverse, self.count).reshape(-1, 3, 3)
        corners = x[self.mesh.cells]
        F = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2) @ inverse
        J = self.nodal_jacobians(x)[self.mesh.cells].mean(axis=1)
        return mixed_stress(self.material, F, J)

    def description(self) -> str:
        """One line for the plan of a run."""
        return f"{self.count} linear tetrahedra, pressures averaged at the nodes"
