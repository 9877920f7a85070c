"""Problem statements: one benchmark a file, read by both solvers."""

from sphsolid.scenes.body import Box
from sphsolid.scenes.constraint import Constraint, Fixed
from sphsolid.scenes.scene import NoBodyForce, NoExactSolution, Scene, Traction
from sphsolid.scenes.swinging_cube import amplitude_of_gradient, swinging_cube

__all__ = [
    "Box",
    "Constraint",
    "Fixed",
    "NoBodyForce",
    "NoExactSolution",
    "Scene",
    "Traction",
    "amplitude_of_gradient",
    "swinging_cube",
]
