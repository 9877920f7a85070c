"""How this package says no: bad input before a run, divergence or folded positions in it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any


class InputError(ValueError):
    """A wrong input, found before any time step.

    The message names what is wrong, where, the allowed range and what to do about it.
    """


@dataclass
class Diverged(RuntimeError):
    """The solution became invalid (negative Jacobian or non-finite state).

    Carries where and when, so that a study can tabulate failures.
    """

    reason: str
    time: float
    step: int
    particle: int
    position: tuple[float, float, float]
    advice: str

    def __reduce__(self) -> tuple[Any, ...]:
        """With its fields: as it is, a worker's failure would never get back to its pool."""
        return type(self), tuple(getattr(self, each.name) for each in fields(self)), vars(self)

    def __str__(self) -> str:
        x, y, z = self.position
        return (
            f"{self.reason} at t = {self.time:.6g} s, step {self.step}, point {self.particle} "
            f"(X = {x:.4g}, {y:.4g}, {z:.4g} m). Try: {self.advice}"
        )


class FoldingWarning(UserWarning):
    """The positions of a running body have folded: the run goes on, its results are of no use.

    Given once a run, the first time an indicator of ``record.positions`` crosses its limit.
    """


def require(condition: bool, message: str) -> None:
    """Raise :class:`InputError` with ``message`` unless ``condition`` holds."""
    if not condition:
        raise InputError(message)


def nearest(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'x'?`` with the most similar of the ``known`` names, or nothing."""
    lower = {each.lower(): each for each in map(str, known)}
    found = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=0.6)
    return f"; did you mean {lower[found[0]]!r}?" if found else ""
