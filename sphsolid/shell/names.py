"""The classes that a case file may name, by the place where they may stand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid import scenes
from sphsolid.geometry import Blocks, Box, HoledBlock, MeshFile, PointCloud, TetBox
from sphsolid.record import (
    AngularMomentum,
    Energy,
    EnergyBudget,
    Errors,
    LinearMomentum,
    MomentumDrift,
    Positions,
    Probe,
    Reactions,
)

Named = dict[str, Callable[..., Any]]


def _by_name(*classes: Any) -> Named:
    return {each.__name__: each for each in classes}


SCENES = _by_name(
    scenes.bending_column, scenes.cable, scenes.csm3, scenes.l_shaped_block,
    scenes.plate_with_hole, scenes.punch, scenes.spinning_cube, scenes.swinging_cube,
    scenes.twisting_column,
)  # fmt: skip
BODIES = _by_name(Box, Blocks, HoledBlock, TetBox, MeshFile, PointCloud) | {
    "PointCloud.fill": PointCloud.fill
}
MATERIALS = _by_name(sph.NeoHookean, sph.MooneyRivlin, sph.SaintVenantKirchhoff)
RECORDERS = _by_name(
    Energy, EnergyBudget, LinearMomentum, AngularMomentum, MomentumDrift, Reactions, Probe, Errors,
    Positions,
)  # fmt: skip
_SECONDARY = (sph.H1, sph.H6, sph.T1, sph.Agglomerated)
#: Keywords of the particle method that are objects.
SPH: dict[str, Named] = {
    "formulation": _by_name(sph.PF, sph.PFJ, sph.PFHJ, sph.PJ, sph.Displacement),
    "stabilisation": _by_name(
        sph.Restraint, sph.SUPG, sph.JST, sph.Upwind, sph.HourglassControl, sph.NoStabilisation
    ),
    "dilatation": _by_name(sph.FilteredDilatation, sph.OwnDilatation),
    "operator": _by_name(
        sph.LatticeDifference, sph.Consistent, sph.SummationByParts, sph.Literal
    ),
    "smoothing": _by_name(sph.WendlandC2, sph.CubicSpline, sph.QuinticSpline),
    "angular_momentum": _by_name(sph.LocalProjection, sph.NoProjection),
    "initial_strain": _by_name(sph.Compatible, sph.Given, sph.Equilibrated),
    "integrator": _by_name(sph.PositionVerlet, sph.SymplecticRKN4, sph.TVDRK2, sph.SSPRK3),
}
SPH_NUMBERS = ("cfl", "h_over_dx")
#: The same of the finite elements.
FEM: dict[str, Named] = {
    "element": _by_name(fem.BBarHex, fem.TaylorHoodHex, fem.FullHex, fem.NodalPressureTet)
}
FEM_NUMBERS = ("cfl",)
#: What may stand within another object.
PARTS = _by_name(
    sph.OfMesh, sph.OfStep, *_SECONDARY, sph.SimplifiedHessian, sph.FullHessian,
    sph.StabilisedStrains, sph.AsPrinted, sph.SelfAdjoint, sph.Quartic, sph.Elastic,
    sph.NoStiffness, fem.LumpedMass, fem.ConsistentMass, scenes.Step, scenes.Pulse,
    scenes.InitialVelocity, scenes.HeldVelocity, scenes.PlaneClamp, scenes.OnCylinder,
) | BODIES  # fmt: skip
