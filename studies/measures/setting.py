"""With which options a run was made, as columns: read from the solver, not from what was asked."""

from __future__ import annotations

import math
from typing import Any

from sphsolid import SUPG, NoProjection, Simulation
from sphsolid.scheme.intrinsic_time import as_time

#: Columns of a run; ``tau_unit`` is that of ``tau_F``.
COLUMNS = (
    "formulation", "secondary", "operator", "weighting", "projection", "integrator", "particles",
    "h_over_dx", "cfl", "tau_F", "tau_unit", "xi_F", "tau_p", "tau_p_unit",
)  # fmt: skip
_NUMBERS = ("h_over_dx", "tau_F", "xi_F", "tau_p")


def setting(solver: Any) -> dict[str, Any]:
    """Columns :data:`COLUMNS` of either solver; what it does not have is empty, or nan."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS, "") | dict.fromkeys(_NUMBERS, math.nan)
    row |= {"particles": len(solver.snapshot().X), "cfl": float(solver.identity()["cfl"])}
    if not isinstance(solver, Simulation):
        return row
    bare = isinstance(solver.angular_momentum, NoProjection)
    row |= {
        "formulation": solver.formulation.name,
        "operator": solver.operator.name,
        "projection": "none" if bare else "local",
        "integrator": solver.integrator.name,
        "h_over_dx": solver.h_over_dx,
    }
    supg = solver.stabilisation
    if isinstance(supg, SUPG):
        tau_F, tau_p = as_time(supg.tau_F), as_time(supg.tau_p)
        row |= {
            "secondary": supg.secondary.name,
            "weighting": "self-adjoint" if supg.is_self_adjoint else "as printed",
            "tau_F": tau_F.c, "tau_unit": tau_F.unit, "xi_F": supg.xi_F,
            "tau_p": tau_p.c, "tau_p_unit": tau_p.unit,
        }  # fmt: skip
    return row
