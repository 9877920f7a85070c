"""Differences along the lines of a box lattice, of order two, four or six inside.

They sum by parts (``lattice.closures``), so with their own norm as volumes and products of norms as
boundary areas a uniform stress has no force, force and gradient are adjoint, and the order at the
boundary is half of that inside [Strand1994].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array, kron

from sphsolid.cloud.lattice.box import BoxLattice, NoBox, box_of
from sphsolid.cloud.lattice.closures import difference
from sphsolid.cloud.lattice.lines import order_of
from sphsolid.cloud.operator import Gradients, Ingredients, Layout
from sphsolid.cloud.pairs.neighbours import PairList
from sphsolid.errors import InputError
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh
from sphsolid.protocols import one_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatticeDifference:
    """Summation-by-parts differences of ``order`` 2, 4 or 6 inside, half of it at the boundary.

    For bodies that are a full box of lattice points.  An axis with too few of them has a lower
    order, which ``plan()`` says.
    """

    order: int = 4

    def __post_init__(self) -> None:
        order = one_of("LatticeDifference: order", self.order, (2, 4, 6))
        object.__setattr__(self, "order", order)

    @property
    def name(self) -> str:
        """``LatticeDifference4`` for order four."""
        return f"LatticeDifference{self.order}"

    def orders(self, mesh: Mesh) -> tuple[int, int, int]:
        """The order along X, Y and Z."""
        x, y, z = (order_of(self.order, n) for n in self._box(mesh).counts)
        return x, y, z

    def detail(self, mesh: Mesh) -> str:
        """What ``plan()`` says of it."""
        counts, orders = self._box(mesh).counts, self.orders(mesh)
        lower = [
            f"{order} along {axis} ({n} particles)"
            for axis, n, order in zip("XYZ", counts, orders, strict=True)
            if order < self.order
        ]
        return f"order {self.order} inside" + (f", but {', '.join(lower)}" if lower else "")

    def layout(self, mesh: Mesh) -> Layout:
        """Volumes, areas and pairs of its own."""
        box = self._box(mesh)
        weights = [
            dx * difference(order, n).arrays()[0]
            for order, n, dx in zip(self.orders(mesh), box.counts, box.dx, strict=True)
        ]
        x, y, z = weights
        V = _numbered(box, x[:, None, None] * y[:, None] * z)
        across = [
            y[:, None] * z + 0.0 * x[:, None, None],
            x[:, None, None] * z + 0.0 * y[:, None],
            x[:, None, None] * y[:, None] + 0.0 * z,
        ]
        lattice_areas = np.stack([_numbered(box, np.asarray(area)) for area in across], axis=1)
        faces = {}
        whole = area_vectors(mesh, mesh.boundary)
        for name in mesh.faces:
            part = area_vectors(mesh, mesh.face(name))
            # A tag has of every particle the share that it has of the area between the cells.
            share = np.divide(part, np.abs(whole), out=np.zeros_like(part), where=whole != 0.0)
            faces[name] = share * lattice_areas
        # A particle is among its own neighbours, as in every list of pairs.
        pattern = (sum(abs(D) for D in self._matrices(box)) + eye_array(len(V))).tocsr()
        pattern.sort_indices()
        pairs = PairList(pattern.indptr.astype(np.int64), pattern.indices.astype(np.uint32))
        return Layout(V, faces, pairs)

    def build(self, cloud: Ingredients) -> Gradients:
        """The gradient on the pairs of :meth:`layout`."""
        row, column = cloud.pairs.row_of_pair, cloud.pairs.indices.astype(np.int64)
        columns = [
            np.asarray(D.tocsr()[row, column]).ravel()
            for D in self._matrices(self._box(cloud.mesh))
        ]
        G = np.stack(columns, axis=1)
        return Gradients(G, G, cloud.areas)

    def _box(self, mesh: Mesh) -> BoxLattice:
        box = box_of(mesh)
        if isinstance(box, NoBox):
            raise InputError(
                "LatticeDifference needs particles that are a full box of lattice points, and of "
                "this body they are not; use Consistent() on other lattices and "
                "SummationByParts() elsewhere"
            )
        return box

    def _matrices(self, box: BoxLattice) -> list[csr_array]:
        """``d/dX, d/dY, d/dZ`` ``(N, N)`` [1/m] in the numbering of the particles."""
        line = box.number.ravel()
        ones = [eye_array(n) for n in box.counts]
        found = []
        for axis, (n, dx) in enumerate(zip(box.counts, box.dx, strict=True)):
            factors: list[Any] = list(ones)
            D = difference(order_of(self.order, n), n).arrays()[1] / dx
            factors[axis] = csr_array(D)
            product = kron(kron(factors[0], factors[1]), factors[2]).tocoo()
            found.append(
                csr_array((product.data, (line[product.row], line[product.col])), product.shape)
            )
        return found


def _numbered(box: BoxLattice, grid: Array) -> Array:
    """Values at grid points ``(nx, ny, nz)`` in the numbering of the particles ``(N,)``."""
    values = np.empty(grid.size)
    values[box.number.ravel()] = grid.ravel()
    return values


def has_lines(kind: object) -> TypeGuard[LatticeDifference]:
    """True where kernels along lines have the coefficients: a subclass may have its own."""
    return type(kind) is LatticeDifference
