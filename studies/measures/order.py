"""Observed order of convergence: the slope of log error over log spacing."""

from __future__ import annotations

from collections.abc import Sequence

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
