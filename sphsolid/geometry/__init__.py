"""Bodies and the meshes that fill them: geometry only, no physics and no particles."""

from sphsolid.geometry.body import AsMeshed, Blocks, Body, Box, Region, Spacing, Tagged
from sphsolid.geometry.mesh import HexMesh, Mesh, TetMesh

__all__ = [
    "AsMeshed",
    "Blocks",
    "Body",
    "Box",
    "HexMesh",
    "Mesh",
    "Region",
    "Spacing",
    "Tagged",
    "TetMesh",
]
