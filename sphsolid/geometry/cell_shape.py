"""Shapes of cells and facets: corner order, shape functions and the quadrature they need.

A *rule* holds, at each of its points, the weight, the shape functions and their gradients in
reference coordinates.  Rules are exact for every integral of ``integrals``: Jacobian times shape
function in a cell, area vector times two shape functions on a facet.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Corner ``c`` of a hexahedron sits at reference coordinates ``CORNERS[c]`` in {0, 1}^3.
CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
_SQUARE = CORNERS[:4, :2]
_GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


@dataclass(frozen=True)
class RulePoint:
    """``weight``; shape functions ``N (k,)`` and their reference gradients ``slopes (k, d)``."""

    weight: float
    N: Array
    slopes: Array


Rule = tuple[RulePoint, ...]


@dataclass(frozen=True)
class CellShape:
    """What the integrals and the files need to know of a kind of cell.

    ``corners`` of a cell; ``facets (n, m)`` its facets as local corners, outward; ``cell_rule``,
    ``facet_rule`` as the module says; ``vtk`` the name of the cell and ``vtk_facet`` that of its
    facets in meshio.
    """

    name: str
    corners: int
    facets: NDArray[np.int64]
    cell_rule: Rule
    facet_rule: Rule
    vtk: str
    vtk_facet: str


def multilinear(corners: NDArray[np.int64], point: tuple[float, ...]) -> tuple[Array, Array]:
    """Shape functions ``(k,)`` and gradients ``(k, d)`` of a unit cube or square at ``point``."""
    factor = np.where(corners == 1, point, 1.0 - np.asarray(point))
    slope = np.where(corners == 1, 1.0, -1.0)
    dimension = corners.shape[1]
    gradient = np.empty(corners.shape)
    for d in range(dimension):
        others = [k for k in range(dimension) if k != d]
        gradient[:, d] = slope[:, d] * np.prod(factor[:, others], axis=1)
    return np.prod(factor, axis=1), gradient


def linear(point: tuple[float, ...]) -> tuple[Array, Array]:
    """Shape functions ``(d + 1,)`` and gradients of a unit simplex at ``point``."""
    dimension = len(point)
    gradient = np.concatenate([-np.ones((1, dimension)), np.eye(dimension)])
    return np.array([1.0 - sum(point), *point]), gradient


def _rule(
    points: list[tuple[float, ...]],
    measure: float,
    functions: Callable[[tuple[float, ...]], tuple[Array, Array]],
) -> Rule:
    return tuple(RulePoint(measure / len(points), *functions(point)) for point in points)


HEXAHEDRON = CellShape(
    name="hexahedron",
    corners=8,
    facets=np.array(
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [0, 4, 7, 3], [1, 2, 6, 5]]
    ),
    cell_rule=_rule(
        list(itertools.product(_GAUSS, repeat=3)), 1.0, lambda p: multilinear(CORNERS, p)
    ),
    facet_rule=_rule(
        list(itertools.product(_GAUSS, repeat=2)), 1.0, lambda p: multilinear(_SQUARE, p)
    ),
    vtk="hexahedron",
    vtk_facet="quad",
)
TETRAHEDRON = CellShape(
    name="tetrahedron",
    corners=4,
    facets=np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    cell_rule=_rule([(0.25, 0.25, 0.25)], 1.0 / 6.0, linear),
    facet_rule=_rule([(0.5, 0.0), (0.5, 0.5), (0.0, 0.5)], 0.5, linear),
    vtk="tetra",
    vtk_facet="triangle",
)
