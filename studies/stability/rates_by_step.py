"""How the rates depend on the length of the step: through the intrinsic times of the step alone.

Times of the mesh are what they are at every CFL number, times of the step grow with it, so the
rates are a polynomial in it and few of them serve every step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sphsolid import SUPG, OfStep, Simulation
from sphsolid.scheme.intrinsic_time import Times, Units
from sphsolid.scheme.stabilisation import Stabilisation


def unit_time(simulation: Simulation) -> float:
    """The step [s] at CFL 1 of the state now."""
    return simulation.stable_time_step() / simulation._time_step.cfl


def times_at(simulation: Simulation, step: float) -> Times:
    """Intrinsic times [s] where the CFL rule allows ``step`` [s]; at zero nothing has a time."""
    supg = simulation.stabilisation
    if not isinstance(supg, SUPG) or step == 0.0:
        return Times(0.0, 0.0, 0.0, 0.0)
    return supg.seconds(Units(simulation._time_step.crossing, step))


def take_times_at(simulation: Simulation, step: float) -> None:
    """Give every term its times where the CFL rule allows ``step`` [s]."""
    crossing = simulation._time_step.crossing if step > 0.0 else 0.0
    simulation._rhs.begin_step(Units(crossing, step))


def nodes(stabilisation: Stabilisation) -> tuple[float, ...]:
    """CFL numbers at which the rates are taken: as many as their polynomial in it needs.

    ``D(p)`` is linear in its time, ``D(J)`` in its own and, in the self-adjoint form, in both.
    """
    if not isinstance(stabilisation, SUPG):
        return (1.0,)
    grow = {
        name: isinstance(time, OfStep) and time.c > 0.0
        for name, time in stabilisation.intrinsic_times.items()
    }
    degree = int(grow.pop("tau_p")) + int(any(grow.values()))
    if not stabilisation.is_self_adjoint:
        degree = min(degree, 1)
    return ((1.0,), (0.5, 1.0), (0.25, 0.5, 1.0))[degree]


def interpolated(
    at_nodes: NDArray[np.float64], places: tuple[float, ...], cfl: float
) -> NDArray[np.float64]:
    """The polynomial through ``at_nodes (n, ...)`` at the CFL numbers ``places (n,)``."""
    weights = [
        np.prod([(cfl - other) / (node - other) for other in places if other != node])
        for node in places
    ]
    return np.asarray(np.tensordot(np.array(weights), at_nodes, axes=1))
