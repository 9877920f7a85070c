"""A quantity on a sequence of lattices carried on to no spacing, and how well that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import require

Array = NDArray[np.float64]
#: Fewer have no limit that anything vouches for: three coarse ones can be wrong by 2 % and say 0.4.
LEVELS = 4


@dataclass(frozen=True)
class Limit:
    """``value`` at no spacing and the change, ``within``, that another extrapolation makes."""

    value: float
    within: float


def extrapolate(h: ArrayLike, values: ArrayLike) -> Limit:
    """``T`` of ``T + a h^2 + b h^4`` through the three finest of ``values (n,)`` at ``h (n,)``.

    Two terms, because errors of coarse lattices change sign: one power of ``h`` cannot.
    ``within`` is the largest of three changes.  One is without the second term (``T + a h^2``
    through the two finest).  One is without the finest level, so there must be four.  One is with
    the first power of ``h`` (``T + a h`` through the two finest), taken where the differences of
    the levels do not fall as fast as those of ``h^1.5``: a method of first order.  Raises
    ``InputError`` for fewer than :data:`LEVELS` different spacings, and for values that are not
    finite.
    """
    spacing, found = np.asarray(h, dtype=float), np.asarray(values, dtype=float)
    require(
        spacing.ndim == 1 and spacing.shape == found.shape and len(spacing) >= LEVELS
        and len(np.unique(spacing)) == len(spacing) and bool(np.isfinite(found).all())
        and bool(np.all((spacing > 0.0) & np.isfinite(spacing))),
        f"extrapolate needs finite values at {LEVELS} or more different positive spacings, got "
        f"{found.tolist()} at h = {spacing.tolist()}",
    )  # fmt: skip
    finest = np.argsort(spacing, kind="stable")
    h2, T = spacing[finest] ** 2, found[finest]
    value = _at_zero(h2[:3], T[:3])
    others = [_at_zero(h2[:2], T[:2]), _at_zero(h2[1:4], T[1:4])]
    if _falls_slowly(h2, T):
        others.append(_at_zero(np.sqrt(h2[:2]), T[:2]))
    return Limit(value, float(max(abs(other - value) for other in others)))


def _falls_slowly(h2: Array, T: Array) -> bool:
    """Whether the three finest differ by less than a power ``h^1.5`` would let them fall."""
    fine, coarse = abs(T[0] - T[1]), abs(T[1] - T[2])
    h = np.sqrt(h2[:3])
    return bool(fine > coarse * (h[1] ** 1.5 - h[0] ** 1.5) / (h[2] ** 1.5 - h[1] ** 1.5))


def _at_zero(x: Array, y: Array) -> float:
    """The polynomial through the points, at zero."""
    weights = [np.prod(np.delete(x, k) / (np.delete(x, k) - x[k])) for k in range(len(x))]
    return float(np.dot(weights, y))


def sign_changes(errors: ArrayLike) -> list[int]:
    """Positions ``k`` where errors ``k`` and ``k + 1`` of a sequence ``(n,)`` differ in sign."""
    signs = np.sign(np.asarray(errors, dtype=float))
    return np.flatnonzero(signs[1:] * signs[:-1] < 0.0).tolist()
