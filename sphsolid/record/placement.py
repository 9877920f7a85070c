"""Where a body is, and nothing else: what its positions are judged by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.geometry.mesh import Mesh, read_only

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SecondaryGradient:
    """Gradient of the positions at points that are no particles.

    ``F = sum_a x_a (x) G_a(X_q) (Q, 3, 3)`` [-] at secondary particles ``X (Q, 3)`` [m].
    """

    X: Array
    F: Array

    def __post_init__(self) -> None:
        """Views that cannot be written to: every recorder of an instant gets the same object."""
        object.__setattr__(self, "X", read_only(self.X))
        object.__setattr__(self, "F", read_only(self.F))


@dataclass(frozen=True)
class NoSecondaryGradient:
    """The method has no secondary particles."""


NO_SECONDARY_GRADIENT = NoSecondaryGradient()


class Placed(Protocol):
    """A ``Placement``, or a ``Snapshot``, which has more."""

    @property
    def time(self) -> float:
        """[s]."""
        ...

    @property
    def mesh(self) -> Mesh:
        """The undeformed mesh."""
        ...

    @property
    def x(self) -> Array:
        """Positions of its vertices ``(N, 3)`` [m]."""
        ...

    @property
    def secondary(self) -> SecondaryGradient | NoSecondaryGradient:
        """Their gradient at the secondary particles."""
        ...


@dataclass(frozen=True)
class Placement:
    """Positions ``x (N, 3)`` [m] of the vertices of ``mesh`` at ``time`` [s].

    Arrays may be the solver's own: they are read at once, and not kept.
    """

    time: float
    mesh: Mesh
    x: Array
    secondary: SecondaryGradient | NoSecondaryGradient = NO_SECONDARY_GRADIENT
