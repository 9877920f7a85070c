"""Particles from a background mesh and the operators that act on them."""

from sphsolid.cloud.agglomerated import Agglomerated
from sphsolid.cloud.cloud import (
    Cloud,
    ConsistencyReport,
    Secondary,
    build_cloud,
    build_secondary,
    consistency_report,
)
from sphsolid.cloud.lattice_difference import LatticeDifference
from sphsolid.cloud.operator import Consistent, Literal, OperatorKind, SummationByParts
from sphsolid.cloud.secondary import H1, H6, T1, SecondaryPoints
from sphsolid.cloud.smoothing import CubicSpline, QuinticSpline, SmoothingFunction, WendlandC2

__all__ = [
    "H1",
    "H6",
    "Agglomerated",
    "Cloud",
    "Consistent",
    "ConsistencyReport",
    "CubicSpline",
    "LatticeDifference",
    "Literal",
    "OperatorKind",
    "QuinticSpline",
    "Secondary",
    "SecondaryPoints",
    "SmoothingFunction",
    "SummationByParts",
    "T1",
    "WendlandC2",
    "build_cloud",
    "build_secondary",
    "consistency_report",
]
