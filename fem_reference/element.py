"""What the time loop needs of an element technology."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from sphsolid.scenes.hex_mesh import HexMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CentroidStress:
    """``F (E, 3, 3)``, ``J (E,)`` and ``P (E, 3, 3)`` [Pa] at the element centroids."""

    F: Array
    J: Array
    P: Array


class Elements(Protocol):
    """Elements of one mesh and material, ready for explicit time steps."""

    @property
    def volumes(self) -> Array:
        """Reference volumes ``(E,)`` [m^3]."""
        ...

    @property
    def nodal_volumes(self) -> Array:
        """Row-sum lumped volumes ``(N,)`` [m^3]."""
        ...

    @property
    def nbytes(self) -> int:
        """Memory of all arrays held."""
        ...

    def internal_force(self, x: Array, force: Array) -> None:
        """Write the internal nodal forces ``(N, 3)`` [N] of positions ``x (N, 3)`` [m]."""
        ...

    def smallest_length(self) -> float:
        """Smallest ``L`` [m] at the last ``internal_force``; a p-wave crosses it in ``L / c_p``."""
        ...

    def invalid_element(self) -> int:
        """Element that is folded, not finite or flattened at the last force; -1 when none."""
        ...

    def strain_energy(self, x: Array) -> float:
        """The energy [J] whose gradient ``internal_force`` is."""
        ...

    def stress(self, x: Array) -> CentroidStress:
        """Recovered at the centroids."""
        ...

    def description(self) -> str:
        """One line for the plan of a run."""
        ...


class Element(Protocol):
    """An element technology: an option object that can fill a mesh."""

    @property
    def name(self) -> str:
        """Short name used in file names."""
        ...

    def discretise(self, *, mesh: HexMesh, sk: MeshHex, material: Any) -> Elements:
        """Elements of ``mesh`` (``sk`` is the same mesh in scikit-fem) made of ``material``."""
        ...
