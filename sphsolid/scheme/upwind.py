"""Upwind SPH: an acoustic Riemann flux between pairs, after [Lee2019], as options.

Two particles meet half-way with the momenta that their gradients predict there,

    p_a^+ = p_a + phi_a grad p_a . X_ab / 2,      p_b^- = p_b - phi_b grad p_b . X_ab / 2,

and the traction between them is that of an acoustic Riemann problem,

    t = (t_a + t_b) / 2 + S (p_b^- - p_a^+) / 2,    S = c_p n (x) n + c_s (1 - n (x) n).

The first part is the internal force as it is.  The second is this term: with the area of a pair
``2 |A_ab|``, ``A_ab = (V_a G_b(X_a) - V_b G_a(X_b)) / 2``,

    D(p)_a = 1/V_a sum_b |A_ab| S (p_b^- - p_a^+)    [N/m^3].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal as OneOf

from sphsolid.errors import require
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.term import Term, TermOption
from sphsolid.scheme.upwind_term import UpwindTerm

_RECONSTRUCTIONS = ("none", "linear", "limited")
_NORMALS = ("area", "pair")


@dataclass(frozen=True)
class Upwind(TermOption):
    """The dissipation of an acoustic Riemann flux.

    The flux itself is that of [Lee2019].  What is likely, not read, is a parameter:

    * ``reconstruction``: ``"linear"``; ``"limited"``, with the limiter ``phi`` of [Barth1989] for
      each component; or ``"none"``, first order, whose power is minus a square at any state.
    * ``impedance``: a share of the acoustic one; 1 has no free parameter.
    * ``normal``: ``n`` is the area vector of the pair as the body carries it, ``"area"``, or points
      from one particle to the other, ``"pair"``.
    * ``keeps_momenta``: linear momentum is exact pair by pair; the angular one by least squares
      over the whole body.

    Tractions are not reconstructed, and nothing is added to the rates of ``F``, ``H`` and ``J``.

    Raises ``InputError`` for anything else.
    """

    reconstruction: OneOf["none", "linear", "limited"] = "linear"
    impedance: float = 1.0
    normal: OneOf["area", "pair"] = "area"
    keeps_momenta: bool = True

    def __post_init__(self) -> None:
        require(
            self.reconstruction in _RECONSTRUCTIONS,
            f"Upwind: reconstruction = {self.reconstruction!r} is not one of 'none', 'linear', "
            "'limited'; 'linear' is the default",
        )
        require(
            isinstance(self.impedance, int | float)
            and not isinstance(self.impedance, bool)
            and 0.0 < self.impedance <= 10.0,
            f"Upwind: impedance = {self.impedance!r} must be positive and at most 10; 1 is that of "
            "the solid, and NoStabilisation() is the method without it",
        )
        require(
            self.normal in _NORMALS,
            f"Upwind: normal = {self.normal!r} is not one of 'area', 'pair'; 'area' is the default",
        )
        require(
            isinstance(self.keeps_momenta, bool),
            f"Upwind: keeps_momenta = {self.keeps_momenta!r} must be True or False",
        )

    @property
    def name(self) -> str:
        """``upwind``, and the reconstruction where it is not linear."""
        return "upwind" if self.reconstruction == "linear" else f"upwind {self.reconstruction}"

    def terms(self, set_up: SetUp) -> Sequence[Term]:
        """One term."""
        return (UpwindTerm(self, set_up),)
