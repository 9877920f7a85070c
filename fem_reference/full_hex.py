"""The trilinear hexahedron with full integration: what locks where ``kappa >> mu``.

    Pi_e = sum_g w_g W(F_g, cof F_g, det F_g),    f_a = sum_g w_g P(F_g) dN_a/dX(g)

at 2x2x2 Gauss points.  Each of them holds its own volume: eight constraints an element where its
nodes can meet one, so the element is far too stiff near incompressibility ([Hughes1980]).  It is
here to show that, beside ``BBarHex``, and is as good as that one where the body is compressible.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from fem_reference.b_bar_hex import BBarHexElements
from fem_reference.element import CentroidStress, mixed_stress
from sphsolid.continuum import law
from sphsolid.geometry.mesh import HexMesh
from sphsolid.record.turned_cells import gauss_jacobians

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FullHex:
    """Eight nodes, 2x2x2 Gauss points, no cure for locking: Q1."""

    @property
    def name(self) -> str:
        """``full_hex``."""
        return "full_hex"

    def cell_size(self, spacing: float) -> float:
        """``spacing`` [m]."""
        return spacing

    def discretise(self, *, mesh: HexMesh, sk: MeshHex, material: Any) -> FullHexElements:
        """See :class:`FullHexElements`; raises ``InputError`` for a folded element."""
        return FullHexElements(mesh, sk, material)


class FullHexElements(BBarHexElements):
    """All Q1 elements of one mesh and material: those of B-bar without the mean Jacobian."""

    mean_share = 0.0

    def stress(self, x: Array) -> CentroidStress:
        """``F_c``, ``J = det F_c`` and ``P(F_c)`` at the centroids."""
        q = self.quadrature
        gradients = np.broadcast_to(q.centroid_gradients, (q.elements, 8, 3))
        F = np.einsum("eai,eak->eik", x[q.cells], gradients)
        return mixed_stress(self.material, F, np.linalg.det(F))

    def volumetric_energy(self, x: Array) -> float:
        """``sum_g w_g U(J_g)`` [J] at the Gauss points."""
        reference, J = gauss_jacobians(self.mesh, x)
        return float(np.sum(reference * law.volumetric_energy(self.material, J)) / 8.0)

    def description(self) -> str:
        """One line for the plan of a run."""
        shape = "equal bricks" if self.quadrature.congruent else "hexahedra of any shape"
        return f"{self.quadrature.elements} fully integrated Q1 {shape}, 2x2x2 Gauss points"
