"""Reference maps of the elements as the kernels take them: equal bricks, or any hexahedra.

With ``D = dx/dxi`` and ``A = dX/dxi`` at a Gauss point the deformation gradient is
``F = D A^-1 = D (cof A)^T / det A``, and the derivative of an energy ``w_g det A W(F)`` with
respect to ``D`` is ``w_g P cof A``.  Where all elements are the same brick ``A`` is diagonal and
constant: its inverse is put into ``D`` once.  Any other mesh forms ``A`` from the undeformed nodes
by the routine that forms ``D``, which is faster than reading nine stored numbers a point, and needs
no memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.compiled import overload
from sphsolid.continuum.tensor import cofactor, determinant, multiply, scale, transpose

Array = NDArray[np.float64]
#: Calls inside a loop over lanes must vanish before LLVM looks at the loop.
INLINED = {"forceinline": True}


class Bricks(NamedTuple):
    """``dxi_i/dX_i = along[i]`` [1/m] and ``weights (g,)`` [m^3] of every element; ``X`` empty."""

    along: Array
    weights: Array
    X: Array


class Hexahedra(NamedTuple):
    """``X (N, 3)`` [m] undeformed nodes; ``weights (g,)`` of the unit cube; ``along`` ones."""

    along: Array
    weights: Array
    X: Array


def hex_maps(edges: Array, weights: Array, X: Array) -> Bricks | Hexahedra:
    """``weights (g,)`` of the unit cube; ``edges`` of the one brick, or empty for any hexahedra."""
    if len(edges):
        return Bricks(1.0 / edges, weights * np.prod(edges), np.empty((0, 3)))
    return Hexahedra(np.ones(3), weights, np.ascontiguousarray(X))


def are_distorted(maps: Any) -> bool:
    """Known when a kernel is compiled."""
    return isinstance(maps, Hexahedra)


def pushed(maps: Any, D: Any, A: Any) -> Any:
    """``F = D A^-1``."""
    raise NotImplementedError("compiled only")


def pulled(maps: Any, share: Any, P: Any, A: Any) -> Any:
    """``share P cof A``: the adjoint of :func:`pushed`, weighted."""
    raise NotImplementedError("compiled only")


def volume(maps: Any, share: Any, A: Any) -> Any:
    """``share det A`` [m^3]."""
    raise NotImplementedError("compiled only")


def _bricks(maps: Any) -> bool:
    return maps.instance_class is Bricks


@overload(are_distorted, jit_options=INLINED)
def _are_distorted(maps):  # type: ignore[no-untyped-def]
    if _bricks(maps):
        return lambda maps: False
    return lambda maps: True


@overload(pushed, jit_options=INLINED)
def _pushed(maps, D, A):  # type: ignore[no-untyped-def]
    if _bricks(maps):
        return lambda maps, D, A: D
    return lambda maps, D, A: scale(1.0 / determinant(A), multiply(D, transpose(cofactor(A))))


@overload(pulled, jit_options=INLINED)
def _pulled(maps, share, P, A):  # type: ignore[no-untyped-def]
    if _bricks(maps):
        return lambda maps, share, P, A: scale(share, P)
    return lambda maps, share, P, A: scale(share, multiply(P, cofactor(A)))


@overload(volume, jit_options=INLINED)
def _volume(maps, share, A):  # type: ignore[no-untyped-def]
    if _bricks(maps):
        return lambda maps, share, A: share
    return lambda maps, share, A: share * determinant(A)
