"""What a time integrator is: an option that the user writes, and the stepper it makes.

A stepper advances one state in place.  It asks ``rhs.evaluate(state, geometry, t)`` for rates of
every field of ``rhs.evolved``, imposes the essential conditions on ``p``, moves ``x``, and tells
``budget`` of every stage.  ``docs/how_to_add/integrator.md`` has an example.
"""

from __future__ import annotations

from typing import Protocol

from sphsolid.protocols import check_protocol
from sphsolid.scheme.boundary import EssentialConditions
from sphsolid.scheme.energy_budget import NoBudget, StageBudget
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.state import State


class Stepper(Protocol):
    """Advances one state in place."""

    #: Is told of every stage, see ``scheme.energy_budget``.
    budget: StageBudget | NoBudget

    def advance(self, dt: float, t: float) -> None:
        """From ``t`` to ``t + dt`` [s]."""
        ...


class Integrator(Protocol):
    """An option: a frozen dataclass with these three attributes and a method."""

    @property
    def name(self) -> str:
        """Short, for plans."""
        ...

    @property
    def stages(self) -> int:
        """Evaluations of the right-hand side a step."""
        ...

    @property
    def usual_cfl(self) -> float:
        """The CFL number where none is given."""
        ...

    def stepper(
        self, rhs: RightHandSide, state: State, essential: EssentialConditions
    ) -> Stepper:
        """A stepper with its own work arrays."""
        ...


def stepper_of(
    integrator: Integrator, rhs: RightHandSide, state: State, essential: EssentialConditions
) -> Stepper:
    """The stepper of ``integrator``; raises ``InputError`` for what cannot step."""
    made = integrator.stepper(rhs, state, essential)
    check_protocol(
        f"what stepper() of {integrator.name} returned", made, ("advance", "budget"),
        "see docs/how_to_add/integrator.md",
    )
    return made


def check_integrator(integrator: object) -> None:
    """Raise ``InputError`` unless ``integrator`` keeps the protocol."""
    check_protocol(
        "integrator", integrator, ("name", "stages", "usual_cfl", "stepper"),
        "use PositionVerlet(), SymplecticRKN4(), SSPRK3() or TVDRK2(), or see "
        "docs/how_to_add/integrator.md",
    )
