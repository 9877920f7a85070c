"""How fast the fastest mode grows, and the largest CFL number up to which it does not.

TVD-RK2 lets an undamped oscillation ``w`` grow by ``(w dt)^4 / 8`` a step, slowly where ``w dt``
is small, and damping that is not a positive form can feed slow modes.  So three limits are told
apart by ``max |g|``:

* ``strict``: no growth at all but round-off, ``1 + 1e-8``;
* ``slow``: tenfold in 1000 steps, ``10^(1/1000)``;
* ``fast``: tenfold in 50 steps, ``10^(1/50)``: beyond it a run is lost at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

#: Eigenvalues this near to one belong to modes that neither move nor grow.
NEUTRAL = 1.0e-5
LIMITS: dict[str, float] = {
    "strict": 1.0 + 1.0e-8,
    "slow": 10.0 ** (1.0 / 1000.0),
    "fast": 10.0 ** (1.0 / 50.0),
}
CFL = tuple(round(0.1 * n, 1) for n in range(1, 13))
#: Blocks are unstable before that.
CFL_OF_BLOCKS = CFL[:10]
SMALLEST = 0.01
#: Width [CFL] at which bisection stops.
WIDTH = 0.004


def largest_modulus(g: NDArray[np.complex128]) -> float:
    """``max |g|`` of all that are not neutral; zero where nothing is left."""
    return float(np.max(np.where(np.abs(g - 1.0) < NEUTRAL, 0.0, np.abs(g)), initial=0.0))


def decades(modulus: float, steps: int = 1000) -> float:
    """``log10`` of the growth over ``steps`` steps."""
    return steps * float(np.log10(modulus)) if modulus > 0.0 else float("-inf")


def limits(
    modulus: Callable[[float], float],
    scanned: Mapping[float, float],
    thresholds: Mapping[str, float] = LIMITS,
) -> dict[str, float]:
    """Largest CFL number below the first crossing of each threshold, by bisection.

    ``scanned`` maps CFL numbers to ``max |g|``; ``modulus(cfl)`` is asked in between and every
    answer is used for all thresholds.  Zero: not even ``SMALLEST``; the last scanned value: no
    crossing was found.
    """
    known = dict(scanned)
    found = {}
    for name, threshold in thresholds.items():
        over = [cfl for cfl in sorted(known) if known[cfl] > threshold]
        if not over:
            found[name] = max(known)
            continue
        high = over[0]
        below = [cfl for cfl in known if cfl < high]
        low = max(below, default=SMALLEST)
        if not below:
            known[low] = modulus(low)
            if known[low] > threshold:
                found[name] = 0.0
                continue
        while high - low > WIDTH:
            middle = 0.5 * (low + high)
            known[middle] = modulus(middle)
            low, high = (middle, high) if known[middle] <= threshold else (low, middle)
        found[name] = low
    return found


def scan(modulus: Callable[[float], float], cfl: Sequence[float] = CFL) -> dict[float, float]:
    """``max |g|`` at every CFL number."""
    return {number: modulus(number) for number in cfl}
