"""What the time loop needs of an element technology."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fem_reference.load_shapes import LoadShapes
from sphsolid.continuum import law
from sphsolid.continuum.tensor import axpy, cofactor, determinant, join, split
from sphsolid.continuum.wave_speed import THINNEST
from sphsolid.errors import InputError
from sphsolid.geometry.mesh import Mesh
from sphsolid.protocols import check_protocol

Array = NDArray[np.float64]
#: No force of anything.
_UNWRITTEN = 1.234e300


@dataclass(frozen=True)
class CentroidStress:
    """``F (E, 3, 3)``, ``J (E,)`` and ``P (E, 3, 3)`` [Pa] at the centres of cells."""

    F: Array
    J: Array
    P: Array


def mixed_stress(material: Any, F: Array, J: Array) -> CentroidStress:
    """``P(F) + (U'(J) - U'(det F)) cof F``: the law with the Jacobian ``J`` of a mixed method.

    The mean of the Cauchy stress ``P F^T / det F`` is ``U'(J)`` where the law splits.
    """
    entries = split(F)
    H, J_F = cofactor(entries), determinant(entries)
    excess = law.volumetric_pressure(material, J) - law.volumetric_pressure(material, J_F)
    P = axpy(excess, H, law.first_piola(material, entries, H, J_F))
    return CentroidStress(F, J, np.ascontiguousarray(join(P)))


def first_invalid(smallest_J: Array, shrinkage: Array) -> int:
    """First element with ``J <= 0`` or ``nan``, or with a stretch below ``THINNEST``; else -1."""
    jacobian, stretch = smallest_J.ravel(), shrinkage.ravel()
    # argmin stops at the first nan, and a comparison with nan is False.
    worst = int(np.argmin(jacobian))
    if not jacobian[worst] > 0.0:
        return worst
    thin = int(np.argmin(stretch))
    return -1 if stretch[thin] > THINNEST else thin


def volumetric_energy(elements: Elements, x: Array, at_centres: float) -> float:
    """``Pi_vol`` [J] of elements that say it, by ``volumetric_energy(x)``; else ``at_centres``."""
    said = getattr(elements, "volumetric_energy", None)
    return at_centres if said is None else float(said(x))


class Elements(Protocol):
    """Elements of one mesh and material, ready for explicit time steps."""

    @property
    def mesh(self) -> Mesh:
        """Its vertices are the nodes; stresses are handed out at the centres of its cells."""
        ...

    @property
    def load_shapes(self) -> LoadShapes:
        """Shape functions of the nodes, for loads."""
        ...

    @property
    def count(self) -> int:
        """Number of elements ``E``."""
        ...

    @property
    def volumes(self) -> Array:
        """Reference volumes [m^3] of the cells of ``mesh``."""
        ...

    @property
    def nodal_volumes(self) -> Array:
        """Lumped volumes ``(N,)`` [m^3] of the nodes, all positive."""
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

    def centre(self, element: int) -> Array:
        """Undeformed centre ``(3,)`` [m] of an element."""
        ...

    def strain_energy(self, x: Array) -> float:
        """The energy [J] whose gradient ``internal_force`` is."""
        ...

    def stress(self, x: Array) -> CentroidStress:
        """Recovered at the centres of the cells of ``mesh``."""
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

    def cell_size(self, spacing: float) -> float:
        """Edge [m] of the cells whose nodes are ``spacing`` [m] apart."""
        ...

    def discretise(self, *, mesh: Any, sk: Any, material: Any) -> Elements:
        """Elements of ``mesh`` (``sk`` is the same mesh in scikit-fem) made of ``material``.

        The mesh has hexahedra, or what an attribute ``cells`` of the option makes of them.
        """
        ...


def check_elements(name: str, made: object) -> None:
    """Raise ``InputError`` unless ``made`` keeps the protocol of :class:`Elements`."""
    check_protocol(
        f"what discretise() of element {name} returned", made,
        [each for each in vars(Elements) if not each.startswith("_")],
        "derive it from BBarHexElements, or see docs/how_to_add/element.md",
    )


def refuse_unwritten_force(name: str, elements: Elements, x: Array) -> None:
    """Raise ``InputError`` where ``internal_force`` hands forces out in place of writing them."""
    force = np.full_like(x, _UNWRITTEN)
    made: object = elements.internal_force(x, force)  # type: ignore[func-returns-value]
    if made is not None or (force == _UNWRITTEN).any():
        raise InputError(
            f"element {name}: internal_force(x, force) must write the forces of all nodes into "
            f"force and return nothing; it returned {type(made).__name__}"
        )


def check_element(element: object) -> None:
    """Raise ``InputError`` unless ``element`` keeps the protocol."""
    check_protocol(
        "element", element, ("name", "cell_size", "discretise"),
        "it is no element technology: use BBarHex() or TaylorHoodHex(), or see "
        "docs/how_to_add/element.md",
    )
