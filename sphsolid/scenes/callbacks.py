"""The one door through which a scene's functions are asked: initial data, motions, loads, answers.

What a function gets cannot be written to, so that ``X -= centre`` is refused instead of moving the
body.  What it returns must be an array of finite numbers, of exactly the shape that is asked for.
It is copied, so that a function may keep its array and write to it later.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import Diverged, InputError
from sphsolid.geometry.mesh import read_only

Array = NDArray[np.float64]


def asked(
    function: Callable[..., Any],
    *points: Array,
    what: str,
    tensor: bool = False,
    t: float | None = None,
) -> Array:
    """``function(*points)``, or ``function(*points, t)``, checked and copied.

    ``points``: arrays ``(n, 3)``, the first of them positions ``X`` [m]; ``t`` [s].  Returns
    ``(n, 3)``, or ``(n, 3, 3)`` of a ``tensor``.  Raises ``InputError`` naming ``what`` where the
    function fails, writes to its arguments, or returns another shape, no numbers, or numbers that
    are not finite.
    """
    at = "" if t is None else f" at t = {t:.6g} s"
    arguments: tuple[Any, ...] = tuple(read_only(array) for array in points)
    if t is not None:
        arguments += (t,)
    try:
        value = function(*arguments)
    except Diverged:
        raise
    except Exception as failure:
        if isinstance(failure, ValueError) and "read-only" in str(failure):
            raise InputError(
                f"{what} must not change X in place (nor any other array that it is given): write "
                f"X = X - c, not X -= c ({failure})"
            ) from failure
        called = "X, N, t" if len(points) > 1 else "X" if t is None else "X, t"
        how = f"; it is called with ({called})" if isinstance(failure, TypeError) else ""
        raise InputError(f"{what} raised {type(failure).__name__}{at}: {failure}{how}") from failure
    shape = (len(points[0]), 3, 3) if tensor else (len(points[0]), 3)
    return _checked(value, shape, what + at, points[0])


def _checked(value: Any, shape: tuple[int, ...], what: str, X: Array) -> Array:
    try:
        found = value if isinstance(value, np.ma.MaskedArray) else np.asarray(value)
    except (TypeError, ValueError) as ragged:
        raise InputError(f"{what} returned no array: {ragged}") from ragged
    if found.shape != shape or found.dtype.kind not in "fiu":
        got = (
            "nothing (is there a return?)" if value is None
            else f"{type(value).__name__} of shape {found.shape}"
            + ("" if found.dtype.kind in "fiu" else f" and type {found.dtype}")
        )  # fmt: skip
        width = "(3, 3) numbers" if len(shape) == 3 else "three numbers"
        raise InputError(
            f"{what} returned {got}; wanted is an array of shape {shape}, {width} for each of the "
            f"{shape[0]} points of X"
        )
    made = found.astype(np.float64, order="C")
    if isinstance(made, np.ma.MaskedArray):
        made = made.filled(np.nan)
    made = np.asarray(made)
    bad = np.flatnonzero(~np.isfinite(made).reshape(len(made), -1).all(axis=1))
    if len(bad):
        raise InputError(
            f"{what} is not finite at {len(bad)} of {len(X)} points, the first at X = "
            f"{X[bad[0]].tolist()} m"
        )
    return made
