"""What the intrinsic times do when the step is changed: follow it, or stay what they are.

``SUPG`` takes its times in units of the step.  [Lee2017] fixes those numbers, and then every
stabilisation term scales with the step (:class:`OfTheStep`).  The package fixes ``tau_F`` in
seconds (``sphsolid.defaults``), and then the number falls as the step grows (:class:`OfTheMesh`);
``tau_p`` is a share of the step either way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sphsolid import SUPG
from sphsolid.scheme.stabilisation import Stabilisation


@dataclass(frozen=True)
class OfTheStep:
    """``tau_F`` is the given number of steps at every CFL number."""

    def at(self, stabilisation: Stabilisation, cfl: float) -> Stabilisation:
        """What is given."""
        return stabilisation


@dataclass(frozen=True)
class OfTheMesh:
    """``tau_F`` is the given number of steps at CFL 1, in seconds the same at all others."""

    def at(self, stabilisation: Stabilisation, cfl: float) -> Stabilisation:
        """Options for a step of ``cfl``; at zero nothing has a time, and nothing is changed."""
        if not isinstance(stabilisation, SUPG) or cfl == 0.0:
            return stabilisation
        return replace(stabilisation, tau_F=stabilisation.tau_F / cfl)


Times = OfTheStep | OfTheMesh


def nodes(times: Times, stabilisation: Stabilisation) -> tuple[float, ...]:
    """CFL numbers at which the rates are taken: as many as their polynomial in it needs.

    ``D(p)`` is linear in its time, ``D(J)`` in its own and, in the self-adjoint form, in both.
    """
    if not isinstance(stabilisation, SUPG):
        return (1.0,)
    damps_J = stabilisation.tau_p > 0.0
    degree = int(isinstance(times, OfTheStep)) + int(damps_J)
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
