"""The fine-scale stress at the secondary particles, [Lee2017] section 4.2, as options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.scheme.fine_scale import Coefficients, Forms, Simplified
from sphsolid.scheme.intrinsic_time import IntrinsicTime, OfStep, Times, as_time, checked
from sphsolid.scheme.secondary_sums import SecondarySums
from sphsolid.scheme.stage import Stage

if TYPE_CHECKING:
    from sphsolid.scheme.stabilisation import SUPG

Array = NDArray[np.float64]
#: No intrinsic time.
NO_TIME = OfStep(0.0)


def check_coefficients(owner: object, *names: str) -> None:
    """Raise ``InputError`` unless each named attribute is ``None`` or finite and >= 0."""
    for name in names:
        value = getattr(owner, name)
        if value is not None:
            checked(value, f"{type(owner).__name__}: {name}")


def take_times(owner: object, *names: str) -> None:
    """Make each named attribute an intrinsic time; raises ``InputError`` as ``as_time`` does."""
    for name in names:
        time = as_time(getattr(owner, name), f"{type(owner).__name__}: {name}")
        object.__setattr__(owner, name, time)


@dataclass(frozen=True)
class Sampled:
    """What a fine-scale form works with: the sums of the secondary particles and a stage.

    ``times`` are the intrinsic times [s]; the stress goes into ``P_fine (M, 3, 3)`` and, where
    there is room, ``F_x`` into ``F_x (M, 3, 3)``.
    """

    sums: SecondarySums
    material: Any
    stage: Stage
    times: Times
    P_fine: Array
    F_x: Array


class FineScale(Protocol):
    """How the fine-scale stress is made of the residuals at the secondary particles."""

    #: It needs room for ``F_x`` even where nobody else reads it.
    writes_F_x: ClassVar[bool]
    #: ``SelfAdjoint`` can test with what made its residual.
    has_adjoint: ClassVar[bool]

    def fine_stress(self, at: Sampled, supg: SUPG) -> None:
        """Write ``P_fine``."""
        ...


@dataclass(frozen=True)
class SimplifiedHessian:
    """Eq. (27): ``P_fine = tau_F gamma R_F + xi_F alpha R_F^x``.

    ``gamma`` [Pa] defaults to the bulk modulus, ``alpha`` [Pa] to the shear modulus.
    """

    writes_F_x: ClassVar[bool] = False
    has_adjoint: ClassVar[bool] = True

    gamma: float | None = None
    alpha: float | None = None

    def __post_init__(self) -> None:
        check_coefficients(self, "gamma", "alpha")

    def fine_stress(self, at: Sampled, supg: SUPG) -> None:
        """Eq. (27)."""
        gamma, alpha = self.moduli(at.material)
        coefficients = Simplified(
            at.material.density, at.times.F * gamma, supg.xi_F * alpha, supg.damps_J
        )
        at.sums.simplified(at.stage, coefficients, at.P_fine, at.F_x)

    def moduli(self, material: Any) -> tuple[float, float]:
        """``gamma, alpha`` [Pa] for a material."""
        return (
            material.kappa if self.gamma is None else self.gamma,
            material.mu if self.alpha is None else self.alpha,
        )


@dataclass(frozen=True)
class FullHessian:
    """Eqs. (22)-(23): the fine-scale conjugate stresses by the Hessian of the energy.

    ``tau_H``, ``tau_J`` are intrinsic times; ``xi_F alpha R_F^x`` is kept as in (27).
    """

    writes_F_x: ClassVar[bool] = True
    has_adjoint: ClassVar[bool] = False

    tau_H: IntrinsicTime | float = NO_TIME
    tau_J: IntrinsicTime | float = NO_TIME
    alpha: float | None = None

    def __post_init__(self) -> None:
        take_times(self, "tau_H", "tau_J")
        check_coefficients(self, "alpha")

    def fine_stress(self, at: Sampled, supg: SUPG) -> None:
        """Eqs. (22)-(23)."""
        alpha = at.material.mu if self.alpha is None else self.alpha
        times = at.times
        given = Coefficients(times.F, times.H, times.J, supg.xi_F, 0.0, 0.0, alpha)
        forms = Forms(strains=False, projects=at.stage.projects)
        at.sums.general(at.material, at.stage, (forms, given), at.P_fine, at.F_x)


@dataclass(frozen=True)
class StabilisedStrains:
    """Eq. (28), variational multi-scale: ``P_fine = P(F_st, H_st, J_st) - P(F, H, J)``.

    ``F_st = F + tau_F R_F + xi_F R_F^x`` and likewise for ``H`` and ``J``.
    """

    writes_F_x: ClassVar[bool] = True
    has_adjoint: ClassVar[bool] = False

    tau_H: IntrinsicTime | float = NO_TIME
    tau_J: IntrinsicTime | float = NO_TIME
    xi_H: float = 0.0
    xi_J: float = 0.0

    def __post_init__(self) -> None:
        take_times(self, "tau_H", "tau_J")
        check_coefficients(self, "xi_H", "xi_J")

    def fine_stress(self, at: Sampled, supg: SUPG) -> None:
        """Eq. (28)."""
        times, xis = at.times, (supg.xi_F, self.xi_H, self.xi_J)
        given = Coefficients(times.F, times.H, times.J, *xis, at.material.mu)
        forms = Forms(strains=True, projects=at.stage.projects)
        at.sums.general(at.material, at.stage, (forms, given), at.P_fine, at.F_x)
