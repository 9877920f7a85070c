"""The restraint of the motion that no gradient sees, as options.

A nodal gradient is a difference across a particle, so positions that alternate from particle to
particle have none.  What an affine motion leaves of a near pair is

    e_ab = (x_b - x_a) - 1/2 (F_a + F_b) X_ab,        r_ab = |e_ab| / |X_ab|,

``O(h^3)`` where the motion is smooth.  Stiffness is a potential of ``r_ab`` and viscosity a
dissipation potential of the rate of ``F^T e``, with ``F`` the mean of the pair.  Both depend on
nothing that a rigid motion changes, and their forces are derivatives with the part through ``F``
included.  So both momenta are exact, and the viscosity takes energy at any state.

Near pairs are the edges of the cells (``restraint_pairs``); they are joined by material, so nothing
acts across a slot.  On the lines of a ``LatticeDifference`` the fourth difference takes the
place of ``e_ab`` (``restraint_lines``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields

from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.continuum.wave_speed import moduli_at_rest, reference_p_wave_speed
from sphsolid.errors import InputError, require
from sphsolid.protocols import check_protocol, number
from sphsolid.scheme.restraint_lines import LineRestraint
from sphsolid.scheme.restraint_pairs import PairRestraint
from sphsolid.scheme.restraint_term import RestraintParts
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.term import Term, TermOption

#: What a pair is held by over the compressive stress on it.
COMPRESSED = 0.4
#: No step follows the stiffness of the unseen motion itself: a larger ``c`` of ``Quartic`` loses
#: runs that the usual one bears.
STIFFEST = 1000.0


@dataclass(frozen=True)
class Stiffness:
    """A potential ``V_ab [mu (quartic r_ab^4 / 4 + elastic r_ab^2 / 2) + g r_ab^2 / 2]``.

    ``g`` is ``compressed`` times what presses on a pair; lines of a lattice have none of it
    (``restraint_pairs``).
    """

    @property
    def quartic(self) -> float:
        """Over the shear modulus."""
        return 0.0

    @property
    def elastic(self) -> float:
        """Over the shear modulus."""
        return 0.0

    @property
    def compressed(self) -> float:
        """Over the compressive stress; 0 where nothing acts."""
        return 0.0

    def __str__(self) -> str:
        return "no stiffness"


@dataclass(frozen=True)
class NoStiffness(Stiffness):
    """Nothing is held."""


@dataclass(frozen=True)
class Quartic(Stiffness):
    """``1/4 c mu V_ab r_ab^4``: nothing in the linear limit, a wall where a fold would begin.

    Its stiffness grows with the square of the unseen motion.
    """

    c: float = 40.0
    compressed: float = COMPRESSED

    def __post_init__(self) -> None:
        _check(self, "c", self.c, STIFFEST)
        _check(self, "compressed", self.compressed, _MOST_COMPRESSED)
        require(self.c > 0.0, f"Quartic: c = {self.c:g} must be positive, or use NoStiffness()")

    @property
    def quartic(self) -> float:
        """``c``."""
        return self.c

    def __str__(self) -> str:
        return f"quartic {self.c:g} mu"


@dataclass(frozen=True)
class Elastic(Stiffness):
    """``1/2 c mu V_ab r_ab^2``: acts in the linear limit too, on what is rough at a boundary."""

    c: float = 0.02
    compressed: float = COMPRESSED

    def __post_init__(self) -> None:
        _check(self, "c", self.c, _MOST_ELASTIC)
        _check(self, "compressed", self.compressed, _MOST_COMPRESSED)
        require(self.c > 0.0, f"Elastic: c = {self.c:g} must be positive, or use NoStiffness()")

    @property
    def elastic(self) -> float:
        """``c``."""
        return self.c

    def __str__(self) -> str:
        return f"elastic {self.c:g} mu"


@dataclass(frozen=True)
class Restraint(TermOption):
    """Stiffness and viscosity against the motion that the gradient does not see.

    ``viscosity`` is the share of ``rho0 c_p``: the dissipation potential is
    ``1/2 viscosity rho0 c_p V_ab |d(F^T e)/dt|^2 / |X_ab|``, less at strong stretches
    (:mod:`sphsolid.scheme.viscous_share`).  What it needs of
    the velocities is dear: ``spaced``, it acts in some steps, for all since it last did (see
    ``restraint_term.PUSHES``).
    """

    stiffness: Stiffness = field(default_factory=Quartic)
    viscosity: float = 0.02
    spaced: bool = True

    def __post_init__(self) -> None:
        check_protocol(
            "Restraint: stiffness", self.stiffness, ("quartic", "elastic", "compressed"),
            "use Quartic(), Elastic() or NoStiffness()",
        )
        viscosity = number("Restraint: viscosity", self.viscosity, "rho0 c_p")
        object.__setattr__(self, "viscosity", viscosity)
        require(
            0.0 <= viscosity < 1.0,
            f"Restraint: viscosity = {viscosity!r} must be within [0, 1); 0.02 is the default",
        )
        for name in ("quartic", "elastic", "compressed"):
            # That of a stiffness of one's own has met no check yet.
            what = f"{type(self.stiffness).__name__}: {name}"
            value = number(what, getattr(self.stiffness, name))
            require(value >= 0.0, f"{what} = {value!r} must not be negative")
        require(
            isinstance(self.spaced, bool),
            f"Restraint: spaced = {self.spaced!r} must be True (the viscosity acts in 4 of 15 "
            "steps, for all of them) or False (in every step)",
        )
        if self.viscosity == self.stiffness.quartic == self.stiffness.elastic == 0.0:
            raise InputError(
                "Restraint with no stiffness and no viscosity does nothing; use NoStabilisation()"
            )

    @property
    def name(self) -> str:
        """``restraint``."""
        return "restraint"

    def parts(self, set_up: SetUp) -> RestraintParts:
        """The coefficients in SI units."""
        material = set_up.material
        mu, kappa = moduli_at_rest(material)
        return RestraintParts(
            quartic=self.stiffness.quartic * mu,
            elastic=self.stiffness.elastic * mu,
            pressed=self.stiffness.compressed * kappa,
            sheared=self.stiffness.compressed * mu,
            viscosity=self.viscosity * material.density * reference_p_wave_speed(material),
            most=math.inf,
        )

    def terms(self, set_up: SetUp) -> Sequence[Term]:
        """One term: along the lines of a ``LatticeDifference``, of near pairs elsewhere."""
        made = LineRestraint if isinstance(set_up.cloud.kind, LatticeDifference) else PairRestraint
        return (made(self, self.parts(set_up), set_up),)


#: Largest values of what has a step limit of its own.
_MOST_ELASTIC, _MOST_COMPRESSED = 1.0e6, 10.0


def _check(stiffness: Quartic | Elastic, name: str, value: object, most: float) -> None:
    """Keep ``value`` as a ``float``; raises ``InputError`` outside ``[0, most)``."""
    what = f"{type(stiffness).__name__}: {name}"
    made = number(what, value)
    object.__setattr__(stiffness, name, made)
    usual = next(each.default for each in fields(stiffness) if each.name == name)
    require(
        0.0 <= made < most,
        f"{what} = {made:g} must be within [0, {most:g}); {usual:g} is the default",
    )
