"""Which Jacobian the volumetric energy sees: each particle's own, or a smoothed one."""

from __future__ import annotations

from dataclasses import dataclass

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


#: What says which Jacobian counts: one of these, or a user's own term option.
Dilatation = TermOption


def check_dilatation(formulation: Formulation, dilatation: TermOption) -> None:
    """Raise ``InputError`` unless the option is one and fits the formulation."""
    check_term_option("dilatation", dilatation, "use OwnDilatation()")
    dilatation.check(formulation)
