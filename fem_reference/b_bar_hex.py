"""The Q1-P0 mean-dilatation (B-bar) hexahedron at finite strain ([Hughes1980], [Simo1985]).

A displacement-only trilinear hexahedron locks when ``kappa >> mu``: its eight Gauss points ask
for eight volume constraints, more than its nodes can give.  Here the volumetric energy
``U(J) = kappa/2 (J - 1)^2`` sees only the element mean of the Jacobian,

    Jbar = (1/V_e) sum_g w_g J_g = v_e / V_e,
    Pi_e = sum_g w_g [W(F_g, cof F_g, J_g) - U(J_g)] + V_e U(Jbar),

and the isochoric rest of ``W`` is integrated at 2x2x2 points.  The internal force is the exact
gradient, because ``d(V_e Jbar)/dx_a = sum_g w_g cof F_g dN_a/dX``:

    f_a = sum_g w_g { P(F_g) + kappa (Jbar - J_g) cof F_g } dN_a/dX(g).

Every law of ``sphsolid.continuum`` has this ``U``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from fem_reference.assembly import NodeIncidence
from fem_reference.b_bar_kernels import centroid_stresses, element_energies, element_forces
from fem_reference.element import CentroidStress
from fem_reference.hex_quadrature import HexQuadrature, hex_quadrature
from sphsolid.continuum.wave_speed import THINNEST
from sphsolid.scenes.hex_mesh import HexMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BBarHex:
    """Eight nodes, 2x2x2 Gauss points, one pressure per element: Q1-P0."""

    @property
    def name(self) -> str:
        """``b_bar_hex``."""
        return "b_bar_hex"

    def discretise(self, *, mesh: HexMesh, sk: MeshHex, material: Any) -> BBarHexElements:
        """See :class:`BBarHexElements`; raises ``InputError`` for a folded element."""
        return BBarHexElements(hex_quadrature(mesh, sk), len(mesh.vertices), material)


class BBarHexElements:
    """All Q1-P0 elements of one mesh and material.

    ``quadrature`` is :class:`HexQuadrature`; positions and forces are ``(N, 3)`` arrays.
    """

    def __init__(self, quadrature: HexQuadrature, nodes: int, material: Any) -> None:
        self.quadrature = quadrature
        self.material = material
        self.incidence = NodeIncidence.of(quadrature.cells, nodes)
        self._nodes = nodes
        self._element_force = np.zeros((quadrature.elements, 8, 3))
        self._smallest_jacobian = np.ones(quadrature.elements)
        self._shrinkage = np.ones(quadrature.elements)

    @property
    def volumes(self) -> Array:
        """Reference volumes ``V_e (E,)`` [m^3]."""
        return self.quadrature.volumes

    @property
    def nodal_volumes(self) -> Array:
        """Row-sum lumped volumes ``(N,)`` [m^3]."""
        return self.quadrature.nodal_volumes(self._nodes)

    @property
    def nbytes(self) -> int:
        """Memory of all arrays held."""
        q, incidence = self.quadrature, self.incidence
        held = (
            *(q.cells, q.gradients, q.weights, q.centroid_gradients, q.corner_volumes, q.length),
            *(incidence.start, incidence.entries),
            *(self._element_force, self._smallest_jacobian, self._shrinkage),
        )
        return sum(array.nbytes for array in held)

    def internal_force(self, x: Array, force: Array) -> None:
        """``force (N, 3)`` [N] ``= dPi/dx`` at positions ``x (N, 3)`` [m]."""
        element_forces(
            self.material,
            x,
            self.quadrature.cells,
            self.quadrature.gradients,
            self.quadrature.weights,
            self._smallest_jacobian,
            self._shrinkage,
            self._element_force,
        )
        self.incidence.gather(self._element_force, force)

    def smallest_length(self) -> float:
        """``min_e length_e lambda_e / max(1, Jbar_e)`` [m] at the last force.

        ``lambda_e`` is the smallest principal stretch at the Gauss points of element ``e``.
        """
        return float(np.min(self.quadrature.length * self._shrinkage))

    def invalid_element(self) -> int:
        """First element that is lost at the last force, or -1.

        Lost: ``J <= 0`` or ``nan`` at a Gauss point, or a stretch below ``THINNEST``.
        """
        # argmin stops at the first nan, and a comparison with nan is False.
        worst = int(np.argmin(self._smallest_jacobian))
        if not self._smallest_jacobian[worst] > 0.0:
            return worst
        thin = int(np.argmin(self._shrinkage))
        return -1 if self._shrinkage[thin] > THINNEST else thin

    def strain_energy(self, x: Array) -> float:
        """``Pi = sum_e Pi_e`` [J]."""
        energies = np.empty(self.quadrature.elements)
        q = self.quadrature
        element_energies(self.material, x, q.cells, q.gradients, q.weights, energies)
        return float(np.sum(energies))

    def stress(self, x: Array) -> CentroidStress:
        """``F_c``, ``J = Jbar`` and ``P = P(F_c) + kappa (Jbar - J_c) cof F_c``.

        The centroid is the point where the gradient of a trilinear field converges with second
        order (superconvergence); the pressure is the element's own.
        """
        q = self.quadrature
        F = np.empty((q.elements, 3, 3))
        J = np.empty(q.elements)
        P = np.empty((q.elements, 3, 3))
        centroid_stresses(
            self.material, x, q.cells, q.gradients, q.weights, q.centroid_gradients, F, J, P
        )
        return CentroidStress(F, J, P)

    def description(self) -> str:
        """One line for the plan of a run."""
        stored = "one set for all" if self.quadrature.congruent else "one set per element"
        return (
            f"{self.quadrature.elements} Q1-P0 (B-bar) hexahedra, 2x2x2 Gauss points, "
            f"gradients: {stored}"
        )
