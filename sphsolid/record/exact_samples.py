"""What of an exact solution is sampled: its errors are columns that a run goes on with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.scenes.scene import NoExactSolution

Array = NDArray[np.float64]
#: Functions ``f(X, t)`` that the errors are taken from, and whether they give tensors.
_FUNCTIONS = (("displacement", False), ("velocity", False), ("first_piola", True))
_SCALES = ("period", "momentum_scale", "stress_scale")


def exact_functions(exact: Any) -> Iterator[tuple[str, Callable[..., Array], bool]]:
    """Name, ``f(X (n, 3), t)`` and whether it returns ``(n, 3, 3)``, not ``(n, 3)``.

    The last say the numbers by which errors are divided, 0 where there is none.
    """
    if isinstance(exact, NoExactSolution):
        return
    for name, tensor in _FUNCTIONS:
        function = getattr(exact, name, None)
        if callable(function):
            yield f"exact {name.replace('_', ' ')}", function, tensor
    for name in _SCALES:
        yield f"exact {name.replace('_', ' ')}", _Constant(_number(exact, name)), False


class _Constant:
    def __init__(self, value: float) -> None:
        self._value = value

    def __call__(self, X: Array, t: float) -> Array:
        return np.full((len(X), 3), self._value)


def _number(exact: Any, name: str) -> float:
    try:
        return float(getattr(exact, name))
    except Exception:
        # It may have none, and none is asked for where no error is recorded.
        return 0.0
