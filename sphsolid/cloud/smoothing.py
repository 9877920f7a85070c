"""Smoothing functions ``W(r, h)`` in three dimensions, normalised to integral one.

``q = r / h``.  The *support radius* is ``support * h``: two smoothing lengths for the cubic
spline and Wendland's C2, three for the quintic spline, so equal ``h`` does not mean equal reach.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.protocols import check_protocol

Array = NDArray[np.float64]


class SmoothingFunction(Protocol):
    """A radial function of compact support."""

    @property
    def support(self) -> float:
        """Support radius divided by ``h``."""
        ...

    def value(self, r: Array, h: float | Array) -> Array:
        """``W(r, h)`` [1/m^3]."""
        ...

    def slope(self, r: Array, h: float | Array) -> Array:
        """``dW/dr (r, h)`` [1/m^4]."""
        ...


@dataclass(frozen=True)
class CubicSpline:
    """``W = (1 - 3/2 q^2 + 3/4 q^3) / (pi h^3)`` to ``q = 1``, ``(2 - q)^3 / (4 pi h^3)`` to 2.

    [Monaghan1985].  C2, positive.
    """

    support: ClassVar[float] = 2.0

    def value(self, r: Array, h: float | Array) -> Array:
        """``W(r, h)`` [1/m^3]."""
        q = r / h
        inner = 1.0 - 1.5 * q**2 + 0.75 * q**3
        outer = 0.25 * np.maximum(2.0 - q, 0.0) ** 3
        return np.where(q < 1.0, inner, outer) / (np.pi * h**3)

    def slope(self, r: Array, h: float | Array) -> Array:
        """``dW/dr (r, h)`` [1/m^4]."""
        q = r / h
        inner = -3.0 * q + 2.25 * q**2
        outer = -0.75 * np.maximum(2.0 - q, 0.0) ** 2
        return np.where(q < 1.0, inner, outer) / (np.pi * h**4)


@dataclass(frozen=True)
class QuinticSpline:
    """``W = [(3-q)^5 - 6 (2-q)^5 + 15 (1-q)^5] / (120 pi h^3)``, each bracket cut off at zero.

    [Morris1997].  C4, positive.
    """

    support: ClassVar[float] = 3.0

    def value(self, r: Array, h: float | Array) -> Array:
        """``W(r, h)`` [1/m^3]."""
        q = r / h
        a, b, c = (np.maximum(k - q, 0.0) for k in (3.0, 2.0, 1.0))
        return (a**5 - 6.0 * b**5 + 15.0 * c**5) / (120.0 * np.pi * h**3)

    def slope(self, r: Array, h: float | Array) -> Array:
        """``dW/dr (r, h)`` [1/m^4]."""
        q = r / h
        a, b, c = (np.maximum(k - q, 0.0) for k in (3.0, 2.0, 1.0))
        return -5.0 * (a**4 - 6.0 * b**4 + 15.0 * c**4) / (120.0 * np.pi * h**4)


@dataclass(frozen=True)
class WendlandC2:
    """``W = 21 / (16 pi h^3) (1 - q/2)^4 (1 + 2 q)`` to ``q = 2``.

    [Wendland1995].  C2, positive, positive Fourier transform (no pairing instability).
    """

    support: ClassVar[float] = 2.0

    def value(self, r: Array, h: float | Array) -> Array:
        """``W(r, h)`` [1/m^3]."""
        q = r / h
        return 21.0 / (16.0 * np.pi * h**3) * np.maximum(1.0 - 0.5 * q, 0.0) ** 4 * (1.0 + 2.0 * q)

    def slope(self, r: Array, h: float | Array) -> Array:
        """``dW/dr (r, h)`` [1/m^4]."""
        q = r / h
        return -21.0 / (16.0 * np.pi * h**4) * 5.0 * q * np.maximum(1.0 - 0.5 * q, 0.0) ** 3


def check_smoothing(smoothing: object) -> None:
    """Raise ``InputError`` unless ``smoothing`` keeps the protocol."""
    check_protocol(
        "smoothing", smoothing, ("support", "value", "slope"),
        "it is no smoothing function: use one of WendlandC2(), CubicSpline(), QuinticSpline()",
    )
