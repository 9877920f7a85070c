"""SUPG stabilisation at the secondary particles, [Lee2017] sections 3.1 and 4.2, as options.

An intrinsic time is one of the mesh, ``OfMesh(c)``, or of the step, ``OfStep(c)``: see
``scheme.intrinsic_time``.  A plain number is one of the step: ``tau_F = 1`` means ``tau_F = dt``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sphsolid.cloud.secondary import H1, SecondaryPoints
from sphsolid.errors import InputError
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.intrinsic_time import IntrinsicTime, OfStep, Times, Units, as_time, checked

#: ``tau = dt`` of [Lee2017], and none.
ONE_STEP, NO_TIME = OfStep(1.0), OfStep(0.0)


def _check_coefficients(owner: object, *names: str) -> None:
    """Raise ``InputError`` unless each named attribute is ``None`` or finite and >= 0."""
    for name in names:
        value = getattr(owner, name)
        if value is not None:
            checked(value, f"{type(owner).__name__}: {name}")


def _take_times(owner: object, *names: str) -> None:
    """Make each named attribute an intrinsic time; raises ``InputError`` as ``as_time`` does."""
    for name in names:
        time = as_time(getattr(owner, name), f"{type(owner).__name__}: {name}")
        object.__setattr__(owner, name, time)


@dataclass(frozen=True)
class SimplifiedHessian:
    """Eq. (27): ``P_fine = tau_F gamma R_F + xi_F alpha R_F^x``.

    ``gamma`` [Pa] defaults to the bulk modulus, ``alpha`` [Pa] to the shear modulus.
    """

    gamma: float | None = None
    alpha: float | None = None

    def __post_init__(self) -> None:
        _check_coefficients(self, "gamma", "alpha")

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

    tau_H: IntrinsicTime | float = NO_TIME
    tau_J: IntrinsicTime | float = NO_TIME
    alpha: float | None = None

    def __post_init__(self) -> None:
        _take_times(self, "tau_H", "tau_J")
        _check_coefficients(self, "alpha")


@dataclass(frozen=True)
class StabilisedStrains:
    """Eq. (28), variational multi-scale: ``P_fine = P(F_st, H_st, J_st) - P(F, H, J)``.

    ``F_st = F + tau_F R_F + xi_F R_F^x`` and likewise for ``H`` and ``J``.
    """

    tau_H: IntrinsicTime | float = NO_TIME
    tau_J: IntrinsicTime | float = NO_TIME
    xi_H: float = 0.0
    xi_J: float = 0.0

    def __post_init__(self) -> None:
        _take_times(self, "tau_H", "tau_J")
        _check_coefficients(self, "xi_H", "xi_J")


FineScale = SimplifiedHessian | FullHessian | StabilisedStrains


@dataclass(frozen=True)
class AsPrinted:
    """Eq. (34): the fine stress is tested with ``G_a(X_q)`` alone, so ``v . D(p)`` has no sign."""


@dataclass(frozen=True)
class SelfAdjoint:
    """Test with what made the residual: ``D(p) = -V^-1 R^T V_q P_fine``, ``R = G_q - W~ G``.

    ``R`` maps velocities to the residual ``R_F``, so the power of ``D(p)`` is
    ``-sum V_q tau gamma |R_F|^2`` whatever ``tau_F`` is: the term cannot make energy.  Its second
    part is a stress ``B_a = sum_q (V_q / V_a) V_a W~_a(X_q) P_fine(X_q)``, taken from ``P_a``
    before the one internal-force pass; both ``Fdot`` and ``B`` are projected like stresses, which
    keeps angular momentum and the sign of the power exact.  Costs a pass and a projection more.
    Not in [Lee2017]; the orthogonal-subscale idea of [Codina2000].
    """


Weighting = AsPrinted | SelfAdjoint


@dataclass(frozen=True)
class NoStabilisation:
    """Bubnov-Galerkin alone: no secondary particles are made."""

    @property
    def name(self) -> str:
        """``none``."""
        return "none"

    def check(self, formulation: Formulation) -> None:
        """Every formulation runs without stabilisation."""


@dataclass(frozen=True)
class SUPG:
    """Streamline-upwind Petrov-Galerkin terms ``D(p)`` and ``D(J)``.

    ``tau_F`` damps what the velocity gradient at ``q`` has beyond the interpolated rate of ``F``,
    ``xi_F`` (in [0, 0.5] in the paper) what the geometry has beyond ``F``, ``tau_p`` damps
    pressure modes through the law of ``J``.  ``tau_F, tau_p`` are ``OfMesh(c)``, ``OfStep(c)`` or a
    number, which is one of the step.  ``secondary`` places the particles ``q``; ``weighting`` says
    how ``D(p)`` is tested.
    """

    tau_F: IntrinsicTime | float = ONE_STEP
    xi_F: float = 0.1
    tau_p: IntrinsicTime | float = NO_TIME
    secondary: SecondaryPoints = field(default_factory=H1)
    fine_scale: FineScale = field(default_factory=SimplifiedHessian)
    weighting: Weighting = field(default_factory=AsPrinted)

    def __post_init__(self) -> None:
        _take_times(self, "tau_F", "tau_p")
        _check_coefficients(self, "xi_F")
        if isinstance(self.secondary, type) or not hasattr(self.secondary, "place"):
            raise InputError(
                f"SUPG: secondary = {self.secondary!r} is unknown; use H1() or H6() on "
                "hexahedra, Agglomerated() or T1() on tetrahedra and points"
            )
        if not isinstance(self.fine_scale, FineScale):
            raise InputError(
                f"SUPG: fine_scale = {self.fine_scale!r} is unknown; use SimplifiedHessian(), "
                "FullHessian() or StabilisedStrains()"
            )
        if not isinstance(self.weighting, Weighting):
            raise InputError(
                f"SUPG: weighting = {self.weighting!r} is unknown; use AsPrinted() or SelfAdjoint()"
            )
        if self.is_self_adjoint and not isinstance(self.fine_scale, SimplifiedHessian):
            raise InputError(
                "SUPG: weighting = SelfAdjoint() needs fine_scale = SimplifiedHessian(); the other "
                "forms have no adjoint of their own"
            )
        own = [getattr(self.fine_scale, name, 0.0) for name in ("xi_H", "xi_J")]
        own += [time.c for time in self.intrinsic_times.values()]
        if self.xi_F == 0.0 and not any(own):
            raise InputError(
                "SUPG with tau_F = xi_F = tau_p = 0 does nothing; use NoStabilisation()"
            )

    @property
    def name(self) -> str:
        """``SUPG-H1`` or ``SUPG-H6``."""
        return f"SUPG-{self.secondary.name}"

    @property
    def is_self_adjoint(self) -> bool:
        """True when ``D(p)`` is tested with the operator that made its residual."""
        return isinstance(self.weighting, SelfAdjoint)

    @property
    def damps_J(self) -> bool:
        """True when there is a ``D(J)``."""
        return as_time(self.tau_p).c > 0.0

    @property
    def intrinsic_times(self) -> dict[str, IntrinsicTime]:
        """``tau_F, tau_p, tau_H, tau_J`` by name; zero where the fine scale has no such time."""
        own = {name: getattr(self.fine_scale, name, 0.0) for name in ("tau_H", "tau_J")}
        given = {"tau_F": self.tau_F, "tau_p": self.tau_p} | own
        return {name: as_time(value, name) for name, value in given.items()}

    @property
    def follows_step(self) -> bool:
        """True when some time is one of the step."""
        times = self.intrinsic_times.values()
        return any(isinstance(time, OfStep) and time.c > 0.0 for time in times)

    def seconds(self, units: Units) -> Times:
        """All intrinsic times [s]."""
        return Times(*(time.seconds(units) for time in self.intrinsic_times.values()))

    def check(self, formulation: Formulation) -> None:
        """Refuse pairs that cannot work, saying what to use instead."""
        if self.damps_J and not formulation.evolves_J:
            raise InputError(
                f"SUPG(tau_p = {self.tau_p}) stabilises the law of J, which {formulation.name} "
                "does not solve; use PFJ() or PFHJ(), or tau_p = 0"
            )
        times = self.intrinsic_times
        tau_H = times["tau_H"].c or getattr(self.fine_scale, "xi_H", 0.0)
        if tau_H and not formulation.evolves_H:
            raise InputError(
                f"tau_H or xi_H > 0 needs the law of H, which {formulation.name} does not solve; "
                "use PFHJ()"
            )
        tau_J = times["tau_J"].c or getattr(self.fine_scale, "xi_J", 0.0)
        if tau_J and not formulation.evolves_J:
            raise InputError(
                f"tau_J or xi_J > 0 needs the law of J, which {formulation.name} does not solve; "
                "use PFJ() or PFHJ()"
            )


Stabilisation = NoStabilisation | SUPG


def check_formulation(formulation: object) -> None:
    """Raise ``InputError`` unless it is a formulation."""
    if not isinstance(formulation, Formulation):
        raise InputError(
            f"formulation = {formulation!r} is unknown; use PF(), PFJ(), PFHJ(), PJ() or "
            "Displacement()"
        )


def check_pair(formulation: Formulation, stabilisation: object) -> None:
    """Raise ``InputError`` unless the stabilisation is known and fits the formulation."""
    if not isinstance(stabilisation, NoStabilisation | SUPG):
        raise InputError(
            f"stabilisation = {stabilisation!r} is unknown; use SUPG(...) or NoStabilisation()"
        )
    stabilisation.check(formulation)
