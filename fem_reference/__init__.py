"""Finite element reference: explicit elements that read the same ``Scene`` as the particles.

scikit-fem supplies mesh, shape functions and quadrature once; the time loop runs on arrays.
"""

from fem_reference.b_bar_hex import BBarHex
from fem_reference.cell_tables import Hexahedra, Tetrahedra
from fem_reference.constrained_touch import ConstrainedTOUCH
from fem_reference.dilatation import ConsistentMass, LumpedMass
from fem_reference.full_hex import FullHex
from fem_reference.mixed_simulation import MixedSimulation
from fem_reference.nodal_pressure_tet import NodalPressureTet
from fem_reference.pg_fem import PGFEM
from fem_reference.simulation import Simulation
from fem_reference.taylor_hood_hex import TaylorHoodHex
from fem_reference.touch_simulation import FiniteVolumeSimulation

__all__ = [
    "PGFEM",
    "BBarHex",
    "ConsistentMass",
    "ConstrainedTOUCH",
    "FiniteVolumeSimulation",
    "FullHex",
    "Hexahedra",
    "LumpedMass",
    "MixedSimulation",
    "NodalPressureTet",
    "Simulation",
    "TaylorHoodHex",
    "Tetrahedra",
]
