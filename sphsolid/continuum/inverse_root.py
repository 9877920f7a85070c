"""``J^(-2/3)``, the only power in the strain energies, by multiplications alone.

A call of the mathematical library keeps a loop from working on several particles at once and may
differ in its last bit from one machine to another.  In a kernel ``y = J^(-1/3)`` is therefore
found by Newton's method for ``y^-3 = J``,

    y <- y (4 - J y^3) / 3,

from a guess that divides the exponent of ``J`` by -3 in its bits (relative error below 4 %): the
error squares and doubles at each of four steps, down to round-off.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sphsolid.compiled import overload

#: ``4/3`` of the exponent of one, less what centres the error of the guess.
_GUESS = int(4.0 / 3.0 * (1023 << 52)) - int(0.044 * (1 << 52))


def inverse_two_thirds(J: Any) -> Any:
    """``J^(-2/3)``; ``nan`` in a kernel where ``J <= 0``, so that a diverged state is noticed."""
    return J ** (-2.0 / 3.0)


@overload(inverse_two_thirds, jit_options={"forceinline": True})
def _inverse_two_thirds(J):  # type: ignore[no-untyped-def]
    def by_newton(J):  # type: ignore[no-untyped-def]
        bits = np.float64(np.float64(J).view(np.int64))
        y = np.int64(_GUESS - np.int64(bits * (1.0 / 3.0))).view(np.float64)
        y = y * (4.0 - J * y * y * y) * (1.0 / 3.0)
        y = y * (4.0 - J * y * y * y) * (1.0 / 3.0)
        y = y * (4.0 - J * y * y * y) * (1.0 / 3.0)
        y = y * (4.0 - J * y * y * y) * (1.0 / 3.0)
        return y * y if J > 0.0 else np.nan

    return by_newton
