"""Body force and boundary tractions as nodal forces.

    f_a(t) = integral N_a f0(X, t) dV + integral N_a t_B(X, N, t) dA

The fields change with time, the shape functions do not: ``N_a(X_q) w_q`` is put into sparse
matrices once (scikit-fem bases, with the Gauss points of the element), so an
evaluation costs one call of the field and one sparse product that gathers row by row.

The bases are of the body about its middle and about one long: scikit-fem inverts the map of a facet
to an absolute tolerance, which places far from the origin, or far apart, cannot reach.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from skfem import Basis, FacetBasis, MeshHex, MeshTet
from skfem.assembly.basis import AbstractBasis

from fem_reference.load_shapes import LoadShapes
from sphsolid.errors import InputError
from sphsolid.scenes.scene import NoBodyForce, Scene

Array = NDArray[np.float64]


class Load:
    """``f_a = sum_q [N_a(X_q) w_q] field(X_q)``.

    ``field(t) -> (Q, 3)`` at all quadrature points; ``matrix (N, Q)`` [m^3] or [m^2].
    """

    def __init__(self, what: str, field: Callable[[float], Array], matrix: csr_matrix) -> None:
        self.what, self.matrix = what, matrix
        self._field = field
        self._at = math.nan
        self._force = np.zeros((matrix.shape[0], 3))

    def nodal_force(self, t: float) -> Array:
        """``(N, 3)`` [N] at time ``t`` [s]; raises ``InputError`` for what the field may not do.

        The field is asked once an instant, whoever else wants its force: do not write into it.
        """
        if t != self._at:
            self._force = np.asarray(self.matrix @ self._field(t))
            self._at = t
        return self._force


@dataclass(frozen=True)
class _Unit:
    """``mesh``: the body about its middle, over a power of two of its size."""

    mesh: MeshHex | MeshTet
    middle: Array
    size: float

    @classmethod
    def of(cls, sk: MeshHex | MeshTet) -> _Unit:
        """That of a mesh."""
        middle = 0.5 * (sk.p.min(axis=1) + sk.p.max(axis=1))
        size = 2.0 ** round(math.log2(float(np.ptp(sk.p, axis=1).max())))
        return cls(sk.translated(tuple(-middle)).scaled(1.0 / size), middle, size)

    def points(self, basis: AbstractBasis) -> Array:
        """Quadrature points ``(Q, 3)`` [m] of the body, element by element."""
        local = np.asarray(basis.global_coordinates()).reshape(3, -1).T
        return np.ascontiguousarray(self.middle + self.size * local)


def loads_of(scene: Scene, sk: MeshHex | MeshTet, shapes: LoadShapes) -> tuple[Load, ...]:
    """The loads that the scene has: none for a body that only moves freely.

    Raises ``InputError`` for a traction on an unknown tag, or a field that fails at time zero; see
    :func:`sphsolid.scenes.callbacks.asked`.
    """
    loads: list[Load] = []
    unit = _Unit.of(sk)
    if not isinstance(scene.body_force, NoBodyForce):
        basis = Basis(unit.mesh, shapes.element, intorder=shapes.degree)
        X, matrix = unit.points(basis), unit.size**3 * _weighted_shapes(basis, shapes)
        loads.append(Load("body force", _at(scene.body_force_at, X), matrix))
    for traction in scene.tractions:
        facets = (sk.boundaries or {}).get(traction.face, np.empty(0, dtype=np.int64))
        if len(facets) == 0:
            raise InputError(
                f"traction on {traction.face!r}: unknown or empty boundary tag; the body has "
                f"{sorted(sk.boundaries or {})}"
            )
        surface = FacetBasis(unit.mesh, shapes.element, facets=facets, intorder=shapes.degree)
        X, matrix = unit.points(surface), unit.size**2 * _weighted_shapes(surface, shapes)
        normals = np.ascontiguousarray(surface.normals.reshape(3, -1).T)
        loads.append(Load(f"traction on {traction.face}", _at(traction.at, X, normals), matrix))
    for load in loads:
        load.nodal_force(0.0)
    return tuple(loads)


def nodal_force(loads: tuple[Load, ...], t: float, nodes: int) -> Array:
    """Sum of all loads ``(N, 3)`` [N], in their order."""
    total = np.zeros((nodes, 3))
    for load in loads:
        total += load.nodal_force(t)
    return total


def _at(field: Callable[..., Array], *points: Array) -> Callable[[float], Array]:
    """The field at fixed points, as a function of time alone."""
    return lambda t: field(*points, t)


def _weighted_shapes(basis: AbstractBasis, shapes: LoadShapes) -> csr_matrix:
    """``N_a(X_q) w_q`` as a matrix ``(N, Q)`` without its zeros (nodes off a facet)."""
    shape = basis.dx.shape
    column = np.arange(basis.dx.size)
    rows, columns, entries = [], [], []
    for local in range(basis.Nbfun):
        value = np.broadcast_to(np.asarray(basis.basis[local][0]), shape) * basis.dx
        node = np.broadcast_to(shapes.node_of_dof[basis.element_dofs[local]][:, None], shape)
        used = np.abs(value.ravel()) > 1.0e-14 * basis.dx.max()
        rows.append(node.ravel()[used])
        columns.append(column[used])
        entries.append(value.ravel()[used])
    matrix = csr_matrix(
        (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))),
        shape=(basis.N, basis.dx.size),
    )
    matrix.sort_indices()
    return matrix
