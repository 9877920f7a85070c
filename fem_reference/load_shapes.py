"""The shape functions with which loads are spread over the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import ElementHex1, MeshHex
from skfem.element import Element


@dataclass(frozen=True)
class LoadShapes:
    """A scikit-fem ``element``, the ``degree`` its quadrature is exact to, and our numbering.

    ``node_of_dof (N,)`` is the node that a degree of freedom of ``element`` belongs to.
    """

    element: Element
    degree: int
    node_of_dof: NDArray[np.int64]


def trilinear_shapes(sk: MeshHex) -> LoadShapes:
    """One node a vertex, in the order of the mesh; 2x2x2 (2x2 on facets) Gauss points."""
    return LoadShapes(ElementHex1(), 3, np.arange(sk.p.shape[1]))
