"""The lowest bending mode of a clamped block, by quadratic finite elements and an eigensolver.

Linear elasticity, elements of 27 nodes, ``K u = omega^2 M u``.  One quarter of the block is solved,
between the middle planes and two faces: the motion along X is even in both, so the mode is unique.
Elements become smaller towards the clamp and the outer edges, where the stress is singular.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

Array = NDArray[np.float64]
#: The block: ``WIDTH x HEIGHT x WIDTH`` [m], clamped at ``Y = 0``; its solid is the column's.
WIDTH, HEIGHT = 0.5, 1.0
YOUNG, DENSITY = 17.0e6, 1100.0
#: Elements across a quarter of the block; twice as many along it.
LEVELS = (2, 3, 4)


@dataclass(frozen=True)
class Mode:
    """``omega`` [rad/s] on the finest mesh and ``limit`` of the sequence, and the mode's shape."""

    omega: float
    limit: float
    basis: Basis
    values: Array

    def __call__(self, X: Array) -> Array:
        """Displacement ``(n, 3)`` at ``X (n, 3)`` [m], largest component one."""
        x, z = X[:, 0] - 0.5 * WIDTH, X[:, 2] - 0.5 * WIDTH
        inside = np.stack([np.abs(x), X[:, 1], np.abs(z)])
        found = (self.basis.probes(inside) @ self.values).reshape(3, -1).T
        sign = np.stack([np.ones_like(x), np.sign(x), np.sign(x) * np.sign(z)], axis=1)
        return np.asarray(sign * found / np.max(np.abs(self.values)))


@cache
def lowest_mode(poisson_ratio: float) -> Mode:
    """Of the block; the limit by the order that three meshes show (Richardson)."""
    found = [_solved(poisson_ratio, count) for count in LEVELS]
    omega = [each[0] for each in found]
    return Mode(omega[-1], _limit(omega), found[-1][1], found[-1][2])


def _solved(poisson_ratio: float, count: int) -> tuple[float, Basis, Array]:
    across = 0.5 * WIDTH * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, count + 1))
    along = HEIGHT * np.linspace(0.0, 1.0, 2 * count + 1) ** 1.7
    mesh = MeshHex.init_tensor(across, along, across)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=5)
    K = linear_elasticity(*lame_parameters(YOUNG, poisson_ratio)).assemble(basis)
    M = BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis)
    held = np.unique(np.concatenate([
        basis.get_dofs(lambda x: np.isclose(x[1], 0.0)).all(),
        basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all(["u^2", "u^3"]),
        basis.get_dofs(lambda x: np.isclose(x[2], 0.0)).all(["u^3"]),
    ]))  # fmt: skip
    free = basis.complement_dofs(held)
    square, shape = eigsh(K[free][:, free], k=1, M=M[free][:, free], sigma=0.0)
    values = np.zeros(basis.N)
    values[free] = shape[:, 0]
    return float(np.sqrt(square[0])), basis, values


def _limit(omega: list[float]) -> float:
    """Richardson's, from three meshes with ``LEVELS`` elements: ``omega + C / count^p``."""
    a, b, c = omega
    ratio = (a - b) / (b - c)
    n = np.array(LEVELS, dtype=float)
    orders = np.linspace(0.5, 6.0, 5501)
    power = n[:, None] ** -orders
    p = orders[np.argmin(np.abs((power[0] - power[1]) / (power[1] - power[2]) - ratio))]
    return float(c - (b - c) * n[2] ** -p / (n[1] ** -p - n[2] ** -p))
