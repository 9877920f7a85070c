"""Which Jacobian the volumetric energy sees: each particle's own, or a smoothed one."""

from __future__ import annotations

from dataclasses import dataclass

from sphsolid.errors import require
from sphsolid.protocols import one_of
from sphsolid.scenes.checks import number
from sphsolid.scheme.filtered_dilatation import FilteredDilatationTerm
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.term import TermOption, check_term_option


@dataclass(frozen=True)
class OwnDilatation(TermOption):
    """``U(J_a)``: the law as it is, at every particle."""

    @property
    def name(self) -> str:
        """``own``."""
        return "own"

    def terms(self, set_up: SetUp) -> tuple[()]:
        """None."""
        return ()


@dataclass(frozen=True)
class FilteredDilatation(TermOption):
    """``U((S J)_a)``: the volumetric energy sees a smoothed Jacobian, as a potential.

        E = sum V [W(F, H, J) - U(J) + U(S J) + k (J - S J)^2 / 2]

    ``S`` keeps constants and is symmetric in the volumes; the pressure that acts is
    ``p~ = S U'(S J) + k (I - S)^2 J`` [Pa].  A particle's own ``J`` may wander from its
    neighbours', ``S J`` carries the pressure (see ``filtered_dilatation``).

    On a box lattice ``S`` acts along the lines, on any other cloud it is a mean over those within
    ``width`` spacings that a particle sees.  ``order=1`` keeps constants; long waves of pressure
    are then too slow by ``O(h^2)``, and much so near incompressibility.  ``order=2`` keeps linear
    functions, and along lines of eight particles or more quadratic ones, at the boundary too.
    What ``S`` takes out may be held by ``k = beta mu^2 / kappa``,
    at most ``kappa``.  Raises ``InputError``.
    """

    order: int = 2
    width: float = 2.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        order = one_of("FilteredDilatation: order", self.order, (1, 2))
        object.__setattr__(self, "order", order)
        for name, unit in (("width", "spacings"), ("beta", "mu^2/kappa")):
            value = number(f"FilteredDilatation: {name}", getattr(self, name), unit)
            object.__setattr__(self, name, value)
        require(
            1.0 < self.width <= WIDEST,
            f"FilteredDilatation: width = {self.width:g} spacings must be more than 1, or a "
            f"particle has no neighbours, and at most {WIDEST:g}",
        )
        require(
            self.beta >= 0.0, f"FilteredDilatation: beta = {self.beta:g} must not be negative"
        )

    @property
    def name(self) -> str:
        """``filtered``."""
        return "filtered"

    def terms(self, set_up: SetUp) -> tuple[FilteredDilatationTerm]:
        """One, with the filter of the cloud."""
        return (FilteredDilatationTerm(self, set_up),)


#: Widest reach in spacings: beyond, nothing is local.
WIDEST = 4.0
#: What says which Jacobian counts: one of these, or a user's own term option.
Dilatation = TermOption


def check_dilatation(formulation: Formulation, dilatation: TermOption) -> None:
    """Raise ``InputError`` unless the option is one and fits the formulation."""
    check_term_option("dilatation", dilatation, "use OwnDilatation() or FilteredDilatation()")
    dilatation.check(formulation)
