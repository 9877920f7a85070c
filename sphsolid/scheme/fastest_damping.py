"""How fast a damping is at its fastest, and the step that it allows.

Position Verlet is stable for an oscillation of the frequency ``w`` that is damped at the rate ``d``
while ``(w dt)^2 + 2 d dt < 4`` (``position_verlet``).  A tenth is kept in hand.  The stages of the
Runge-Kutta integrators allow ``d dt < 2`` at least.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sphsolid.cloud.cloud import Cloud

Array = NDArray[np.float64]
#: Iterations; the estimate comes from below and is raised by a share of itself.
_ITERATIONS, _MARGIN = 60, 1.05
_MOST = 3.6


def fastest_rate(damp: Callable[[Array], Array], shape: tuple[int, ...]) -> float:
    """Largest ``|eigenvalue|`` [1/s] of ``f -> damp(f)`` on fields of ``shape``, a little above.

    By the power method; 0 where ``damp`` does nothing.
    """
    f = np.random.default_rng(0).normal(size=shape)
    rate = 0.0
    for _ in range(_ITERATIONS):
        f = damp(f / np.linalg.norm(f))
        rate = float(np.linalg.norm(f))
        if rate == 0.0:
            return 0.0
    return _MARGIN * rate


def damped_step(rate: float, cloud: Cloud, wave_speed: float) -> float:
    """The largest ``dt`` [s] with ``(w dt)^2 + 2 rate dt <= 3.6``, ``w = 2 c_p / h_min``.

    ``rate`` [1/s] of the fastest damping, ``wave_speed`` [m/s].
    """
    frequency = 2.0 * wave_speed / cloud.h_min
    return _MOST / (rate + math.sqrt(rate**2 + _MOST * frequency**2))
