"""The Q1-P0 mean-dilatation (B-bar) hexahedron at finite strain ([Hughes1980], [Simo1985]).

A displacement-only trilinear hexahedron locks when ``kappa >> mu``: its eight Gauss points ask
for eight volume constraints, more than its nodes can give.  Here the volumetric energy ``U(J)`` of
the law (``sphsolid.continuum.volumetric``) sees only the element mean of the Jacobian,

    Jbar = (1/V_e) sum_g w_g J_g = v_e / V_e,
    Pi_e = sum_g w_g [W(F_g, cof F_g, J_g) - U(J_g)] + V_e U(Jbar),

and the isochoric rest of ``W`` is integrated at 2x2x2 points.  The internal force is the exact
gradient, because ``d(V_e Jbar)/dx_a = sum_g w_g cof F_g dN_a/dX``:

    f_a = sum_g w_g { P(F_g) + (U'(Jbar) - U'(J_g)) cof F_g } dN_a/dX(g).

Of ``U(J) = kappa/2 (J - 1)^2`` the bracket holds ``kappa (Jbar - J_g)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from fem_reference.assembly import NodeIncidence
from fem_reference.b_bar_kernels import element_energies, element_forces, mean_jacobians
from fem_reference.element import CentroidStress, first_invalid, mixed_stress
from fem_reference.hex_maps import hex_maps
from fem_reference.hex_quadrature import hex_quadrature
from fem_reference.lanes import LANES, blocks, one_by_one, side_by_side
from fem_reference.load_shapes import trilinear_shapes
from sphsolid.continuum import law
from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BBarHex:
    """Eight nodes, 2x2x2 Gauss points, one pressure per element: Q1-P0."""

    @property
    def name(self) -> str:
        """``b_bar_hex``."""
        return "b_bar_hex"

    def cell_size(self, spacing: float) -> float:
        """``spacing`` [m]."""
        return spacing

    def discretise(self, *, mesh: HexMesh, sk: MeshHex, material: Any) -> BBarHexElements:
        """See :class:`BBarHexElements`; raises ``InputError`` for a folded element."""
        return BBarHexElements(mesh, sk, material)


class BBarHexElements:
    """All Q1-P0 elements of one mesh and material.

    Positions and forces are ``(N, 3)`` arrays.
    """

    #: Share of the element mean in the Jacobian that ``U`` sees.
    mean_share = 1.0

    def __init__(self, mesh: HexMesh, sk: MeshHex, material: Any) -> None:
        self.mesh = mesh
        self.load_shapes = trilinear_shapes(sk)
        self.quadrature = quadrature = hex_quadrature(mesh, sk)
        X = mesh.vertices
        self.material = law.in_kernels(material)
        self._maps = hex_maps(quadrature.edges, np.full(8, 0.125), X)
        self._corners = side_by_side(quadrature.cells)
        self._incidence = NodeIncidence.of(quadrature.cells, len(X))
        self._nodes = len(X)
        lanes = (blocks(quadrature.elements), LANES)
        self._element_force = np.zeros((lanes[0], 24, LANES))
        self._smallest_jacobian = np.ones(lanes)
        self._shrinkage = np.ones(lanes)

    @property
    def count(self) -> int:
        """Number of elements."""
        return self.quadrature.elements

    @property
    def volumes(self) -> Array:
        """Reference volumes ``V_e (E,)`` [m^3]."""
        return self.quadrature.volumes

    @property
    def nodal_volumes(self) -> Array:
        """Row-sum lumped volumes ``(N,)`` [m^3]."""
        return self.quadrature.nodal_volumes(self._nodes)

    def internal_force(self, x: Array, force: Array) -> None:
        """``force (N, 3)`` [N] ``= dPi/dx`` at positions ``x (N, 3)`` [m]."""
        element_forces(
            self.material,
            self.mean_share,
            x,
            self._corners,
            self._maps,
            self._smallest_jacobian,
            self._shrinkage,
            self._element_force,
        )
        self._incidence.gather(self._element_force, force)

    def smallest_length(self) -> float:
        """``min_e length_e lambda_e / max(1, s_e Jbar_e)`` [m] at the last force.

        ``lambda_e`` is the smallest principal stretch at the Gauss points of element ``e``,
        ``s_e`` how much stiffer its volume is than at rest (``law.stiffening``).
        """
        shrinkage = one_by_one(self._shrinkage, self.quadrature.elements)
        return float(np.min(self.quadrature.length * shrinkage))

    def invalid_element(self) -> int:
        """First element that is invalid at the last force, or -1.

        Invalid: ``J <= 0`` or ``nan`` at a Gauss point, or a stretch below ``THINNEST``.
        """
        return first_invalid(self._smallest_jacobian, self._shrinkage)

    def centre(self, element: int) -> Array:
        """Undeformed centre ``(3,)`` [m] of an element."""
        return np.asarray(self.mesh.vertices[self.mesh.cells[element]].mean(axis=0))

    def strain_energy(self, x: Array) -> float:
        """``Pi = sum_e Pi_e`` [J]."""
        energies = np.empty_like(self._shrinkage)
        element_energies(
            self.material, self.mean_share, x, self._corners, self._maps, energies
        )
        return float(np.sum(one_by_one(energies, self.quadrature.elements)))

    def stress(self, x: Array) -> CentroidStress:
        """``F_c``, ``J = Jbar`` and ``P = P(F_c) + (U'(Jbar) - U'(J_c)) cof F_c``.

        The centroid is the point where the gradient of a trilinear field converges with second
        order (superconvergence); the pressure is the element's own.
        """
        q = self.quadrature
        jacobians = np.empty_like(self._shrinkage)
        mean_jacobians(x, self._corners, self._maps, jacobians)
        Jbar = one_by_one(jacobians, q.elements)
        gradients = np.broadcast_to(q.centroid_gradients, (q.elements, 8, 3))
        F = np.einsum("eai,eak->eik", x[q.cells], gradients)
        return mixed_stress(self.material, F, Jbar)

    def description(self) -> str:
        """One line for the plan of a run."""
        shape = "equal bricks" if self.quadrature.congruent else "hexahedra of any shape"
        return (
            f"{self.quadrature.elements} Q1-P0 (B-bar) {shape}, 2x2x2 Gauss points"
        )
