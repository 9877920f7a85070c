"""Counting arithmetic: numbers that count what is done with them.

The 3x3 algebra and the material laws are plain functions of numbers, so calling them with these
counts their additions, multiplications and divisions exactly, whatever the law.
"""

from __future__ import annotations

from typing import Any

from sphsolid.continuum import law
from sphsolid.continuum.tensor import Tensor, cofactor, contract, determinant
from sphsolid.scheme.projection import project

#: Multiplications, additions and the like of ``inverse_root`` and of a smallest stretch.
_NEWTON_ROOT, _STRETCH = 22, 110


class Counted:
    """A number that adds to ``Counted.operations`` whenever it is used."""

    operations = 0

    def _count(self, other: Any = None) -> Counted:
        Counted.operations += 1
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _count
    __truediv__ = __rtruediv__ = __neg__ = _count

    def __pow__(self, exponent: float) -> Counted:
        Counted.operations += _NEWTON_ROOT
        return self


def _tensor() -> Tensor:
    return tuple(Counted() for _ in range(9))  # type: ignore[return-value]


def operations(function: Any, *arguments: Any) -> int:
    """Operations of one call."""
    before = Counted.operations
    function(*arguments)
    return Counted.operations - before


def stress_operations(material: Any, *, has_H: bool, has_J: bool) -> int:
    """Of ``P(F, H, J)`` for one particle, ``H`` and ``J`` from ``F`` where not evolved."""
    total = operations(law.first_piola, material, _tensor(), _tensor(), Counted())
    total += 0 if has_H else operations(cofactor, _tensor())
    return total + (0 if has_J else operations(determinant, _tensor()))


def projection_operations() -> int:
    """Of one projection, eq. (40)."""
    return operations(project, _tensor(), _tensor())


def contraction_operations() -> int:
    """Of ``H : L``."""
    return operations(contract, _tensor(), _tensor())


def stretch_operations() -> int:
    """Of the smallest stretch that limits the step, square roots counted as one."""
    return _STRETCH
