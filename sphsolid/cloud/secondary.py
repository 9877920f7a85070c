"""Secondary particles ``q``: where the SUPG terms are integrated, [Lee2017] section 4.2, Fig. 2.

``H1`` puts one at the centroid of each hexahedron of the background mesh.  ``H6`` puts one at the
centroid of each of the six tetrahedra of its Kuhn split.  ``T1`` puts one at the centroid of each
cell of a mesh of tetrahedra.  ``sum V_q`` is the volume of the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.agglomerated import Agglomerated
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import cell_volumes_and_centroids
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh, hexahedra

Array = NDArray[np.float64]
#: Six tetrahedra around the diagonal from corner 0 to corner 6, all of positive volume.
KUHN = np.array(
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
)


class SecondaryPoints(Protocol):
    """A rule that places secondary particles."""

    @property
    def name(self) -> str:
        """``H1``, ``H6``, ``T1``."""
        ...

    def place(self, mesh: Mesh) -> tuple[Array, Array]:
        """Positions ``X_q (M, 3)`` [m] and volumes ``V_q (M,)`` [m^3]."""
        ...


@dataclass(frozen=True)
class H1:
    """One secondary particle a hexahedron, at its centroid."""

    name: str = "H1"

    def place(self, mesh: Mesh) -> tuple[Array, Array]:
        """Positions ``X_q (C, 3)`` and volumes ``V_q (C,)``."""
        hexahedra(mesh, "secondary = H1()")
        volume, centroid = cell_volumes_and_centroids(mesh)
        return centroid, volume


@dataclass(frozen=True)
class H6:
    """Six secondary particles a hexahedron, at the centroids of its tetrahedra."""

    name: str = "H6"

    def place(self, mesh: Mesh) -> tuple[Array, Array]:
        """Positions ``X_q (6 C, 3)`` and volumes ``V_q (6 C,)``.

        Raises ``InputError`` where a tetrahedron is flat or inside out, which a strongly distorted
        hexahedron can hold without being so itself: its dissipation would feed energy.
        """
        tetrahedra = hexahedra(mesh, "secondary = H6()").cells[:, KUHN].reshape(-1, 4)
        corner = mesh.vertices[tetrahedra]
        edges = corner[:, 1:] - corner[:, :1]
        volume = np.linalg.det(edges) / 6.0
        worst = int(np.argmin(volume))
        if not volume[worst] > 0.0:
            raise InputError(
                f"H6: a tetrahedron of cell {worst // 6} of the background mesh is inverted or "
                f"flat (volume {volume[worst]:.3g} m^3 near X = "
                f"{corner[worst].mean(axis=0).tolist()} m); reduce the jitter or use H1()"
            )
        return corner.mean(axis=1), volume


@dataclass(frozen=True)
class T1:
    """One secondary particle a tetrahedron, at its centroid: five to six a primary particle."""

    name: str = "T1"

    def place(self, mesh: Mesh) -> tuple[Array, Array]:
        """Positions ``X_q (C, 3)`` and volumes ``V_q (C,)``."""
        if not isinstance(mesh, TetMesh):
            raise InputError(
                "secondary = T1() needs tetrahedra and the body is meshed with cells of type "
                f"{mesh.shape.name}; use H1() or H6()"
            )
        volume, centroid = cell_volumes_and_centroids(mesh)
        return centroid, volume


def default_secondary(mesh: Mesh) -> SecondaryPoints:
    """``H1`` on hexahedra, ``Agglomerated`` on tetrahedra and points."""
    return H1() if isinstance(mesh, HexMesh) else Agglomerated()
