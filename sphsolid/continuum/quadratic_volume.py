"""``U(J) = kappa/2 (J - 1)^2``: the volumetric energy of both laws of [Lee2017] eq. (7)."""

from __future__ import annotations

from typing import Any

from sphsolid.compiled import inlined
from sphsolid.continuum.volumetric import Volumetric


@inlined
def energy(m: Any, J: Any) -> Any:
    """``U`` [J/m^3]."""
    return 0.5 * m.kappa * (J - 1.0) * (J - 1.0)


@inlined
def pressure(m: Any, J: Any) -> Any:
    """``U' = kappa (J - 1)`` [Pa], positive in tension."""
    return m.kappa * (J - 1.0)


@inlined
def stiffness(m: Any, J: Any) -> Any:
    """``U'' = kappa`` [Pa]."""
    return m.kappa


#: For ``register_law(..., volumetric=QUADRATIC)``.  Solvers know that its pressure is linear in
#: ``J``, which saves the Taylor-Hood element a second projection.
QUADRATIC = Volumetric(energy, pressure, stiffness)
