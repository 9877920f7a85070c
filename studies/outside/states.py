"""What is compared between codes: places of points at instants, and numbers made of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.measures.indicators import whole_turns

Array = NDArray[np.float64]
#: Points at the same distance from a place differ by less than this share of the body's size.
_SAME = 1.0e-9


@dataclass(frozen=True)
class State:
    """Points ``X (n, 3)`` of the undeformed body at ``x (n, 3)`` [m], at ``time`` [s].

    ``energy`` [J] is kinetic and strain energy together.
    """

    time: float
    X: Array
    x: Array
    energy: float


def displacement(state: State, place: tuple[float, float, float]) -> Array:
    """``u (3,)`` [m] at ``place``: that of the nearest point, or the mean of several as near."""
    distance = np.linalg.norm(state.X - np.asarray(place), axis=1)
    near = distance < distance.min() + _SAME * np.abs(state.X).max()
    return np.asarray((state.x - state.X)[near].mean(axis=0))


def turned(states: Sequence[State]) -> Array:
    """Rotation [rad] about +Y of the points on the top face, at each state, whole turns kept.

    The best fit in the least-squares sense, positive from Z to X.  Between two states the top turns
    by less than half a turn.
    """
    angles = [0.0]
    for state in states:
        top = np.isclose(state.X[:, 1], state.X[:, 1].max())
        before = state.X[top][:, [2, 0]] @ [1.0, 1.0j]
        after = (state.x[top] - state.x[top].mean(axis=0))[:, [2, 0]] @ [1.0, 1.0j]
        angle = float(np.angle(np.sum(after * np.conj(before - before.mean()))))
        angles.append(whole_turns(angle, angles[-1]))
    return np.array(angles[1:])


def corners_height(state: State) -> float:
    """Mean height [m] of the four corners of the top face."""
    low, high = state.X.min(axis=0), state.X.max(axis=0)
    is_side = (np.isclose(state.X, low) | np.isclose(state.X, high))[:, [0, 2]].all(axis=1)
    corner = is_side & np.isclose(state.X[:, 1], high[1])
    return float(state.x[corner, 1].mean())


def highest(time: Array, values: Array) -> tuple[float, float]:
    """When ``values (n,)`` are largest [s], and how large: the parabola through three records.

    The record itself where the largest is the first or the last.
    """
    k = int(np.argmax(values))
    if k in (0, len(values) - 1):
        return float(time[k]), float(values[k])
    a, b, c = np.polyfit(time[k - 1 : k + 2] - time[k], values[k - 1 : k + 2], 2)
    return float(time[k] - 0.5 * b / a), float(c - 0.25 * b * b / a)
