"""Problem statements: one benchmark a file, read by both solvers."""

from sphsolid.scenes.body import Box
from sphsolid.scenes.constraint import Constraint, Fixed
from sphsolid.scenes.scene import FromGeometry, NoBodyForce, NoExactSolution, Scene, Traction
from sphsolid.scenes.swinging_cube import amplitude_of_gradient, swinging_cube
from sphsolid.scenes.twisting_column import twisting_column

__all__ = [
    "Box",
    "Constraint",
    "Fixed",
    "FromGeometry",
    "NoBodyForce",
    "NoExactSolution",
    "Scene",
    "Traction",
    "amplitude_of_gradient",
    "swinging_cube",
    "twisting_column",
]
