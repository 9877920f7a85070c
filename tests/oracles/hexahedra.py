"""Shape functions of hexahedra in plain numpy: nothing of it is shared with the kernels."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.cell_shape import CORNERS

Array = NDArray[Any]
#: Gauss-Legendre rules on [0, 1], exact to degree 3 and 5.
RULES = {n: tuple(0.5 * a for a in np.polynomial.legendre.leggauss(n)) for n in (2, 3)}


def tensor_shapes(nodes: Array, points: Array) -> tuple[Array, Array]:
    """Lagrange shapes ``(p, n)`` and derivatives ``(p, n, 3)`` on a lattice ``nodes (n, 3)``."""
    values = np.ones((len(points), len(nodes), 3))
    slopes = np.zeros_like(values)
    for n, a in itertools.product(range(len(nodes)), range(3)):
        others = [s for s in np.unique(nodes[:, a]) if s != nodes[n, a]]
        polynomial = np.poly1d(np.poly(others) / np.prod(nodes[n, a] - np.array(others)))
        values[:, n, a] = polynomial(points[:, a])
        slopes[:, n, a] = polynomial.deriv()(points[:, a])
    gradient = [np.prod(np.where(np.arange(3) == a, slopes, values), axis=2) for a in range(3)]
    return np.prod(values, axis=2), np.stack(gradient, axis=2)


def gauss_points(n: int) -> tuple[Array, Array]:
    """Points ``(n^3, 3)`` in [0, 1]^3 and weights."""
    s, w = RULES[n][0] + 0.5, RULES[n][1]
    points = np.array(list(itertools.product(s, repeat=3)))
    return points, np.array([np.prod(three) for three in itertools.product(w, repeat=3)])


def gauss_data(corners: Array, nodes: Array, n: int) -> tuple[Array, Array, Array]:
    """``dN_a/dX (E, p, a, 3)``, ``w_g det dX/dxi (E, p)``, corner shapes ``(p, 8)``.

    ``corners (E, 8, 3)`` undeformed, ``nodes (a, 3)`` the reference nodes of the shapes.
    """
    points, weights = gauss_points(n)
    N, dN = tensor_shapes(CORNERS.astype(float), points)
    tangent = np.einsum("eai,pak->epik", corners, dN)
    shapes = tensor_shapes(nodes, points)[1]
    return (
        np.einsum("pak,epki->epai", shapes, np.linalg.inv(tangent)),
        weights * np.linalg.det(tangent),
        N,
    )
