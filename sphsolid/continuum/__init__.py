"""Physics that both solvers share: tensor algebra, constitutive laws, wave speeds."""

from sphsolid.continuum.check_law import check_law, require_law
from sphsolid.continuum.law import QUADRATIC, Volumetric, register_law
from sphsolid.continuum.mooney_rivlin import MooneyRivlin
from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.continuum.saint_venant_kirchhoff import SaintVenantKirchhoff
from sphsolid.continuum.wave_speed import reference_p_wave_speed, wave_speeds

__all__ = [
    "QUADRATIC",
    "MooneyRivlin",
    "NeoHookean",
    "SaintVenantKirchhoff",
    "Volumetric",
    "check_law",
    "reference_p_wave_speed",
    "register_law",
    "require_law",
    "wave_speeds",
]
