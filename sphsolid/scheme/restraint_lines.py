"""The restraint on the lines of a box lattice (see ``restraint`` for what it is).

About a particle with two neighbours on either side of it along an axis,

    e = (x_-2 - 4 x_-1 + 6 x_0 - 4 x_1 + x_2) / 8,

and on an axis of three or four particles ``(x_-1 - 2 x_0 + x_1) / 2``.  A saw tooth has as large an
``e`` as in a pair.  An affine motion has none, so no part goes through ``F`` but that of the rate
``s = F^T de/dt + L^T e``, with ``F`` and ``L`` at the middle.  ``V`` there is the spacing times the
weights of the other two axes.

This is the plain form, for any formulation; ``lattice_force`` has it in kernels.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.lattice.box import BoxLattice, box_of
from sphsolid.scheme.restraint_term import Measured, RestraintParts, RestraintTerm
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.viscous_share import viscous_shares

if TYPE_CHECKING:
    from sphsolid.scheme.restraint import Restraint

Array = NDArray[np.float64]
FOURTH = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 8.0
SECOND = np.array([-1.0, 2.0, -1.0]) / 2.0


class _Axis(NamedTuple):
    """``weights`` of the difference along ``axis``; ``middle`` particles and ``V`` there."""

    axis: int
    weights: Array
    dx: float
    middle: tuple[slice, ...]
    V: Array

    def difference(self, f: Array) -> Array:
        """``e`` of ``f (nx, ny, nz, .)`` at the middles."""
        reach = len(self.weights) // 2
        n = f.shape[self.axis] - 2 * reach
        along = np.moveaxis(f, self.axis, 0)
        total = sum(w * along[m : m + n] for m, w in enumerate(self.weights))
        return np.moveaxis(np.asarray(total), 0, self.axis)

    def spread(self, t: Array, out: Array) -> None:
        """Take the transpose of :meth:`difference` of ``t`` from ``out``."""
        n = t.shape[self.axis]
        to, of = np.moveaxis(out, self.axis, 0), np.moveaxis(t, self.axis, 0)
        for m, w in enumerate(self.weights):
            to[m : m + n] -= w * of


class LineRestraint(RestraintTerm):
    """The restraint along the lines of one body that is a box lattice."""

    form = "along the lines"

    def __init__(self, options: Restraint, parts: RestraintParts, set_up: SetUp) -> None:
        super().__init__(options, parts, set_up)
        box = box_of(set_up.cloud.mesh)
        assert isinstance(box, BoxLattice), "a lattice difference has one"
        self._box = box
        self._direct = np.zeros((0, 3))
        norms = _weights(box, set_up.cloud.V[box.number])
        pull = sum(
            _largest(_weights_of(n), norms[axis]) / box.dx[axis]
            for axis, n in enumerate(box.counts)
            if n >= 3
        )
        self.rate = parts.viscosity * pull / set_up.material.density

    # The evaluation on a box lattice has tables of its own and no use for these.
    @cached_property
    def _number(self) -> NDArray[np.int64]:
        return self._box.number

    @cached_property
    def _V(self) -> Array:
        return np.asarray(self._set_up.cloud.V[self._number][..., None])

    @cached_property
    def _axes(self) -> list[_Axis]:
        return list(_axes(self._box, self._set_up.cloud.V[self._number]))

    def add_stress(self, stage: Stage) -> None:
        """What goes through ``F`` and ``L``; the rest is kept for :meth:`add_rates`."""
        x, v, F, L = self._grids(self.measured(stage))
        parts, force = self.acting, np.zeros_like(x)
        through = np.zeros((*x.shape, 3))
        for axis in self._axes:
            e, V = axis.difference(x), axis.V[..., None]
            r2 = np.sum(e * e, axis=-1, keepdims=True) / axis.dx**2
            t = V / axis.dx**2 * (parts.quartic * r2 + parts.elastic) * e
            if self.needs_rates:
                F_m, L_m = F[axis.middle], L[axis.middle]
                c = parts.viscosity * V / axis.dx * viscous_shares(F_m, self.acting.most)[..., None]
                w = c * _rate(F_m, L_m, axis.difference(v), e)
                t += np.einsum("...ij,...j->...i", F_m, w)
                through[axis.middle] += e[..., :, None] * w[..., None, :]
            axis.spread(t, force)
        if not self._direct.size:
            self._direct = np.zeros((self._set_up.cloud.size, 3))
        self._direct[self._number] = force / self._V
        stage.P[self._number] += through / self._V[..., None]

    def add_rates(self, stage: Stage) -> None:
        """What acts along the lines."""
        stage.rates.p += self._direct

    def _sums(self, measured: Measured, given: tuple[Array, Array]) -> tuple[float, float]:
        x, v, F, L = self._grids(measured)
        stored = taken = 0.0
        for axis in self._axes:
            e = axis.difference(x)
            r2 = np.sum(e * e, axis=-1) / axis.dx**2
            parts = self.acting
            stored += float(
                np.sum(axis.V * (0.25 * parts.quartic * r2 + 0.5 * parts.elastic) * r2)
            )
            if L.size:
                v_given, L_given = self._vectors(given[0]), self._tensors(given[1])
                F_m, L_m = F[axis.middle], L[axis.middle]
                s = _rate(F_m, L_m, axis.difference(v), e)
                other = _rate(F_m, L_given[axis.middle], axis.difference(v_given), e)
                c = parts.viscosity * axis.V / axis.dx * viscous_shares(F_m, self.acting.most)
                taken -= float(np.sum(c * np.sum(s * other, axis=-1)))
        return stored, taken

    def _grids(self, measured: Measured) -> tuple[Array, Array, Array, Array]:
        """``x, v (nx, ny, nz, 3)`` and ``F, L (nx, ny, nz, 3, 3)``."""
        x, v, F, L = measured
        return self._vectors(x), self._vectors(v), self._tensors(F), self._tensors(L)

    def _vectors(self, rows: Array) -> Array:
        return np.asarray(rows.T[self._number] if rows.size else rows)

    def _tensors(self, memory: Array) -> Array:
        if not memory.size:
            return memory
        if memory.ndim == 2:
            return np.asarray(memory.T[self._number].reshape(*self._number.shape, 3, 3))
        return np.asarray(memory[self._number])


def _rate(F: Array, L: Array, v: Array, e: Array) -> Array:
    """``d(F^T e)/dt = F^T v + L^T e`` with ``v`` the rate of ``e``."""
    return np.asarray(
        np.einsum("...ji,...j->...i", F, v) + np.einsum("...ji,...j->...i", L, e)
    )


#: Points of a line that has the largest eigenvalue of any longer one.
_LONG = 64


def _largest(difference: Array, norm: Array) -> float:
    """Largest eigenvalue of ``H^-1 D^T D``, four inside."""
    n = len(norm)
    h = norm if n <= _LONG else np.concatenate([norm[: _LONG // 2], norm[-_LONG // 2 :]])
    middles = len(h) - len(difference) + 1
    D = np.zeros((middles, len(h)))
    for row in range(middles):
        D[row, row : row + len(difference)] = difference
    return float(np.linalg.eigvalsh((D / h) @ D.T)[-1])


def _weights_of(n: int) -> Array:
    """The difference along an axis of ``n`` particles, three or more."""
    return FOURTH if n >= 5 else SECOND


def _weights(box: BoxLattice, V: Array) -> list[Array]:
    """The norm along each axis: volumes over those at the first particle of a line."""
    lines = [V[:, 0, 0], V[0, :, 0], V[0, 0, :]]
    return [line / np.sum(line) * (len(line) - 1) for line in lines]


def _axes(box: BoxLattice, V: Array) -> Iterator[_Axis]:
    weights = _weights(box, V)
    for axis, n in enumerate(box.counts):
        if n < 3:
            continue
        difference = _weights_of(n)
        reach = len(difference) // 2
        middle = tuple(
            slice(reach, n - reach) if other == axis else slice(None) for other in range(3)
        )
        own = np.expand_dims(weights[axis], [other for other in range(3) if other != axis])
        yield _Axis(axis, difference, box.dx[axis], middle, (V / own)[middle])
