"""Intrinsic times of the stabilisation: those of the mesh, and those of the step.

    OfMesh(c):  tau = c h / c_p            OfStep(c):  tau = c dt

``h`` [m] is the length that a CFL number counts, ``c_p`` [m/s] the p-wave speed of the undeformed
solid.  ``dt`` [s] is the step that the CFL rule allows at the start of the step, not the step that
is taken: a run takes shorter ones to meet its records, and what is damped must not depend on when
somebody looks.  [Lee2017] has ``tau = dt``, which is ``OfStep(1)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

from sphsolid.errors import InputError

_WHY = "a negative one feeds energy into the modes it should damp"


@dataclass(frozen=True)
class Units:
    """What times are multiples of [s]: ``mesh = h / c_p``, ``step`` what the CFL rule allows now.

    ``step`` may be nan where no time is one of the step.  ``number`` counts the steps that were
    made before.
    """

    mesh: float
    step: float
    number: int = 0


@dataclass(frozen=True)
class OfMesh:
    """``tau = c h / c_p``: a time of the solid and the spacing, whatever the step."""

    c: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "c", checked(self.c, "OfMesh: c"))

    @property
    def follows_step(self) -> bool:
        """False."""
        return False

    @property
    def unit(self) -> str:
        """``h/c_p``."""
        return "h/c_p"

    def seconds(self, units: Units) -> float:
        """``c h / c_p`` [s]."""
        return self.c * units.mesh


@dataclass(frozen=True)
class OfStep:
    """``tau = c dt``: a share of the step that the CFL rule allows, as in [Lee2017]."""

    c: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "c", checked(self.c, "OfStep: c"))

    @property
    def follows_step(self) -> bool:
        """True where it asks anything of the step."""
        return self.c > 0.0

    @property
    def unit(self) -> str:
        """``dt``."""
        return "dt"

    def seconds(self, units: Units) -> float:
        """``c dt`` [s]; 0 for ``c = 0``, which asks nothing of the step."""
        return self.c * units.step if self.c > 0.0 else 0.0


IntrinsicTime = OfMesh | OfStep


def checked(value: object, what: str) -> float:
    """``value`` as a number; raises ``InputError`` unless it is finite and >= 0."""
    # True is one to Python, and a mistake here.
    number = math.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    if not (math.isfinite(number) and number >= 0.0):
        raise InputError(f"{what} = {value!r} must be a number, finite and >= 0; {_WHY}")
    return number


def as_time(value: object, what: str = "tau") -> IntrinsicTime:
    """A time as it is; a plain number is one of the step, the shorthand of [Lee2017].

    Raises ``InputError`` for anything else.
    """
    if isinstance(value, IntrinsicTime):
        return value
    if isinstance(value, Real):
        return OfStep(checked(value, what))
    raise InputError(
        f"{what} = {value!r} is no intrinsic time; use OfMesh(c) for c h / c_p, or OfStep(c) or a "
        "plain number c for c dt"
    )


@dataclass(frozen=True)
class Times:
    """All intrinsic times of a stabilisation in seconds; nan until somebody resolved them."""

    F: float = math.nan
    p: float = math.nan
    H: float = math.nan
    J: float = math.nan
