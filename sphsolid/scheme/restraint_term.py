"""What the two forms of the restraint share: what they measure, energies, limits, words."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sphsolid.fields import as_field, components, tensor_field, vector_field
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.term import Term

if TYPE_CHECKING:
    from sphsolid.scheme.restraint import Restraint

Array = NDArray[np.float64]
#: A spaced viscosity acts in these steps of every :data:`CYCLE`, so many times as strong: once for
#: each step since it last did.  At equal intervals it would meet some oscillations always at the
#: phase in which damping that lags by half a step feeds them.  In this rhythm it damps every
#: oscillation up to CFL numbers of 0.75 (a test multiplies the cycle out).
PUSHES = {0: 5, 4: 4, 7: 3, 10: 3}
CYCLE = 15
#: Largest damping in a step, rate times step, for which that holds, and for a viscosity that acts
#: in every step.
MOST_SPACED, MOST = 0.3, 0.85
#: What the rate is multiplied by where stretches are moderate: it grows with their squares.
_SQUARE = 5.0 / 3.0
#: Largest damping in a step of a spaced viscosity at a strong stretch, up to CFL numbers of 0.7.
#: There no push makes energy: the strongest takes ``(1 - 5 d)^2`` of it, below one for ``d < 0.4``.
MOST_STRETCHED = 0.36


class RestraintParts(NamedTuple):
    """``quartic``, ``elastic``, ``pressed`` and ``sheared`` stiffness [Pa], ``viscosity``
    [kg/(m^2 s)].

    ``most``: the square of a stretch from which on the viscosity is less (``viscous_share``).
    """

    quartic: float
    elastic: float
    pressed: float
    sheared: float
    viscosity: float
    most: float


class Measured(NamedTuple):
    """What motion is measured by: rows ``x, v (3, .)`` and the memory of the tensors ``F, L``."""

    x: Array
    v: Array
    F: Array
    L: Array


class RestraintTerm(Term):
    """The restraint on one body; ``rate`` [1/s] is that of the fastest damping, undeformed."""

    rate = 0.0

    def __init__(self, options: Restraint, parts: RestraintParts, set_up: SetUp) -> None:
        self.options = options
        self.parts = parts
        #: What acts in this step.
        self.acting = parts
        self.needs_rates = self.is_damped = self.follows_step = parts.viscosity > 0.0
        self.works = ("dissipation_restraint",) if self.is_damped else ()
        self._set_up = set_up
        self._operator = set_up.operator
        self._v = vector_field(0)
        self._none = self._tensor(0)
        self._F = self._L = self._L_kept = self._none
        self._measured: Measured | None = None

    def _tensor(self, size: int | None = None) -> Array:
        if size == 0:
            return tensor_field(0, particle_major=self._set_up.cloud.particle_major)
        return self._operator.zeros(Field("F", "tensor"))

    def begin_step(self, units: Units) -> None:
        """Let the viscosity act, or rest; where it would be too fast for this step it is less."""
        times = PUSHES.get(units.number % CYCLE, 0) if self.options.spaced else 1
        self.needs_rates = self.is_damped and times > 0
        most = math.inf
        if self.needs_rates and self.rate > 0.0:
            limit = MOST_STRETCHED if self.options.spaced else MOST
            most = limit / (self.rate * units.step)
        each = self.parts
        self.acting = RestraintParts(
            each.quartic, each.elastic, each.pressed, each.sheared, times * each.viscosity, most
        )

    def keep_for_powers(self) -> None:
        """Keep ``grad v`` of an evaluation from now on."""
        if self.is_damped and not self._L_kept.size:
            self._L_kept = self._tensor()

    def measured(self, stage: Stage) -> Measured:
        """Positions, velocities and their gradients, by the gradient whose adjoint is the force."""
        operator, F, L = self._operator, stage.state.F, self._none
        if not stage.knows_F_x:
            if not self._F.size:
                self._F = self._tensor()
            F = self._F
            operator.force_gradient(stage.arms, 1.0, F)
        if self.needs_rates:
            if not self._v.size:
                self._v = vector_field(self._set_up.cloud.size)
            np.divide(stage.state.p, self._set_up.material.density, out=self._v)
            L = self._gradient_of_v(stage)
            if self._L_kept.size:
                self._L_kept[:] = L
                L = self._L_kept
        self._measured = Measured(
            components(as_field(stage.arms)), components(self._v), components(F), components(L)
        )
        return self._measured

    def _gradient_of_v(self, stage: Stage) -> Array:
        """``grad v`` of the stage with the gradient whose adjoint makes the force."""
        if self._operator.is_adjoint:
            return stage.rates.F
        if not self._L.size:
            self._L = self._tensor()
        self._operator.force_gradient(stage.state.p, 1.0 / self._set_up.material.density, self._L)
        return self._L

    def powers(self, stage: Stage) -> tuple[float, ...]:
        """What the viscous force of the last evaluation takes at the velocities of ``stage``."""
        if not self.is_damped:
            return ()
        if not self.needs_rates or self._measured is None:
            return (0.0,)
        v = as_field(stage.state.p / self._set_up.material.density)
        given = components(v), components(self._gradient_of_v(stage))
        return (self._sums(self._measured, given)[1],)

    def stored_energy(self, state: State) -> float:
        """Energy [J] of the stiffness."""
        if self.parts.quartic == 0.0 and self.parts.elastic == 0.0:
            return 0.0
        arms, F = as_field(self._operator.arms(state.x)), self._tensor()
        self._operator.force_gradient(arms, 1.0, F)
        none = components(self._none)
        rest = Measured(components(arms), components(vector_field(0)), components(F), none)
        return self._sums(rest, (components(vector_field(0)), none))[0]

    @abstractmethod
    def _sums(self, measured: Measured, given: tuple[Array, Array]) -> tuple[float, float]:
        """What is stored [J], and the power [W] of the viscous force on ``given = (v, L)``."""

    def largest_step(self, state: State) -> float:
        """What :data:`MOST_SPACED` or :data:`MOST` allows of :attr:`rate`."""
        fastest = _SQUARE * self.rate
        most = MOST_SPACED if self.options.spaced else MOST
        return most / fastest if fastest > 0.0 else float("inf")

    def description(self, units: Units) -> str:
        """Stiffness, viscosity and the form they have here."""
        spaced = self.is_damped and self.options.spaced
        every = f" in {len(PUSHES)} of {CYCLE} steps" if spaced else ""
        return (
            f"restraint {self.form}: {self.options.stiffness}, viscosity "
            f"{self.options.viscosity:g} rho0 c_p{every}, both momenta exact"
        )

    #: What is measured, in the words of the plan.
    form = ""
