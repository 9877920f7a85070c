"""Bodies and the meshes that fill them: geometry only, no physics and no particles."""

from sphsolid.geometry.body import AsMeshed, Blocks, Body, Box, Region, Spacing, Tagged
from sphsolid.geometry.check_mesh import MeshReport, check_mesh
from sphsolid.geometry.holed_block import HoledBlock
from sphsolid.geometry.mesh import GridMesh, HexMesh, Mesh, TetMesh
from sphsolid.geometry.mesh_file import MeshFile
from sphsolid.geometry.point_cloud import PointCloud, interior_lattice
from sphsolid.geometry.surface import Surface
from sphsolid.geometry.tet_box import TetBox

__all__ = [
    "AsMeshed",
    "Blocks",
    "Body",
    "Box",
    "GridMesh",
    "HexMesh",
    "HoledBlock",
    "Mesh",
    "MeshFile",
    "MeshReport",
    "PointCloud",
    "Region",
    "Spacing",
    "Surface",
    "Tagged",
    "TetBox",
    "TetMesh",
    "check_mesh",
    "interior_lattice",
]
