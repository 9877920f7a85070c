"""Total-Lagrangian SUPG-SPH for explicit large-strain solid dynamics, built to be verified."""

from sphsolid.cloud import (
    H1,
    H6,
    T1,
    Consistent,
    CubicSpline,
    Literal,
    QuinticSpline,
    WendlandC2,
)
from sphsolid.continuum import MooneyRivlin, NeoHookean
from sphsolid.errors import Diverged, InputError
from sphsolid.scheme import (
    PF,
    PFHJ,
    PFJ,
    PJ,
    SSPRK3,
    SUPG,
    TVDRK2,
    AsPrinted,
    Compatible,
    Displacement,
    FullHessian,
    Given,
    LocalProjection,
    NoProjection,
    NoStabilisation,
    PositionVerlet,
    SelfAdjoint,
    SimplifiedHessian,
    StabilisedStrains,
)
from sphsolid.simulation import Simulation

__version__ = "0.1.0"

__all__ = [
    "H1",
    "H6",
    "PF",
    "PFHJ",
    "PFJ",
    "PJ",
    "SSPRK3",
    "SUPG",
    "TVDRK2",
    "AsPrinted",
    "Compatible",
    "Consistent",
    "CubicSpline",
    "Displacement",
    "Diverged",
    "FullHessian",
    "Given",
    "InputError",
    "Literal",
    "LocalProjection",
    "MooneyRivlin",
    "NeoHookean",
    "NoProjection",
    "NoStabilisation",
    "PositionVerlet",
    "QuinticSpline",
    "SelfAdjoint",
    "SimplifiedHessian",
    "Simulation",
    "StabilisedStrains",
    "T1",
    "WendlandC2",
    "__version__",
]
