"""SUPG stabilisation at the secondary particles, [Lee2017] sections 3.1 and 4.2, as options.

An intrinsic time is one of the mesh, ``OfMesh(c)``, or of the step, ``OfStep(c)``: see
``scheme.intrinsic_time``.  A plain number is one of the step: ``tau_F = 1`` means ``tau_F = dt``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Protocol

from sphsolid.cloud.secondary import H1, SecondaryPoints
from sphsolid.errors import InputError
from sphsolid.protocols import check_protocol
from sphsolid.scheme.fine_scale_forms import (
    NO_TIME,
    FineScale,
    FullHessian,
    SimplifiedHessian,
    StabilisedStrains,
    check_coefficients,
    take_times,
)
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.intrinsic_time import IntrinsicTime, OfStep, Times, Units, as_time
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.supg import SUPGTerm
from sphsolid.scheme.term import TermOption, check_term_option

__all__ = [
    "SUPG", "AsPrinted", "FineScale", "FullHessian", "NoStabilisation", "SelfAdjoint",
    "SimplifiedHessian", "Stabilisation", "StabilisedStrains", "Weighting", "check_formulation",
    "check_pair",
]  # fmt: skip

#: ``tau = dt`` of [Lee2017].
ONE_STEP = OfStep(1.0)


@dataclass(frozen=True)
class AsPrinted:
    """Eq. (34): the fine stress is tested with ``G_a(X_q)`` alone, so ``v . D(p)`` has no sign."""

    is_self_adjoint: ClassVar[bool] = False


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

    is_self_adjoint: ClassVar[bool] = True


class Weighting(Protocol):
    """How ``D(p)`` is tested."""

    is_self_adjoint: ClassVar[bool]


@dataclass(frozen=True)
class NoStabilisation(TermOption):
    """Bubnov-Galerkin alone: no secondary particles are made."""

    @property
    def name(self) -> str:
        """``none``."""
        return "none"

    def terms(self, set_up: SetUp) -> tuple[()]:
        """None."""
        return ()


@dataclass(frozen=True)
class SUPG(TermOption):
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
        take_times(self, "tau_F", "tau_p")
        check_coefficients(self, "xi_F")
        check_protocol(
            "SUPG: secondary", self.secondary, ("name", "place"),
            "use H1() or H6() on hexahedra, Agglomerated() or T1() on tetrahedra and points",
        )
        check_protocol(
            "SUPG: fine_scale", self.fine_scale, ("writes_F_x", "has_adjoint", "fine_stress"),
            "use SimplifiedHessian(), FullHessian() or StabilisedStrains()",
        )
        check_protocol(
            "SUPG: weighting", self.weighting, ("is_self_adjoint",),
            "use AsPrinted() or SelfAdjoint()",
        )
        if self.is_self_adjoint and not self.fine_scale.has_adjoint:
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
        return self.weighting.is_self_adjoint

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
        return any(time.follows_step for time in self.intrinsic_times.values())

    def seconds(self, units: Units) -> Times:
        """All intrinsic times [s]."""
        return Times(*(time.seconds(units) for time in self.intrinsic_times.values()))

    def terms(self, set_up: SetUp) -> tuple[SUPGTerm]:
        """One term, with secondary particles."""
        return (SUPGTerm(self, set_up),)

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


#: What stabilises: one of these, or a user's own that keeps the protocol of a term option.
Stabilisation = TermOption


def check_formulation(formulation: object) -> None:
    """Raise ``InputError`` unless it is a formulation."""
    check_protocol(
        "formulation", formulation, ("name", "fields", "evolves_F", "evolves_H", "evolves_J"),
        "use PF(), PFJ(), PFHJ(), PJ() or Displacement()",
    )


def check_pair(formulation: Formulation, stabilisation: TermOption) -> None:
    """Raise ``InputError`` unless the stabilisation is one and fits the formulation."""
    check_term_option("stabilisation", stabilisation, "use SUPG(...) or NoStabilisation()")
    stabilisation.check(formulation)
