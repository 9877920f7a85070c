"""Recorders: each turns a snapshot into a few named numbers of a history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sphsolid.errors import InputError
from sphsolid.record.norms import instant_errors
from sphsolid.record.snapshot import Snapshot
from sphsolid.scenes.scene import Scene

AXES = "xyz"


class Recorder(Protocol):
    """Anything with a ``record``; ``scene`` is the problem being solved."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Column names with units in brackets, and their values now."""
        ...


def asks_for_budget(recorders: Sequence[Recorder]) -> bool:
    """True when a recorder has a true ``needs_budget``: the solver then keeps its budget."""
    return any(getattr(recorder, "needs_budget", False) for recorder in recorders)


@dataclass(frozen=True)
class Energy:
    """Kinetic ``sum V |p|^2 / (2 rho0)``, strain ``sum V W`` and their sum [J]."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Three columns."""
        kinetic, strain = snapshot.kinetic_energy, snapshot.strain_energy
        return {
            "kinetic_energy [J]": kinetic,
            "strain_energy [J]": strain,
            "total_energy [J]": kinetic + strain,
        }


def linear_momentum(snapshot: Snapshot) -> NDArray[np.float64]:
    """``sum V p (3,)`` [kg m/s]."""
    carried = snapshot.masses
    return np.sum(carried.V[:, None] * (snapshot.density * carried.velocity), axis=0)


def angular_momentum(snapshot: Snapshot) -> NDArray[np.float64]:
    """``sum V x cross p (3,)`` [kg m^2/s] about the origin."""
    carried = snapshot.masses
    momentum = snapshot.density * carried.velocity
    return np.sum(carried.V[:, None] * np.cross(carried.x, momentum), axis=0)


def momentum_scales(snapshot: Snapshot) -> tuple[float, float]:
    """``sum V |p|`` [kg m/s] and ``sum V |x| |p|`` [kg m^2/s]."""
    carried = snapshot.masses
    size = np.linalg.norm(snapshot.density * carried.velocity, axis=1)
    arm = np.linalg.norm(carried.x, axis=1)
    return float(np.sum(carried.V * size)), float(np.sum(carried.V * (arm * size)))


@dataclass(frozen=True)
class LinearMomentum:
    """Total linear momentum [kg m/s] and its natural scale ``sum V |p|``."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Four columns."""
        total = linear_momentum(snapshot)
        row = {f"linear_momentum_{AXES[i]} [kg m/s]": float(total[i]) for i in range(3)}
        row["linear_momentum_scale [kg m/s]"] = momentum_scales(snapshot)[0]
        return row


@dataclass(frozen=True)
class AngularMomentum:
    """Total angular momentum [kg m^2/s] and its natural scale ``sum V |x| |p|``."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Four columns."""
        total = angular_momentum(snapshot)
        row = {f"angular_momentum_{AXES[i]} [kg m^2/s]": float(total[i]) for i in range(3)}
        row["angular_momentum_scale [kg m^2/s]"] = momentum_scales(snapshot)[1]
        return row


@dataclass(frozen=True)
class Probe:
    """Displacement [m] and velocity [m/s] of the primary point nearest to a named point."""

    point: str

    def __post_init__(self) -> None:
        """Refuse what is no name."""
        if not isinstance(self.point, str):
            raise InputError(
                f"Probe: point = {self.point!r} is not the name of a probe of the scene; for "
                'several write [Probe("tip"), Probe("corner")]'
            )

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Six columns; an unknown name is refused with the names the scene has."""
        if self.point not in scene.probes:
            raise InputError(
                f"probe {self.point!r} is not a point of scene {scene.name!r}; it has "
                f"{sorted(scene.probes)}"
            )
        target = np.asarray(scene.probes[self.point])
        a = int(np.argmin(np.sum((snapshot.X - target) ** 2, axis=1)))
        row = {}
        for i in range(3):
            row[f"{self.point}_u_{AXES[i]} [m]"] = float(snapshot.displacement[a, i])
            row[f"{self.point}_v_{AXES[i]} [m/s]"] = float(snapshot.velocity[a, i])
        return row


@dataclass(frozen=True)
class Errors:
    """Relative L2 errors against the scene's exact solution (see ``norms``)."""

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """Twelve columns: three momentum and nine stress components."""
        return instant_errors(snapshot, scene.known_solution())
