"""What is computed once for a mesh and kept as long as the mesh lives."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Generic, TypeVar

from sphsolid.geometry.mesh import Mesh

T = TypeVar("T")


class PerMesh(Generic[T]):
    """``make(mesh)``, once a mesh, which it does not own; by identity, as meshes have no hash."""

    def __init__(self, make: Callable[[Mesh], T]) -> None:
        self._make = make
        self._made: dict[int, tuple[weakref.ref[Mesh], T]] = {}

    def __call__(self, mesh: Mesh) -> T:
        """The same object for the same mesh."""
        number = id(mesh)
        known = self._made.get(number)
        if known is not None and known[0]() is mesh:
            return known[1]
        made = self._make(mesh)
        # The number may belong to another mesh once this one is gone.
        self._made[number] = weakref.ref(mesh, lambda _: self._made.pop(number, None)), made
        return made
