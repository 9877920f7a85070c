"""A box lattice with rough fields, and its energy written with whole matrices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.cloud.lattice.closures import difference
from sphsolid.cloud.lattice.line_filter import filter_matrix
from sphsolid.cloud.lattice.lines import Grid, lines, norm, order_of, planes
from sphsolid.continuum import law
from sphsolid.fields import leading
from sphsolid.scheme import lattice_force as lattice
from sphsolid.scheme.lattice_arguments import packed
from sphsolid.scheme.lattice_step import forces
from sphsolid.scheme.restraint_term import RestraintParts

SOLID = sph.NeoHookean.from_young(young_modulus=1.7e7, poisson_ratio=0.45, density=1100.0)
NONE = RestraintParts(0.0, 0.0, 0.0, 0.0, 0.0, math.inf)
SIDES = (1.0, 1.2, 1.5)


class LatticeBody:
    """Positions and momenta that are rough on the scale of the spacing.

    Fields are ``(3, nx, ny, nz)`` here, whatever axis is the slow one in the kernels.
    """

    def __init__(
        self,
        order: int,
        counts: tuple[int, int, int],
        *,
        smoothing: int = 1,
        beta: float = 0.0,
        slow: int = 0,
        workers: int = 2,
        solid: Any = SOLID,
    ) -> None:
        self.order, self.counts, self.smoothing, self.beta = order, counts, smoothing, beta
        self.solid = solid
        self.axes = tuple((slow + a) % 3 for a in range(3))
        self.dx = [side / (n - 1) for side, n in zip(SIDES, counts, strict=True)]
        self.grid = Grid(
            *(
                lines(order, counts[a], self.dx[a], column=a, smoothing=smoothing)
                for a in self.axes
            )
        )
        self.tables = planes(self.grid, smoothing)
        self.V = self._physical(norm(self.grid)[None])[0]
        rng = np.random.default_rng(3)
        axes = [np.linspace(0.0, side, n) for side, n in zip(SIDES, counts, strict=True)]
        self.X = np.stack(np.meshgrid(*axes, indexing="ij"))
        self.x = self.X + 0.05 * np.sin(2.0 * self.X[::-1])
        self.x = self.x + 0.03 * min(self.dx) * rng.normal(size=self.X.shape)
        self.p = 1100.0 * rng.normal(size=self.X.shape)
        self.workers = workers
        #: Of the last evaluation.
        self.stretch = np.zeros(counts)

    def _physical(self, rows: Any) -> Any:
        shape = [self.counts[a] for a in self.axes]
        back = [1 + self.axes.index(a) for a in range(3)]
        return rows.reshape(len(rows), *shape).transpose(0, *back)

    def _rows(self, field: Any) -> Any:
        out = np.zeros((3, leading(self.V.size)))
        out[:, : self.V.size] = field.transpose(0, *(1 + a for a in self.axes)).reshape(3, -1)
        return out

    def force(self, parts: Any, x: Any = None, p: Any = None) -> Any:
        """By the kernels."""
        work = lattice.make_work(
            self.grid,
            workers=self.workers,
            filtered=self.smoothing > 0,
            restrained=parts != NONE,
            beta=self.beta > 0.0,
        )
        x, p = (
            self._rows(field if given is None else given)
            for given, field in ((x, self.x), (p, self.p))
        )
        out, limit = np.full_like(x, np.nan), np.full(x.shape[1], np.nan)
        forces(
            packed(self.grid), self.tables, law.in_kernels(self.solid), self.beta, parts, x, p,
            work, limit, out,
        )  # fmt: skip
        self.stretch = self._physical(limit[None, : self.V.size])[0]
        return self._physical(out[:, : self.V.size])

    def gradient(self, field: Any) -> Any:
        """``(3, 3, nx, ny, nz)``."""
        parts = []
        for axis, (n, dx) in enumerate(zip(self.counts, self.dx, strict=True)):
            _, D = difference(order_of(self.order, n), n).arrays()
            parts.append(np.moveaxis(np.tensordot(D / dx, field, (1, axis + 1)), 0, axis + 1))
        return np.stack(parts, axis=1)

    def filtered(self, J: Any) -> Any:
        """``S J``."""
        for axis, n in enumerate(self.counts):
            h, _ = difference(order_of(self.order, n), n).arrays()
            S = filter_matrix(h, self.smoothing)
            J = np.moveaxis(np.tensordot(S, J, (1, axis)), 0, axis)
        return J

    def energy(self, x: Any, parts: Any) -> float:
        """Written with whole matrices, independently of the kernels; the law is one that splits."""
        springs = 0.0
        for axis, (n, dx) in enumerate(zip(self.counts, self.dx, strict=True)):
            q = 4 if n >= 5 else 2
            if n > q:
                h, _ = difference(order_of(self.order, n), n).arrays()
                e = np.diff(x, n=q, axis=axis + 1) / (8.0 if q == 4 else 2.0)
                middle = [slice(q // 2, n - q // 2) if d == axis else slice(None) for d in range(3)]
                others = self.V / np.expand_dims(h, tuple({0, 1, 2} - {axis}))
                size = np.sum(e * e, axis=0) / dx**2
                density = 0.25 * parts.quartic * size**2 + 0.5 * parts.elastic * size
                springs += float(np.sum(others[tuple(middle)] * density))
        F = self.gradient(x)
        J = np.linalg.det(np.moveaxis(F, (0, 1), (-2, -1)))
        S = self.filtered(J)
        W = 0.5 * SOLID.mu * J ** (-2.0 / 3.0) * np.sum(F * F, axis=(0, 1))
        W += 0.5 * SOLID.kappa * (S - 1.0) ** 2 + 0.5 * self.beta * (J - S) ** 2
        return float(np.sum(self.V * W)) + springs

    def power(self, f: Any, p: Any = None) -> float:
        """``sum V f . v`` [W]."""
        return float(np.sum(self.V * f * (self.p if p is None else p))) / 1100.0
