"""Jameson-Schmidt-Turkel dissipation of [Lee2016], which [Lee2017] compares with, as options.

    D(p) = c_p h (eps2 lap p - eps4 h^2 lap lap p) + correction
    D(J) = c_p h (eps2 lap J - eps4 h^2 lap lap J) - mean

``lap`` is blind to linear fields (see ``harmonic``).  The correction takes resultant and moment
out of everything that the body does to itself (``global_momenta``), and the mean keeps the volume.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal as OneOf

from sphsolid.errors import InputError, require
from sphsolid.protocols import check_protocol
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.jst_term import JSTTerm
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stabilisation import AsPrinted, Weighting
from sphsolid.scheme.term import TermOption

_USUAL = "[Lee2017] has eps_p2 = eps_J2 = 0, eps_p4 = 1/8 and eps_J4 = 0 or 1/32"


@dataclass(frozen=True)
class JST(TermOption):
    """Harmonic and biharmonic dissipation of ``p`` and of ``J``.

    ``eps_p2, eps_p4, eps_J2, eps_J4`` are the ``epsilon^(2), epsilon^(4)`` of [Lee2017], sections
    7.1 to 7.3: 0, 1/8, 0, and 1/32 on the punch or 0.  ``length`` is the ``h`` of the formulas:
    the ``"smoothing"`` length or the ``"spacing"`` of the particles.  Use it with ``h_over_dx`` of
    1 at least: a narrower support makes the biharmonic operator so stiff that it sets the step.

    ``weighting``: ``AsPrinted()`` applies ``lap`` twice, a form that is not definite at boundaries;
    ``SelfAdjoint()``, which is ours, tests with its transpose,
    ``-eps4 c_p h^3 V^-1 lap^T V lap p``, whose power is minus a square at any state.  It has no
    harmonic part.

    ``keeps_momenta``: linear and angular momentum by least squares over the whole body, of the
    internal force too where ``angular_momentum=NoProjection()``.  Loads are left alone.

    Raises ``InputError`` for coefficients that are negative, large or all zero, and for a ``J``
    that the formulation does not solve.
    """

    eps_p2: float = 0.0
    eps_p4: float = 0.125
    eps_J2: float = 0.0
    eps_J4: float = 0.0
    length: OneOf["smoothing", "spacing"] = "smoothing"
    weighting: Weighting = field(default_factory=AsPrinted)
    keeps_momenta: bool = True

    def __post_init__(self) -> None:
        for name, value in self.coefficients.items():
            require(
                isinstance(value, int | float)
                and not isinstance(value, bool)
                and 0.0 <= value <= 10.0,
                f"JST: {name} = {value!r} must be within [0, 10]: a negative one feeds energy into "
                f"the modes it should damp; {_USUAL}",
            )
        if not any(self.coefficients.values()):
            raise InputError(
                "JST with all coefficients zero does nothing; use NoStabilisation()"
            )
        require(
            self.length in ("smoothing", "spacing"),
            f"JST: length = {self.length!r} is not one of 'smoothing', 'spacing'",
        )
        require(
            isinstance(self.keeps_momenta, bool),
            f"JST: keeps_momenta = {self.keeps_momenta!r} must be True or False",
        )
        check_protocol(
            "JST: weighting", self.weighting, ("is_self_adjoint",),
            "use AsPrinted() or SelfAdjoint()",
        )
        if self.weighting.is_self_adjoint and (self.eps_p2 or self.eps_J2):
            raise InputError(
                "JST: no harmonic form is both definite and blind to affine motion; with "
                "weighting = SelfAdjoint() set eps_p2 = eps_J2 = 0, or use AsPrinted()"
            )

    @property
    def coefficients(self) -> dict[str, float]:
        """By name."""
        names = ("eps_p2", "eps_p4", "eps_J2", "eps_J4")
        return {name: getattr(self, name) for name in names}

    @property
    def damps_J(self) -> bool:
        """True when there is a ``D(J)``."""
        return self.eps_J2 > 0.0 or self.eps_J4 > 0.0

    @property
    def name(self) -> str:
        """``JST``."""
        return "JST"

    def check(self, formulation: Formulation) -> None:
        """Refuse a ``D(J)`` where ``J`` is not solved for."""
        if self.damps_J and not formulation.evolves_J:
            raise InputError(
                f"JST(eps_J2 = {self.eps_J2:g}, eps_J4 = {self.eps_J4:g}) damps the law of J, "
                f"which {formulation.name} does not solve; use PFJ() or PFHJ(), or "
                "eps_J2 = eps_J4 = 0"
            )

    def terms(self, set_up: SetUp) -> tuple[JSTTerm]:
        """One term."""
        return (JSTTerm(self, set_up),)
