"""Which Jacobian the volumetric energy sees: each particle's own, or a smoothed one."""

from __future__ import annotations

from dataclasses import dataclass

from sphsolid.errors import InputError, require
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

        E = sum V [W(F, H, J) - U(J) + U(S J) + beta mu (J - S J)^2 / 2]

    ``S`` keeps constants and is symmetric in the volumes; the pressure that acts is
    ``p~ = S U'(S J) + beta mu (I - S)^2 J`` [Pa].  A particle's own ``J`` may wander from its
    neighbours', ``S J`` carries the pressure (see ``filtered_dilatation``).

    On a box lattice ``S`` acts along the lines, elsewhere among those within ``width`` spacings
    that a particle sees.  ``order=2`` keeps linear functions, the boundary included, and hardly
    touches long waves.  ``order=1`` keeps constants alone and takes more out ([Sinkhorn1967] on
    clouds): it also softens the p-waves of a nearly incompressible solid.  ``times`` says how often
    it is applied: None is once on a box lattice, twice elsewhere.  ``beta`` holds what ``S`` takes
    out; above ``kappa / mu`` it is refused.  Raises ``InputError``.
    """

    order: int = 2
    width: float = 1.6
    times: int | None = None
    beta: float = 0.0

    def __post_init__(self) -> None:
        if isinstance(self.order, bool) or self.order not in (1, 2):
            raise InputError(f"FilteredDilatation: order = {self.order!r} must be 1 or 2")
        if self.times is not None and (
            isinstance(self.times, bool) or self.times not in range(1, MOST_TIMES + 1)
        ):
            raise InputError(
                f"FilteredDilatation: times = {self.times!r} must be a whole number from 1 to "
                f"{MOST_TIMES}, or None for the usual one"
            )
        for name, unit in (("width", "spacings"), ("beta", "shear moduli")):
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


#: Most that a filter is applied, and its widest reach in spacings: beyond, nothing is local.
MOST_TIMES, WIDEST = 8, 4.0
#: What says which Jacobian counts: one of these, or a user's own term option.
Dilatation = TermOption


def check_dilatation(formulation: Formulation, dilatation: TermOption) -> None:
    """Raise ``InputError`` unless the option is one and fits the formulation."""
    check_term_option("dilatation", dilatation, "use OwnDilatation() or FilteredDilatation()")
    dilatation.check(formulation)
