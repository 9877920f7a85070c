"""The method of the paper, sections 3 to 6: one idea a file."""

from sphsolid.scheme.dilatation import Dilatation, FilteredDilatation, OwnDilatation
from sphsolid.scheme.formulation import PF, PFHJ, PFJ, PJ, Displacement, Formulation
from sphsolid.scheme.hourglass_control import HourglassControl
from sphsolid.scheme.initial_strain import Compatible, Equilibrated, Given, InitialStrain
from sphsolid.scheme.integrator import Integrator, Stepper
from sphsolid.scheme.intrinsic_time import IntrinsicTime, OfMesh, OfStep
from sphsolid.scheme.jst import JST
from sphsolid.scheme.operator import Operator
from sphsolid.scheme.position_verlet import PositionVerlet
from sphsolid.scheme.projection import LocalProjection, NoProjection
from sphsolid.scheme.restraint import Elastic, NoStiffness, Quartic, Restraint, Stiffness
from sphsolid.scheme.right_hand_side import RightHandSide
from sphsolid.scheme.set_up import SetUp
from sphsolid.scheme.ssp_rk3 import SSPRK3
from sphsolid.scheme.stabilisation import (
    SUPG,
    AsPrinted,
    FullHessian,
    NoStabilisation,
    SelfAdjoint,
    SimplifiedHessian,
    Stabilisation,
    StabilisedStrains,
)
from sphsolid.scheme.stage import Stage
from sphsolid.scheme.state import Field, State
from sphsolid.scheme.symplectic_rkn4 import SymplecticRKN4
from sphsolid.scheme.term import Term, TermOption
from sphsolid.scheme.tvd_rk2 import TVDRK2
from sphsolid.scheme.upwind import Upwind

__all__ = [
    "JST",
    "PF",
    "PFHJ",
    "PFJ",
    "PJ",
    "SUPG",
    "SSPRK3",
    "TVDRK2",
    "AsPrinted",
    "Compatible",
    "Dilatation",
    "Displacement",
    "Elastic",
    "Formulation",
    "Equilibrated",
    "Field",
    "FilteredDilatation",
    "FullHessian",
    "Given",
    "HourglassControl",
    "InitialStrain",
    "Integrator",
    "IntrinsicTime",
    "LocalProjection",
    "NoProjection",
    "NoStabilisation",
    "NoStiffness",
    "OfMesh",
    "OfStep",
    "Operator",
    "OwnDilatation",
    "PositionVerlet",
    "Quartic",
    "Restraint",
    "RightHandSide",
    "SelfAdjoint",
    "SetUp",
    "SimplifiedHessian",
    "Stabilisation",
    "StabilisedStrains",
    "Stage",
    "State",
    "Stiffness",
    "Stepper",
    "SymplecticRKN4",
    "Term",
    "TermOption",
    "Upwind",
]
