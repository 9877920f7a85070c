"""The fields of a run by name: what the formulation and the terms declare, and nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal as OneOf
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import require
from sphsolid.fields import as_field, components, scalar_field, tensor_field, vector_field

Array = NDArray[np.float64]
Kind = OneOf["scalar", "vector", "tensor"]


@dataclass(frozen=True)
class Field:
    """A field of the particles: its name, and ``(N,)``, ``(N, 3)`` or ``(N, 3, 3)`` numbers.

    ``evolved``: it has a rate and a time integrator advances it.  Otherwise something else sets it,
    as the geometry does with ``x`` and, in some formulations, with ``F``.
    """

    name: str
    kind: Kind = "scalar"
    evolved: bool = True

    def __post_init__(self) -> None:
        """Refuse a name that is none and an unknown kind."""
        require(
            isinstance(self.name, str) and self.name.isidentifier(),
            f"Field: name = {self.name!r} must be a word of letters, digits and _",
        )
        require(
            self.kind in get_args(Kind),
            f"Field({self.name!r}): kind = {self.kind!r} is not one of {', '.join(get_args(Kind))}",
        )


class Rows(NamedTuple):
    """Fields as a kernel wants them: component-major rows, zero-length where there is none."""

    p: Array
    F: Array
    H: Array
    J: Array


class _Named:
    """A field as an attribute: reading hands out the array, assigning writes into it."""

    def __init__(self, *shape: int) -> None:
        self._absent = np.zeros((0, *shape))

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, state: State, owner: type) -> Array:
        return state.get(self._name, self._absent)

    def __set__(self, state: State, value: Array) -> None:
        # Others hold the array, so it is never another one.
        field = self.__get__(state, type(state))
        if value is not field:
            field[...] = value


class State(Mapping[str, Array]):
    """Arrays by name; ``state.F`` is short for ``state["F"]``.

    ``p (N, 3)`` [kg/(m^2 s)] and ``x (N, 3)`` [m] are always there, and so is ``F (N, 3, 3)``:
    evolved, or taken from the geometry before each use.  ``H (N, 3, 3)`` and ``J (N,)`` are there
    where the formulation evolves them; otherwise the attribute has zero length.
    """

    p = _Named(3)
    x = _Named(3)
    F = _Named(3, 3)
    H = _Named(3, 3)
    J = _Named()

    def __init__(self, **fields: Array) -> None:
        self._fields = fields

    @classmethod
    def zeros(cls, fields: Iterable[Field], size: int, *, particle_major: bool) -> State:
        """Zeros for ``size`` particles; ``particle_major`` says how tensors lie in memory.

        Raises ``InputError`` where two fields have one name.
        """
        made: dict[str, Array] = {}
        for field in fields:
            require(field.name not in made, f"two fields are called {field.name!r}; rename one")
            made[field.name] = zeros_of(field, size, particle_major=particle_major)
        return cls(**made)

    def __getitem__(self, name: str) -> Array:
        return self._fields[name]

    def __setitem__(self, name: str, value: Array) -> None:
        # As with attributes: state["T"] += ... writes into the array that others hold.
        field = self._fields[name]
        if value is not field:
            field[...] = value

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def but(self, **fields: Array) -> State:
        """The same arrays but for those given."""
        return State(**{**self._fields, **fields})

    def rows(self) -> Rows:
        """``p, F, H, J`` as a kernel wants them."""
        F = as_field(self.F)
        none = tensor_field(0, particle_major=components(F).ndim == 3)
        H = as_field(self._fields["H"]) if "H" in self._fields else none
        J = as_field(self._fields["J"]) if "J" in self._fields else scalar_field(0)
        return Rows(*(components(field) for field in (as_field(self.p), F, H, J)))


def zeros_of(field: Field, size: int, *, particle_major: bool) -> Array:
    """Zeros of one field, laid out as kernels want them."""
    if field.kind == "tensor":
        return tensor_field(size, particle_major=particle_major)
    return vector_field(size) if field.kind == "vector" else scalar_field(size)
