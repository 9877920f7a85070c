"""Errors: relative L2 norms per component, averaged over a period.

``|e|^2 = sum_a V_a e_a^2`` at each instant; the error of a run is the root mean square over
equally spaced instants, divided by a *fixed* scale (the norm of the exact amplitude).  A single
instant is no measure: where the exact field passes through zero the phase error is everything,
elsewhere it is nothing, and fitted slopes jump with the choice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.record.snapshot import PointField, Snapshot
from sphsolid.scenes.callbacks import asked
from sphsolid.scenes.scene import ExactSolution

Array = NDArray[np.float64]
AXES = "xyz"


def l2_norm(field: PointField) -> Array:
    """``sqrt(sum V f^2)`` of every component: shape ``values.shape[1:]``."""
    volume = field.V.reshape(-1, *([1] * (field.values.ndim - 1)))
    return np.sqrt(np.sum(volume * field.values**2, axis=0))


def instant_errors(snapshot: Snapshot, exact: ExactSolution) -> dict[str, float]:
    """Relative L2 errors of one snapshot: ``p_x`` .. ``p_z`` and ``P_xx`` .. ``P_zz``."""
    momentum, stress = snapshot.field("p"), snapshot.field("P")
    now = snapshot.time
    velocity = asked(exact.velocity, momentum.X, what="velocity of the exact solution", t=now)
    exact_momentum = snapshot.density * velocity
    exact_stress = asked(
        exact.first_piola, stress.X, what="first_piola of the exact solution", tensor=True, t=now
    )
    p = l2_norm(PointField(momentum.X, momentum.V, momentum.values - exact_momentum))
    P = l2_norm(PointField(stress.X, stress.V, stress.values - exact_stress))
    errors = {f"p_{AXES[i]}": float(p[i] / exact.momentum_scale) for i in range(3)}
    for i in range(3):
        for k in range(3):
            errors[f"P_{AXES[i]}{AXES[k]}"] = float(P[i, k] / exact.stress_scale)
    return errors


def period_errors(instants: Iterable[dict[str, float]]) -> dict[str, float]:
    """Root mean square over instants of :func:`instant_errors`; at least twelve are asked for."""
    rows = list(instants)
    if len(rows) < 12:
        raise InputError(
            f"errors are averaged over at least 12 instants of one period, got {len(rows)}"
        )
    return {name: math.sqrt(sum(row[name] ** 2 for row in rows) / len(rows)) for name in rows[0]}
