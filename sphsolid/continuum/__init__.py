"""Physics that both solvers share: tensor algebra, constitutive laws, wave speeds."""

from sphsolid.continuum.mooney_rivlin import MooneyRivlin
from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.continuum.wave_speed import reference_p_wave_speed, wave_speeds

__all__ = ["MooneyRivlin", "NeoHookean", "reference_p_wave_speed", "wave_speeds"]
