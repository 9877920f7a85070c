"""How the fibre map starts: from the discrete geometry or from what the scene states.

The two differ by the truncation error of the gradient, ``O(dx)`` at the boundary.  Where force
and gradient are adjoint the compatible start keeps ``F = F_x`` for good (no stored energy without
a displacement) and gives stress slopes near two instead of 1.6.  Where they are not adjoint, the
stated strain is the more accurate start.  On a disordered cloud the difference is rough, inside
too; the equilibrated start takes its force away and leaves ``F`` compatible.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.tensor import determinant, split
from sphsolid.errors import InputError
from sphsolid.protocols import check_protocol
from sphsolid.scenes.scene import Scene
from sphsolid.scheme.equilibrium import equilibrated
from sphsolid.scheme.right_hand_side import RightHandSide

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Start:
    """What a start is made from; ``x (N, 3)`` [m] are the positions that the scene states."""

    scene: Scene
    rhs: RightHandSide
    x: Array

    def stated(self) -> Array:
        """``F^0 (N, 3, 3)`` of the scene; raises ``InputError`` where it is inside out."""
        F = self.scene.stated_deformation(self.rhs.set_up.cloud.X)
        self.check(F)
        return F

    def check(self, F: Array) -> None:
        """Raise ``InputError`` where ``F (N, 3, 3)`` is inside out or not finite."""
        X = self.rhs.set_up.cloud.X
        detF = np.asarray(determinant(split(F)))
        invalid = np.flatnonzero(~(detF > 0.0))
        if len(invalid):
            a = int(invalid[0])
            if np.array_equal(self.x, X) and not self.scene.states_deformation:
                raise InputError(
                    f"operator {self.rhs.set_up.cloud.kind.name}: det F = {detF[a]:.3g} of the "
                    f"undeformed body at particle {a}, X = {X[a].tolist()} m; its gradient must "
                    "give F = I there: sum_b G_b = 0 and sum_b X_b (x) G_b = I"
                )
            raise InputError(
                f"scene {self.scene.name!r}: the initial state is inside out or not finite at "
                f"{len(invalid)} of {len(X)} particles, the first {a} at X = "
                f"{X[a].tolist()} m (det F = {detF[a]:.3g}); reduce the initial "
                "displacement or correct the initial deformation gradient"
            )


class InitialStrain(Protocol):
    """How ``F`` starts."""

    #: It uses the strain that the scene states.
    uses_stated: ClassVar[bool]

    def check(self, *, stated: bool, evolves_F: bool, adjoint: bool) -> None:
        """Raise ``InputError`` where it cannot work."""
        ...

    def start(self, start: Start, F: Array) -> Array:
        """Fill ``F (N, 3, 3)`` and hand out the positions ``(N, 3)`` [m] to start from."""
        ...


@dataclass(frozen=True)
class Compatible:
    """``F^0 = F_x(x^0) = sum_b x_b^0 (x) G_b``."""

    uses_stated: ClassVar[bool] = False

    def check(self, *, stated: bool, evolves_F: bool, adjoint: bool) -> None:
        """Always possible."""

    def start(self, start: Start, F: Array) -> Array:
        """Of the stated positions."""
        start.rhs.deformation_gradient(start.x, F)
        return start.x


@dataclass(frozen=True)
class Given:
    """``F^0`` as the scene states it (``initial_deformation_gradient``)."""

    uses_stated: ClassVar[bool] = True

    def check(self, *, stated: bool, evolves_F: bool, adjoint: bool) -> None:
        """Needs a stated strain and a formulation that evolves ``F``."""
        if not (stated and evolves_F):
            raise InputError(
                "initial_strain = Given() needs a scene that states its "
                "initial_deformation_gradient and a formulation that evolves F; "
                "use Compatible()"
            )

    def start(self, start: Start, F: Array) -> Array:
        """As stated."""
        F[:] = start.stated()
        return start.x


@dataclass(frozen=True)
class Equilibrated:
    """Compatible, at positions moved by ``O(dx^2)`` to where the stated strain's force acts.

    See ``equilibrium``: on a disordered cloud nothing else keeps the truncation error of the stated
    displacement from setting off waves.
    """

    uses_stated: ClassVar[bool] = True

    def check(self, *, stated: bool, evolves_F: bool, adjoint: bool) -> None:
        """Needs a stated strain and an adjoint operator."""
        if not (stated and adjoint):
            raise InputError(
                "initial_strain = Equilibrated() needs a scene that states its "
                "initial_deformation_gradient and an operator whose force and gradient are "
                "adjoint; use Compatible()"
            )

    def start(self, start: Start, F: Array) -> Array:
        """Of the moved positions."""
        start.rhs.deformation_gradient(start.x, F)
        start.check(F)
        x = equilibrated(start.rhs, start.x, start.stated())
        start.rhs.deformation_gradient(x, F)
        return x


def check_initial_strain(strain: object) -> None:
    """Raise ``InputError`` unless ``strain`` keeps the protocol."""
    check_protocol(
        "initial_strain", strain, ("uses_stated", "check", "start"),
        "use one of Compatible(), Given(), Equilibrated()",
    )
