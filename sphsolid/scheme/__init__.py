"""The method of the paper, sections 3 to 6: one idea a file."""

from sphsolid.scheme.formulation import PF, PFHJ, PFJ, PJ, Displacement, Formulation
from sphsolid.scheme.initial_strain import Compatible, Given, InitialStrain
from sphsolid.scheme.projection import LocalProjection, NoProjection
from sphsolid.scheme.ssp_rk3 import SSPRK3
from sphsolid.scheme.stabilisation import (
    SUPG,
    FullHessian,
    NoStabilisation,
    SimplifiedHessian,
    Stabilisation,
    StabilisedStrains,
)
from sphsolid.scheme.tvd_rk2 import TVDRK2

__all__ = [
    "PF",
    "PFHJ",
    "PFJ",
    "PJ",
    "SUPG",
    "SSPRK3",
    "TVDRK2",
    "Compatible",
    "Displacement",
    "Formulation",
    "FullHessian",
    "Given",
    "InitialStrain",
    "LocalProjection",
    "NoProjection",
    "NoStabilisation",
    "SimplifiedHessian",
    "Stabilisation",
    "StabilisedStrains",
]
