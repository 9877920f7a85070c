"""Loads that remember what they were asked, in a place that nobody can copy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.scenes import Box, Constraint, Scene, Traction
from sphsolid.scenes.hidden_memory import refuse_hidden_memory

LAW = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)
MESH = Box().mesh(0.5)


def peak_hold() -> Any:
    seen: list[float] = []

    def value(X: Any, *others: Any) -> Any:
        seen.append(others[-1])
        return max(seen) * np.ones_like(X)

    return value


def counting() -> Any:
    seen: list[float] = []

    def value(X: Any, *others: Any) -> Any:
        seen.append(others[-1])
        return len(seen) * np.ones_like(X)

    return value


def noise() -> Any:
    random = np.random.default_rng(1)
    return lambda X, *others: random.random(X.shape)


def scene_of(kind: str, function: Any) -> Scene:
    given: dict[str, Any] = {
        "traction": {"tractions": (Traction("Z+", function),)},
        "body force": {"body_force": function},
        "prescribed velocity": {"constraints": (Constraint("Z+", "all", function),)},
    }[kind]
    return Scene(name="s", body=Box(), material=LAW, end_time=1e-3, **given)


@pytest.mark.parametrize("make", [peak_hold, counting, noise])
@pytest.mark.parametrize("kind", ["traction", "body force", "prescribed velocity"])
def test_it_is_refused_by_name(kind: str, make: Any) -> None:
    with pytest.raises(InputError, match=f"{kind}.* says something else of t = 0"):
        refuse_hidden_memory(scene_of(kind, make()), MESH)


@pytest.mark.parametrize("solver", [sph.Simulation, fem.Simulation])
def test_both_solvers_refuse_it(solver: Any) -> None:
    with pytest.raises(InputError, match="says something else of t = 0"):
        solver(scene_of("traction", peak_hold()), spacing=0.5)


class Counter:
    """Remembers in itself: it can be copied."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, X: Any, t: float) -> Any:
        self.asked += 1
        return np.full_like(X, 1.0 * self.asked)


def test_what_can_be_copied_and_what_fails_is_let_pass() -> None:
    force = Counter()
    refuse_hidden_memory(scene_of("body force", force), MESH)
    assert force.asked == 0

    def fails(X: Any, t: float) -> Any:
        raise ValueError("not yet")

    refuse_hidden_memory(scene_of("body force", fails), MESH)
