"""A term of the semi-discrete system: an option that the user writes, and what it becomes.

The option says what it needs; :meth:`TermOption.terms` makes the terms for one body, with their
work arrays.  Right-hand side, integrators, time step, energy budget, checkpoint and plan ask the
hooks below and know no term by its class.  ``docs/how_to_add/term.md`` has an example.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Secondary
from sphsolid.errors import InputError, require
from sphsolid.protocols import check_protocol, members
from sphsolid.scenes.checks import as_float
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State

Array = NDArray[np.float64]


class Term:
    """What a term may do; each hook does nothing unless it is overridden."""

    #: Names of what :meth:`powers` hands out, for the energy budget.
    works: tuple[str, ...] = ()
    #: Fields beside ``p`` and those of its own whose rates it changes; ``J`` is the only one.
    changes: tuple[str, ...] = ()
    #: It reads ``stage.rates.F`` or the rates of other fields, in this step.
    needs_rates: bool = False
    #: It reads ``stage.projected_rate``.
    needs_projected_rate: bool = False
    #: It reads ``units.step`` in :meth:`begin_step`.
    follows_step: bool = False
    #: What it stores (see :meth:`stored_energy`) belongs to changes of volume.
    stores_volume: bool = False
    #: The secondary particles it samples at, if any.
    secondary: Secondary | None = None

    def start(self, state: State) -> None:
        """Fill the fields of its own at ``t = 0``."""

    def begin_step(self, units: Units) -> None:
        """Take coefficients that belong to the state at the start of a step."""

    def add_stress(self, stage: Stage) -> None:
        """Add to ``stage.P``, whose force is taken next."""

    def add_rates(self, stage: Stage) -> None:
        """Add to ``stage.rates``, which hold the Galerkin rates, loads and terms before it."""

    def keep_for_powers(self) -> None:
        """:meth:`powers` is asked from now on: keep what it needs of an evaluation."""

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """Powers [W] in the evaluation just made, one for each of :attr:`works`.

        What it takes from the energy of the body is negative.
        """
        return ()

    def stored_energy(self, state: State) -> float:
        """Energy [J] that it stores beside that of the law; ``state.F`` is of ``state.x``."""
        return 0.0

    def add_constitutive(self, state: State, P: Array) -> None:
        """Add to ``P (N, 3, 3)`` [Pa] what the solid has beyond the law: what snapshots show."""

    def at_secondary(self, f: Array) -> Array:
        """``sum_a f_a (x) G_a(X_q)  (M, 3, 3)`` at :attr:`secondary`, where there is one."""
        return np.zeros((0, 3, 3))

    def largest_step(self, state: State) -> float:
        """The largest stable step [s] that the term allows."""
        return math.inf

    def description(self, units: Units) -> str:
        """One line for the plan, ``units`` being those of the undeformed body."""
        return type(self).__name__


class TermOption(Protocol):
    """What the user writes: a frozen dataclass that keeps this protocol.

    A class that is derived from this one needs a ``name`` and :meth:`terms` alone.
    """

    #: Fields that the term evolves or keeps, beside those of the formulation.
    fields: ClassVar[tuple[Field, ...]] = ()

    @property
    def name(self) -> str:
        """Short, for file names."""
        ...

    def check(self, formulation: Formulation) -> None:
        """Raise ``InputError`` where the term cannot work with ``formulation``."""
        return None

    def terms(self, set_up: SetUp) -> Sequence[Term]:
        """The terms for one body, none where there is nothing to do."""
        ...


def check_term_option(what: str, option: object, advice: str) -> None:
    """Raise ``InputError`` unless ``option`` keeps the protocol."""
    check_protocol(
        what, option, ("name", "fields", "check", "terms"),
        f"{advice}, or derive your own from sphsolid.scheme.TermOption "
        "(docs/how_to_add/term.md)",
    )
    name, fields = option.name, option.fields  # type: ignore[attr-defined]
    require(isinstance(name, str), f"{what} = {option!r}: its name {name!r} is no text")
    members(f"fields of {name}", fields, Field)


def terms_of(options: Sequence[TermOption], set_up: SetUp) -> tuple[Term, ...]:
    """The terms of all ``options``, in order; raises ``InputError`` for one that is no term."""
    made = list[Term]()
    for option in options:
        given = option.terms(set_up)
        require(
            isinstance(given, list | tuple),
            f"{option.name}: terms() returned {given!r}; wanted is a tuple of terms: (Term(...),)",
        )
        made += given
    for term in made:
        check_protocol(
            "term", term, _HOOKS,
            "derive it from sphsolid.scheme.Term, where every hook does nothing",
        )
    return tuple(made)


def step_of(term: Term, state: State) -> float:
    """:meth:`Term.largest_step`, positive; raises ``InputError`` for anything else."""
    step = as_float(term.largest_step(state))
    if not isinstance(step, float) or not step > 0.0:
        raise InputError(
            f"{type(term).__name__}.largest_step returned {step!r}; wanted is a time above 0 s, or "
            "math.inf where the term sets no limit"
        )
    return step


def powers_of(term: Term, stage: Stage) -> tuple[float, ...]:
    """:meth:`Term.powers`, one for each of its works; raises ``InputError`` for another number."""
    powers = tuple(term.powers(stage))
    if len(powers) != len(term.works):
        raise InputError(
            f"{type(term).__name__}.powers returned {len(powers)} numbers; its works are "
            f"{list(term.works)}: return one power [W] for each"
        )
    return powers


_HOOKS = tuple(name for name in vars(Term) if not name.startswith("_"))
