"""Fields of particles, laid out for the loops that read them.

A vector field is seen as ``(N, 3)`` and a tensor field as ``(N, 3, 3)``, however it lies in memory.

* *Component-major*: one row of memory for every component, so that a loop over consecutive
  particles reads whole vector registers.  All vectors and scalars, and the tensors of clouds on
  which stencils serve.  Rows are longer than ``N``: a whole number of tiles of ``LANES`` particles
  and some more, because loops run over whole tiles and registers, and never a multiple of 4096
  bytes apart, because rows that far apart evict one another from the cache.
* *Particle-major*: the nine components of a particle together, so that a sum over scattered
  neighbours fetches one or two cache lines a neighbour, not nine.  The tensors of other clouds.

:func:`components` gives a kernel the memory itself: ``(components, .)`` or ``(., 3, 3)``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Particles that one tile of a kernel works on at once (their 64 rows of scratch fit the cache).
LANES = 64
#: Loops over a part of a tile run over a multiple of this many lanes.
GRAIN = 16


def leading(size: int) -> int:
    """Length of a row that holds ``size`` particles."""
    if size == 0:
        return 0
    length = -(-(size + GRAIN) // LANES) * LANES
    return length + LANES if length % 512 == 0 else length


def _rows(count: int, size: int) -> Array:
    return np.zeros((count, leading(size)))


def scalar_field(size: int) -> Array:
    """Zeros ``(N,)``."""
    return _rows(1, size)[0, :size]


def vector_field(size: int) -> Array:
    """Zeros, seen as ``(N, 3)``."""
    return _rows(3, size)[:, :size].T


def tensor_field(size: int, *, particle_major: bool = False) -> Array:
    """Zeros, seen as ``(N, 3, 3)``."""
    if particle_major:
        return np.zeros((leading(size), 3, 3))[:size]
    return _rows(9, size).reshape(3, 3, -1)[:, :, :size].transpose(2, 0, 1)


def _is_field(field: Array) -> bool:
    # Asked for every array of every kernel of a step, so nothing is made here that is not needed.
    base = field.base
    if not isinstance(base, np.ndarray) or not base.flags.c_contiguous:
        return False
    row = leading(len(field))
    return base.shape in ((math.prod(field.shape[1:]), row), (row, 3, 3)) and (
        _address(field) == _address(base)
    )


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def components(field: Array) -> Array:
    """Memory of a field made by this module, padding included; writing changes the field.

    Raises ``TypeError`` for any other array.
    """
    if not _is_field(field):
        raise TypeError(f"an array of shape {field.shape} is not a field: see sphsolid.fields")
    base: Any = field.base
    return base


def as_field(array: Array) -> Array:
    """``array`` itself if it is a field, else a component-major copy."""
    if _is_field(array):
        return array
    make = {1: scalar_field, 2: vector_field, 3: tensor_field}[array.ndim]
    copy = make(len(array))
    copy[:] = array
    return copy
