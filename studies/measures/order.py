"""Orders and limits of a sequence of refinements.

The observed order of convergence is the slope of log error over log spacing.  A quantity on a
sequence of lattices is carried on to no spacing, with how well that is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from sphsolid.errors import InputError, require

#: Columns that describe one run of a family of refinements and so do not tell families apart.
OF_ONE_RUN = ("h", "particles", "steps", "error", "wall_s")


def fit_order(h: ArrayLike, error: ArrayLike) -> float:
    """Least-squares slope ``p`` of ``log error = p log h + c`` over all points.

    ``h (n,)`` [m] and ``error (n,)`` in any order.  Raises ``InputError`` for fewer than two
    different spacings and for values that are not positive and finite.
    """
    spacing, size = _checked(h, error)
    x = np.log(spacing) - np.mean(np.log(spacing))
    return float(x @ np.log(size) / (x @ x))


def last_order(h: ArrayLike, error: ArrayLike) -> float:
    """Slope between the two finest points; raises as :func:`fit_order`."""
    spacing, size = _checked(h, error)
    fine, coarse = np.argsort(spacing, kind="stable")[:2]
    return float(np.log(size[coarse] / size[fine]) / np.log(spacing[coarse] / spacing[fine]))


def order_table(table: pd.DataFrame, *, by: Sequence[str] | None = None) -> pd.DataFrame:
    """One row per family of refinements: ``by`` columns, then what its errors say.

    ``table`` has columns ``h`` [m] and ``error``; ``by`` names the columns that tell families
    apart (all but :data:`OF_ONE_RUN` if left out).  Added columns: ``levels``, ``h_finest`` [m],
    ``error_finest``, ``order_fitted`` and ``order_last``.  Orders are ``nan`` for a family with
    fewer than two levels (a run failed) or an error that is exactly zero or missing.  Raises
    ``InputError`` when ``h`` repeats within a family: then ``by`` lacks a column.
    """
    for column in ("h", "error"):
        require(column in table.columns, f"order table needs a column {column!r}")
    names = [c for c in table.columns if c not in OF_ONE_RUN] if by is None else list(by)
    if not names:
        return pd.DataFrame([_orders(table)])
    rows = []
    for key, family in table.groupby(names, sort=False, dropna=False):
        where = dict(zip(names, key, strict=True))
        if family["h"].duplicated().any():
            raise InputError(
                f"spacing repeats within {where}: name the column that tells those rows apart in by"
            )
        rows.append(where | _orders(family))
    return pd.DataFrame(rows)


def _orders(family: pd.DataFrame) -> dict[str, float]:
    family = family.sort_values("h", ascending=False)
    h, error = family["h"].to_numpy(dtype=float), family["error"].to_numpy(dtype=float)
    measurable = len(h) >= 2 and bool(np.all(np.isfinite(error) & (error > 0.0)))
    return {
        "levels": len(h),
        "h_finest": float(h[-1]),
        "error_finest": float(error[-1]),
        "order_fitted": fit_order(h, error) if measurable else float("nan"),
        "order_last": last_order(h, error) if measurable else float("nan"),
    }


def _checked(
    h: ArrayLike, error: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    spacing, size = np.asarray(h, dtype=float), np.asarray(error, dtype=float)
    require(
        spacing.ndim == 1 and spacing.shape == size.shape,
        f"h and error must be two lists of one length, got shapes {spacing.shape}, {size.shape}",
    )
    for name, values in (("h", spacing), ("error", size)):
        require(
            bool(np.all(np.isfinite(values) & (values > 0.0))),
            f"{name} = {values.tolist()} must be positive and finite: an order is a slope of logs",
        )
    require(
        len(np.unique(spacing)) == len(spacing) and len(spacing) >= 2,
        f"an order needs at least two different spacings, got h = {spacing.tolist()}",
    )
    return spacing, size


# --- the limit of a sequence ----------------------------------------------------------------------

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
