"""One number a point of any field: its size, a component, or itself."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError, nearest
from sphsolid.geometry.mesh import Mesh
from sphsolid.look.cell_means import cell_means_at_vertices
from sphsolid.record.snapshot import HasFurther, PointField, at_vertices

Array = NDArray[np.float64]
#: Before the name of a field: its means over cells, carried to the vertices.
CELL = "cell_"
SCALARS, VECTORS, TENSORS = ("pressure", "von_mises", "J"), ("u", "v", "p"), ("cauchy", "P", "F")
_COMPONENT = re.compile(r"(u|v|p)_([xyz])|(cauchy|P|F)_([xyz])([xyz])")


@dataclass(frozen=True)
class Scalar:
    """What to take of the field ``base``: all of it (``index`` empty), a component, or ``|.|``."""

    base: str
    index: tuple[int, ...] = ()
    is_size: bool = False

    def of(self, values: Array) -> Array:
        """``(n, ...) -> (n,)``."""
        if self.is_size:
            return np.asarray(np.linalg.norm(values, axis=1))
        taken: Array = values
        # The last axis first: what is left has one number a point.
        for place in reversed(self.index):
            taken = taken[..., place]
        return taken

    @property
    def is_of_law(self) -> bool:
        """Whether it stands where the method evaluates the law, perhaps in cells."""
        return self.base not in VECTORS


#: The fields of a snapshot beside those that every one has: none.
NONE_FURTHER: Mapping[str, Array] = MappingProxyType({})


def scalar(name: str, further: Mapping[str, Array] = NONE_FURTHER) -> Scalar:
    """What ``name`` stands for; raises ``InputError`` with the names there are.

    ``further`` are fields of a user's own terms ``(n, ...)`` by name.
    """
    for base, values in further.items():
        axes = values.ndim - 1
        if name == base and axes < 2:
            return Scalar(name, is_size=axes == 1)
        if name.startswith(f"{base}_") and re.fullmatch(f"[xyz]{{{axes}}}", name[len(base) + 1 :]):
            return Scalar(base, tuple(map("xyz".index, name[len(base) + 1 :])))
    if name in SCALARS:
        return Scalar(name)
    if name in VECTORS:
        return Scalar(name, is_size=True)
    if found := _COMPONENT.fullmatch(name):
        base = found[1] or found[3]
        return Scalar(base, tuple("xyz".index(axis) for axis in found.groups()[1:] if axis in
                                  ("x", "y", "z")))  # fmt: skip
    known = [*SCALARS, *VECTORS, *further]
    hint = nearest(name, [*known, "u_x", "v_x", "p_x", "cauchy_xx", "P_xx", "F_xx"])
    raise InputError(
        f"there is no picture of a field {name!r}{hint}; choose one of {', '.join(known)} (of "
        "vectors the size), or a component such as u_x, cauchy_xy, P_zz, F_xx"
    )


@dataclass(frozen=True)
class _Reduced:
    """A snapshot whose only field is one number a point."""

    snapshot: Any
    what: Scalar

    @property
    def mesh(self) -> Mesh:
        mesh: Mesh = self.snapshot.mesh
        return mesh

    @property
    def X(self) -> Array:
        return np.asarray(self.snapshot.X)

    def field(self, name: str) -> PointField:
        found = self.snapshot.field(self.what.base)
        return PointField(found.X, found.V, self.what.of(found.values))


def values_at_vertices(snapshot: HasFurther, name: str) -> Array:
    """``name`` at the vertices ``(N,)``; with :data:`CELL` before it, means over cells."""
    reduced = _Reduced(snapshot, scalar(name.removeprefix(CELL), snapshot.further))
    if name.startswith(CELL):
        return cell_means_at_vertices(reduced, name)
    return at_vertices(reduced, name)
