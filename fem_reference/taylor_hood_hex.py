"""The Taylor-Hood (Q2-Q1) hexahedron at finite strain, explicit, with lumped mass ([Hood1973]).

Twenty-seven nodes, 3x3x3 Gauss points, and a pressure that is continuous and trilinear.  The
volumetric energy ``U(J)`` of the law sees the continuous dilatation ``theta`` of
:mod:`fem_reference.dilatation` in place of the Jacobian.  With ``kappa = U''(1)`` and the rest
``R(theta) = U(theta) - kappa/2 (theta - 1)^2``,

    r_a = sum_g w_g N_a (J_g - 1),     theta - 1 = A r,
    Pi  = sum_g w_g [W(F_g, cof F_g, J_g) - U(J_g) + R(theta_g)] + kappa/2 r . A r,

and the internal force is the exact gradient: with the pressure ``p`` interpolated to the points,

    q_a = sum_g w_g N_a R'(theta_g),     p = kappa (theta - 1) + A q,
    f_n = sum_g w_g { P(F_g) + (p_g - U'(J_g)) cof F_g } dN_n/dX(g).

With the consistent ``A = M^-1`` that is ``Pi = integral W_iso + U(theta)`` and ``p`` the L2
projection of ``U'(theta)``.  Of ``U = kappa/2 (J - 1)^2`` there is no rest and no second solve.

The mass of a node is its Simpson weight times ``rho0 det dX/dxi`` there: positive, and exact for
cubic fields on bricks, so that lumping does not cost the order.

With the space so accurate it is central differences that limit the order: errors fall with the
third power of the spacing at a short step, with the second at the usual one.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import ElementHex2, MeshHex

from fem_reference.assembly import NodeIncidence
from fem_reference.dilatation import ConsistentMass, Dilatation
from fem_reference.element import CentroidStress, first_invalid, mixed_stress
from fem_reference.grid_mass import grid_of
from fem_reference.hex_maps import hex_maps
from fem_reference.hex_quadrature import brick_edges, hex_quadrature
from fem_reference.lanes import LANES, blocks, one_by_one, side_by_side
from fem_reference.load_shapes import LoadShapes
from fem_reference.mesh import scikit_fem_mesh
from fem_reference.quadratic_mesh import quadratic_mesh, trilinear
from fem_reference.quadratic_tables import (
    PART_CENTRES,
    corner_mass,
    quadratic_gradients,
    simpson_volumes,
    step_share,
)
from fem_reference.taylor_hood_kernels import (
    Fields,
    Forces,
    dilatation_moments,
    element_forces,
    isochoric_energies,
    remainder_energies,
    remainder_moments,
)
from fem_reference.triquadratic import WEIGHTS
from sphsolid.continuum import law
from sphsolid.geometry.mesh import HexMesh

Array = NDArray[np.float64]
#: Options are immutable objects, so one default serves every element.
DEFAULT_DILATATION = ConsistentMass()
#: Polynomial degree that makes scikit-fem use 3x3x3 (3x3 on facets) Gauss points.
GAUSS_3 = 5
#: Corners ``i + 2 j + 4 k`` in the corner order of ``HexMesh``.
LEXICOGRAPHIC = np.array([0, 1, 3, 2, 4, 5, 7, 6])


@dataclass(frozen=True)
class TaylorHoodHex:
    """Q2-Q1: 27 nodes, 3x3x3 Gauss points, continuous trilinear pressure.

    ``dilatation`` says how the pressure's field is found.  The ``spacing`` of a simulation is the
    distance between neighbouring *nodes*, as everywhere: hexahedra are two spacings wide, and on a
    lattice with an even number of cells the nodes are those of ``BBarHex`` at the same spacing.
    """

    dilatation: Dilatation = DEFAULT_DILATATION

    @property
    def name(self) -> str:
        """``taylor_hood_hex``."""
        return "taylor_hood_hex"

    def cell_size(self, spacing: float) -> float:
        """``2 spacing`` [m]."""
        return 2.0 * spacing

    def discretise(self, *, mesh: HexMesh, sk: MeshHex, material: Any) -> TaylorHoodElements:
        """See :class:`TaylorHoodElements`; raises ``InputError`` for a folded element."""
        return TaylorHoodElements(mesh, sk, material, self.dilatation)


class TaylorHoodElements:
    """All Q2-Q1 elements of one mesh and material; positions and forces are ``(N, 3)``."""

    def __init__(self, mesh: HexMesh, sk: MeshHex, material: Any, dilatation: Dilatation) -> None:
        quadratic = quadratic_mesh(mesh, sk)
        self.mesh = quadratic.parts
        self.material = material = law.in_kernels(material)
        self._kappa = float(law.volumetric_stiffness(material, 1.0))
        self.load_shapes = LoadShapes(ElementHex2(), GAUSS_3, quadratic.node_of_dof)
        X, self._cells = self.mesh.vertices, quadratic.cells
        self._nodal_volumes = simpson_volumes(mesh, self._cells, len(X))
        untagged = dataclasses.replace(self.mesh, faces={})
        parts = hex_quadrature(untagged, scikit_fem_mesh(untagged))
        self._part_volumes = parts.volumes
        length = np.broadcast_to(parts.length, len(self.mesh.cells)).reshape(-1, 8).min(axis=1)
        self._length = step_share(material, dilatation) * length
        edges = brick_edges(mesh)
        self._maps = hex_maps(edges, WEIGHTS, X)
        self._corners = mesh.cells
        corners = mesh.cells[:, LEXICOGRAPHIC].astype(np.uint32)
        self._node_lanes, self._corner_lanes = side_by_side(self._cells), side_by_side(corners)
        self._at_nodes = NodeIncidence.of(self._cells, len(X))
        self._at_corners = NodeIncidence.of(corners, len(mesh.vertices), components=1)
        self._mass = corner_mass(mesh)
        self._solve = dilatation.solver(self._mass, grid_of(mesh))
        self._dilatation = dilatation
        count = blocks(len(self._cells))
        self._excess = np.empty((count, 8, LANES))
        self._moments = np.empty(len(mesh.vertices))
        self._rest = np.empty(0 if law.is_quadratic(material) else len(mesh.vertices))
        self._element_force = np.empty((count, 81, LANES))
        self._smallest_jacobian = np.ones((count, LANES))
        self._shrinkage = np.ones((count, LANES))

    @property
    def count(self) -> int:
        """Number of hexahedra."""
        return len(self._cells)

    @property
    def volumes(self) -> Array:
        """Reference volumes [m^3] of the eight parts of every element, ``(8 E,)``."""
        return self._part_volumes

    @property
    def nodal_volumes(self) -> Array:
        """Lumped volumes ``(N,)`` [m^3]: Simpson weights times ``det dX/dxi``."""
        return self._nodal_volumes

    def dilatation(self, x: Array) -> Array:
        """``theta - 1 (Nc,)`` at the vertices of the hexahedra, of positions ``x (N, 3)`` [m]."""
        dilatation_moments(x, self._node_lanes, self._maps, self._excess)
        self._at_corners.gather_scalars(self._excess, self._moments)
        return self._solve(self._moments)

    def _pressure(self, theta: Array) -> Array:
        """``p (Nc,)`` [Pa] of ``theta - 1 (Nc,)``, positive in tension."""
        linear = self._kappa * theta
        if law.is_quadratic(self.material):
            return linear
        remainder_moments(
            self.material, theta, self._node_lanes, self._corner_lanes, self._maps, self._excess
        )
        self._at_corners.gather_scalars(self._excess, self._rest)
        return np.asarray(linear + self._solve(self._rest))

    def internal_force(self, x: Array, force: Array) -> None:
        """``force (N, 3)`` [N] ``= dPi/dx`` at positions ``x (N, 3)`` [m]."""
        theta = self.dilatation(x)
        element_forces(
            self.material,
            Fields(x, theta, self._pressure(theta)),
            self._node_lanes,
            self._corner_lanes,
            self._maps,
            Forces(self._smallest_jacobian, self._shrinkage, self._element_force),
        )
        self._at_nodes.gather(self._element_force, force)

    def smallest_length(self) -> float:
        """``min_e share length_e lambda_e / max(1, s_e theta_e)`` [m] at the last force.

        ``length_e`` is the smallest stretch of the reference maps of the eighths of element ``e``,
        ``share`` that of :func:`~fem_reference.quadratic_tables.step_share`, ``s_e`` how much
        stiffer the volume is than at rest (``law.stiffening``).
        """
        return float(np.min(self._length * one_by_one(self._shrinkage, self.count)))

    def invalid_element(self) -> int:
        """First element that is invalid at the last force, or -1.

        Invalid: ``J <= 0`` or ``nan`` at a Gauss point, or a stretch below ``THINNEST``.
        """
        return first_invalid(self._smallest_jacobian, self._shrinkage)

    def centre(self, element: int) -> Array:
        """Undeformed centre ``(3,)`` [m] of an element."""
        return np.asarray(self.mesh.vertices[self._cells[element, 13]])

    def strain_energy(self, x: Array) -> float:
        """``Pi`` [J]."""
        energies = np.empty_like(self._shrinkage)
        isochoric_energies(self.material, x, self._node_lanes, self._maps, energies)
        return float(np.sum(one_by_one(energies, self.count))) + self.volumetric_energy(x)

    def volumetric_energy(self, x: Array) -> float:
        """``integral of U(1 + theta)`` [J], by the element's own quadrature."""
        theta = self.dilatation(x)
        total = 0.5 * self._kappa * float(np.sum(self._moments * theta))
        if not law.is_quadratic(self.material):
            energies = np.empty_like(self._shrinkage)
            remainder_energies(
                self.material, theta, self._node_lanes, self._corner_lanes, self._maps, energies
            )
            total += float(np.sum(one_by_one(energies, self.count)))
        return total

    def stress(self, x: Array) -> CentroidStress:
        """At the centres of the eighths: ``F``, ``J = theta``, ``P + (U'(theta) - U'(J)) cof F``.

        They lie close to the 2x2x2 Gauss points, where gradients of quadratic shapes are best.
        """
        slopes = quadratic_gradients(PART_CENTRES)
        D, A = (
            np.einsum("eni,pnk->epik", y[self._cells], slopes) for y in (x, self.mesh.vertices)
        )
        F = (D @ np.linalg.inv(A)).reshape(-1, 3, 3)
        excess = self.dilatation(x)[self._corners] @ trilinear(PART_CENTRES).T
        return mixed_stress(self.material, F, 1.0 + excess.ravel())

    def description(self) -> str:
        """One line for the plan of a run."""
        shape = "equal bricks" if len(self._maps.X) == 0 else "hexahedra of any shape"
        return (
            f"{self.count} Q2-Q1 (Taylor-Hood) {shape}, two spacings wide, 3x3x3 Gauss points, "
            f"continuous dilatation by {self._dilatation}"
        )
