"""The scenes that are compared, with what is read of a run: one class a scene.

``levels`` are numbers of cells along a length of the scene, for CalculiX and for our methods.  Its
elements have a node in the middle of each edge, so ``n`` of them have as many nodes as ``2 n``
cells of ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sphsolid.geometry.mesh import HexMesh, hexahedra
from sphsolid.scenes import (
    OnCylinder,
    PlaneClamp,
    Scene,
    bending_column,
    csm3,
    csm3_spacing,
    l_shaped_block,
    punch,
    twisting_column,
)
from studies.outside.deck import Implicit
from studies.outside.states import State, corners_height, displacement, highest, turned


class Problem(Protocol):
    """A scene, how finely each code solves it, and what is read of its states."""

    @property
    def name(self) -> str:
        """Under which it stands in tables."""
        ...

    @property
    def implicit(self) -> Implicit:
        """Steps and records of CalculiX; ours have the same records."""
        ...

    @property
    def outside(self) -> Sequence[int]:
        """Levels of CalculiX, from coarse to fine."""
        ...

    @property
    def ours(self) -> Sequence[int]:
        """Levels of our methods, from coarse to fine."""
        ...

    def spacing(self, level: int) -> float:
        """Edge [m] of a cell, nominally."""
        ...

    def scene(self, level: int) -> Scene:
        """What is solved."""
        ...

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """Quantities of a run, by name with their unit."""
        ...


def mesh_of(problem: Problem, level: int) -> HexMesh:
    """The hexahedra that CalculiX solves."""
    body = problem.scene(level).body
    return hexahedra(body.mesh(problem.spacing(level)), problem.name)


def _kept(states: Sequence[State]) -> float:
    return states[-1].energy / states[0].energy


@dataclass(frozen=True)
class Column:
    """The twisting column; levels are cells a metre."""

    nu: float
    outside: tuple[int, ...] = (2, 3)
    ours: tuple[int, ...] = (4, 5, 6, 8)
    step: float = 5.0e-4
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", self.name or f"twisting column, nu {self.nu:g}")

    @property
    def implicit(self) -> Implicit:
        """To 0.1 s."""
        return Implicit(step=self.step, until=0.1, every=0.01)

    def spacing(self, level: int) -> float:
        """Of ``level`` cells a metre."""
        return 1.0 / level

    def scene(self, level: int) -> Scene:
        """The column at 105 rad/s."""
        return twisting_column(poisson_ratio=self.nu)

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """Twist at 20, 40 .. 100 ms, height of the top corners, energy kept."""
        twist = dict(zip((round(1e3 * s.time) for s in states), turned(states), strict=True))
        found = {f"twist at {ms} ms [rad]": float(twist[ms]) for ms in (20, 40, 60, 80, 100)}
        return found | {
            "top corners at 100 ms [m]": corners_height(states[-1]), "energy kept": _kept(states)
        }  # fmt: skip


@dataclass(frozen=True)
class Bending:
    """The bending column; levels are cells a metre."""

    outside: tuple[int, ...] = (2, 3)
    ours: tuple[int, ...] = (4, 5, 6, 8)
    step: float = 2.5e-3
    name: str = "bending column"

    @property
    def implicit(self) -> Implicit:
        """Past the first peak."""
        return Implicit(step=self.step, until=0.5, every=0.01)

    def spacing(self, level: int) -> float:
        """Of ``level`` cells a metre."""
        return 1.0 / level

    def scene(self, level: int) -> Scene:
        """The column, bent sideways."""
        return bending_column()

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """The first peak of ``u_x`` at the top's centre, and energy kept."""
        time = np.array([state.time for state in states])
        u = np.array([displacement(state, (0.0, 6.0, 0.0))[0] for state in states])
        at, peak = highest(time, u)
        return {"peak of u_x [m]": peak, "time of the peak [s]": at, "energy kept": _kept(states)}


@dataclass(frozen=True)
class LBlock:
    """The L-shaped block without disorder; levels are cells along 3 m."""

    outside: tuple[int, ...] = (2, 3)
    ours: tuple[int, ...] = (4, 6, 8)
    step: float = 0.05
    name: str = "L-shaped block"

    @property
    def implicit(self) -> Implicit:
        """To the end of the load."""
        return Implicit(step=self.step, until=5.0, every=0.5)

    def spacing(self, level: int) -> float:
        """Of ``level`` cells along 3 m."""
        return 3.0 / level

    def scene(self, level: int) -> Scene:
        """The block on a lattice."""
        return l_shaped_block(jitter=0.0)

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """How far both ends have come, and the energy that the loads have given."""
        last = states[-1]
        long_end, short_end = (displacement(last, X) for X in ((0, 10, 0), (6, 0, 0)))
        return {
            "long end at 5 s [m]": float(np.linalg.norm(long_end)),
            "short end at 5 s [m]": float(np.linalg.norm(short_end)),
            "energy at 5 s [J]": last.energy,
        }


@dataclass(frozen=True)
class Punch:
    """The punch with an initial velocity; levels are cells a metre."""

    outside: tuple[int, ...] = (10, 14)
    ours: tuple[int, ...] = (10, 20, 30)
    step: float = 1.0e-4
    name: str = "punch, initial velocity"

    @property
    def implicit(self) -> Implicit:
        """The time of the paper."""
        return Implicit(step=self.step, until=0.015, every=0.0015)

    def spacing(self, level: int) -> float:
        """Of ``level`` cells a metre."""
        return 1.0 / level

    def scene(self, level: int) -> Scene:
        """The block, pressed down over half of its length."""
        return punch()

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """How low and high the top face is at the end, and energy kept."""
        last = states[-1]
        z = last.x[np.isclose(last.X[:, 2], last.X[:, 2].max()), 2]
        return {
            "top face, lowest [m]": float(z.min()), "top face, highest [m]": float(z.max()),
            "energy kept": _kept(states),
        }  # fmt: skip


@dataclass(frozen=True)
class Beam:
    """Turek and Hron's CSM3; levels are cells across the height of the beam."""

    clamp: PlaneClamp | OnCylinder
    outside: tuple[int, ...] = (1, 2, 4)
    ours: tuple[int, ...] = (4, 8, 16)
    layers: int = 1
    step: float = 2.5e-3
    name: str = ""

    def __post_init__(self) -> None:
        where = "plane clamp" if isinstance(self.clamp, PlaneClamp) else "clamp on a cylinder"
        object.__setattr__(self, "name", self.name or f"CSM3, {where}")

    @property
    def implicit(self) -> Implicit:
        """Past the first time that the tip is lowest."""
        return Implicit(step=self.step, until=0.5, every=0.005)

    def spacing(self, level: int) -> float:
        """Of ``level`` cells across the height."""
        return csm3_spacing(level + 1)

    def scene(self, level: int) -> Scene:
        """The beam."""
        return csm3(points=level + 1, layers=self.layers, clamp=self.clamp)

    def read(self, states: Sequence[State]) -> dict[str, float]:
        """How far down the tip goes, and when."""
        time = np.array([state.time for state in states])
        tip = self.scene(self.ours[0]).probes["tip"]
        down = np.array([-displacement(state, tip)[1] for state in states])
        at, least = highest(time, down)
        return {"least u_y of the tip [mm]": -1.0e3 * least, "time of it [s]": at}


PROBLEMS: tuple[Problem, ...] = (
    Column(0.3), Column(0.45), Column(0.495, outside=(2, 3, 4)), Bending(), LBlock(), Punch(),
    Beam(PlaneClamp()), Beam(OnCylinder(), outside=(2, 4), ours=(4, 8)),
)  # fmt: skip
#: Of the clamped block that vibrates: Poisson's ratios, and cells a metre.
VIBRATION_NU, VIBRATION_OUTSIDE, VIBRATION_OURS = (0.3, 0.495), (4, 6, 8, 12), (4, 6, 8)


def frequency_name(nu: float) -> str:
    """Under which the vibration stands in tables."""
    return f"vibrating block, nu {nu:g}"


FREQUENCY = "lowest frequency [Hz]"
HERTZ = 2.0 * math.pi
