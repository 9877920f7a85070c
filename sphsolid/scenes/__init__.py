"""Problem statements: one benchmark a file, read by both solvers."""

from sphsolid.geometry import Blocks, Box, HoledBlock, Region, Tagged
from sphsolid.scenes.bending_column import bending_column
from sphsolid.scenes.cable import Pulse, Step, cable
from sphsolid.scenes.constraint import Constraint, Fixed
from sphsolid.scenes.csm3 import OnCylinder, PlaneClamp, csm3, csm3_spacing
from sphsolid.scenes.l_shaped_block import l_shaped_block
from sphsolid.scenes.plate_with_hole import SlowPull, gross_concentration, plate_with_hole
from sphsolid.scenes.punch import HeldVelocity, InitialVelocity, punch
from sphsolid.scenes.scene import FromGeometry, NoBodyForce, NoExactSolution, Scene, Traction
from sphsolid.scenes.spinning_cube import spinning_cube
from sphsolid.scenes.swinging_cube import amplitude_of_gradient, swinging_cube
from sphsolid.scenes.twisting_column import twisting_column

__all__ = [
    "Blocks",
    "Box",
    "Constraint",
    "Fixed",
    "FromGeometry",
    "HeldVelocity",
    "HoledBlock",
    "InitialVelocity",
    "NoBodyForce",
    "NoExactSolution",
    "OnCylinder",
    "PlaneClamp",
    "Pulse",
    "Region",
    "Scene",
    "SlowPull",
    "Step",
    "Tagged",
    "Traction",
    "amplitude_of_gradient",
    "bending_column",
    "cable",
    "csm3",
    "csm3_spacing",
    "gross_concentration",
    "l_shaped_block",
    "plate_with_hole",
    "punch",
    "spinning_cube",
    "swinging_cube",
    "twisting_column",
]
