"""After how many steps a solver has done all that a step may hold.

The viscosity of a restraint acts in some of its steps only.  Whoever times steps takes whole
cycles: the fastest of fewer would be those in which it rests.
"""

from __future__ import annotations

from typing import Any

import sphsolid as sph
from sphsolid.scheme.restraint_term import CYCLE, PUSHES


def _is_spaced(sim: Any) -> bool:
    restraint = getattr(sim, "stabilisation", None)
    return isinstance(restraint, sph.Restraint) and restraint.spaced and restraint.viscosity > 0.0


def cycle(sim: Any) -> int:
    """Steps of a cycle; one where all steps are alike."""
    return CYCLE if _is_spaced(sim) else 1


def viscous_share(sim: Any) -> float:
    """In which share of its steps the viscosity of the restraint of ``sim`` acts."""
    return len(PUSHES) / CYCLE if _is_spaced(sim) else float(sim.stabilisation.viscosity > 0.0)
