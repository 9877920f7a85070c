"""Parts of a user's own that return something else: one sentence each, before any step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import fem_reference as fem
import sphsolid as sph
from fem_reference.b_bar_hex import BBarHex
from fem_reference.simulation import HEXAHEDRA
from sphsolid.cloud.operator import Gradients, Layout
from sphsolid.errors import InputError
from sphsolid.scenes import Box, Scene

LAW = sph.NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)
SCENE = Scene(name="s", body=Box(), material=LAW, end_time=1e-3)


@dataclass(frozen=True)
class Altered:
    """The gradients of the package, and what is made of them."""

    change: Any
    name: str = "Altered"

    def build(self, cloud: Any) -> Any:
        return self.change(sph.Consistent().build(cloud))


def with_nan(made: Gradients) -> Gradients:
    G = made.kinematic.copy()
    G[7] = np.nan
    return Gradients(G, G, made.areas)


OPERATORS = {
    "nothing": (lambda made: None, "build returned NoneType; wanted is Gradients"),
    "a tuple": (lambda made: (made.kinematic, made.force), "build returned tuple"),
    "short": (
        lambda made: Gradients(made.kinematic[:-1], made.force, made.areas),
        r"kinematic has the shape \(.*, 3\); wanted is",
    ),
    "short areas": (
        lambda made: Gradients(made.kinematic, made.force, made.areas[:-1]), "areas has the shape",
    ),
    "nan": (with_nan, "kinematic is not finite in 1 rows, the first 7"),
    "turned round": (
        lambda made: Gradients(-made.kinematic, -made.kinematic, made.areas),
        "operator Altered: det F = -1 of the undeformed body",
    ),
}


@pytest.mark.parametrize("kind", OPERATORS)
def test_an_operator(kind: str) -> None:
    change, named = OPERATORS[kind]
    with pytest.raises(InputError, match=named):
        sph.Simulation(SCENE, spacing=0.25, formulation=sph.PF(), operator=Altered(change))


@dataclass(frozen=True)
class Laid(Altered):
    """With a layout of its own."""

    laid: Any = None

    def layout(self, mesh: Any) -> Any:
        return self.laid


@pytest.mark.parametrize("laid", [(1.0, {}, None), None, Layout(np.ones(3), {}, None)])  # type: ignore[arg-type]
def test_a_layout(laid: Any) -> None:
    with pytest.raises(InputError, match=r"Altered\.layout returned .*; wanted is Layout"):
        sph.Simulation(
            SCENE, spacing=0.25, formulation=sph.PF(), operator=Laid(lambda made: made, laid=laid)
        )


class Handing:
    """Elements of the package, some of whose members answer otherwise."""

    def __init__(self, own: Any, **others: Any) -> None:
        self._own, self._others = own, others

    def __getattr__(self, name: str) -> Any:
        return self._others.get(name) or getattr(self._own, name)


@dataclass(frozen=True)
class Own:
    """An element that is B-bar but for what ``change`` makes of it."""

    change: Any
    name: str = "own"
    cells: Any = HEXAHEDRA

    def cell_size(self, spacing: float) -> float:
        return spacing

    def discretise(self, **given: Any) -> Any:
        return self.change(BBarHex().discretise(**given))


ELEMENTS = {
    "nothing": (lambda own: None, r"what discretise\(\) of element own returned = None cannot"),
    "force returned": (
        lambda own: Handing(own, internal_force=lambda x, force: np.zeros_like(x)),
        "must write the forces of all nodes into force and return nothing; it returned ndarray",
    ),
    "force not written": (
        lambda own: Handing(own, internal_force=lambda x, force: None), "it returned NoneType",
    ),
    "no length": (
        lambda own: Handing(own, smallest_length=lambda: float("nan")),
        r"smallest_length\(\) returned nan; wanted is a finite length above 0 m",
    ),
}


@pytest.mark.parametrize("kind", ELEMENTS)
def test_an_element(kind: str) -> None:
    change, named = ELEMENTS[kind]
    with pytest.raises(InputError, match=named):
        fem.Simulation(SCENE, spacing=0.5, element=Own(change)).run()


def test_cells_that_are_none() -> None:
    with pytest.raises(InputError, match="element own: cells = 'tets' are none"):
        fem.Simulation(SCENE, spacing=0.5, element=Own(lambda own: own, cells="tets"))


@dataclass(frozen=True)
class Idle:
    """An integrator whose stepper does nothing at all."""

    name: str = "idle"
    stages: int = 1
    usual_cfl: float = 0.3

    def stepper(self, rhs: Any, state: Any, essential: Any) -> Any:
        return object()


def test_a_stepper() -> None:
    with pytest.raises(InputError, match=r"what stepper\(\) of idle returned.*no advance, budget"):
        sph.Simulation(SCENE, spacing=0.5, integrator=Idle())
