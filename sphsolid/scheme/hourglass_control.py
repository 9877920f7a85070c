"""Hourglass control by a penalty of pairs, [Ganzenmueller2015], as options.

What the deformation gradient leaves of a pair, ``delta = |x_ab| - F X_ab . x_ab / |x_ab|`` with
``F`` the mean of the two, is held by a spring along the pair:

    f_a = sum_b alpha E V_a V_b W_ab / |X_ab|^2  delta  x_ab / |x_ab|     [N].

It is what LAMMPS and TrixiParticles ship, and what users of displacement SPH run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sphsolid.errors import require
from sphsolid.scheme.hourglass_term import HourglassTerm
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.term import Term, TermOption


@dataclass(frozen=True)
class HourglassControl(TermOption):
    """Springs along pairs against the motion that the gradient does not see.

    ``alpha`` is that of [Ganzenmueller2015] and of TrixiParticles, whose examples have 0.1.
    LAMMPS halves the force and adds shares of ``h`` to its denominators: an amplitude of ``A``
    there is about ``alpha = A / 2``.  Use it with ``Displacement()``; with ``Literal("kernel")``
    and ``h_over_dx = sqrt(2)`` it is what these codes run.

    Both momenta are exact.  The part that the springs get through ``F`` is left out of their force,
    so there is no potential: the work ``hourglass_control`` of the energy budget has either sign.

    Raises ``InputError`` unless ``0 < alpha <= 1000``.
    """

    alpha: float = 0.1

    def __post_init__(self) -> None:
        require(
            isinstance(self.alpha, int | float)
            and not isinstance(self.alpha, bool)
            and 0.0 < self.alpha <= 1.0e3,
            f"HourglassControl: alpha = {self.alpha!r} must be positive and at most 1000; 0.1 is "
            "the default, and NoStabilisation() is the method without it",
        )

    @property
    def name(self) -> str:
        """``hourglass control``."""
        return "hourglass control"

    def terms(self, set_up: SetUp) -> Sequence[Term]:
        """One term."""
        return (HourglassTerm(self.alpha, set_up),)
