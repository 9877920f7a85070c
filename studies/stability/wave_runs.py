"""Small motions that a sound method keeps: a free vibration, and a pulse three spacings wide."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.errors import Diverged
from sphsolid.record import Energy, History, Recorder, Snapshot
from sphsolid.scenes import Box, Constraint, Scene
from studies.stability.hard_case_methods import Method, Simulation
from studies.stability.vibration_mode import DENSITY, HEIGHT, WIDTH, YOUNG, lowest_mode

Array = NDArray[np.float64]
#: Amplitude of the vibration [m], so small that the solid answers linearly.
AMPLITUDE = 1.0e-4
PERIODS, RECORDS_A_PERIOD = 10, 40
#: Half of the base of the pulse is its width at half height; in spacings.
PULSE_WIDTH = 3.0
#: Spacings along the bar and across it, where the pulse starts and how far it travels.
BAR, ACROSS, START, TRAVEL = 40, 2, 8, 24
#: Speed in the pulse over that of the wave.
PULSE_SPEED = 1.0e-5


@dataclass(frozen=True)
class Modal:
    """How much of a shape ``(N, 3)`` is in the velocity, by volume."""

    shape: Array

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """One column [m/s]."""
        weight = snapshot.V[:, None] * self.shape
        return {"modal": float(np.sum(weight * snapshot.velocity) / np.sum(weight * self.shape))}


def vibration(
    *, method: Mapping[str, Any], poisson_ratio: float, cells: int
) -> list[dict[str, Any]]:
    """The clamped block's lowest bending mode, started as it is, for :data:`PERIODS` periods.

    ``energy_left`` over that at the start; ``damping_ratio = -ln(energy_left) / (2 omega t)``;
    ``frequency_error`` relative to the limit of quadratic elements, from the passages through rest.
    Of a run that was lost, what there was at its last record, and no frequency.
    """
    started = time.perf_counter()
    chosen, mode = Method(**method), lowest_mode(poisson_ratio)
    scene = Scene(
        name="vibrating_block",
        body=Box((0.0, 0.0, 0.0), (WIDTH, HEIGHT, WIDTH)),
        material=_solid(poisson_ratio),
        end_time=PERIODS * 2.0 * math.pi / mode.limit,
        initial_velocity=lambda X: AMPLITUDE * mode.limit * mode(X),
        constraints=(Constraint("Y-", "all"),),
        provenance="Ours: the lowest mode of the column's solid.",
    )
    solver = chosen.build(scene, 1.0 / cells)
    shape = mode(solver.placement().mesh.vertices)
    history, lost = _followed(solver, Modal(shape), PERIODS * RECORDS_A_PERIOD)
    energy = history["total_energy [J]"]
    left = float(energy[-1] / energy[0])
    omega = _frequency(history["time [s]"], history["modal"]) if lost["survived"] else math.nan
    return [
        _labels("vibration", chosen, poisson_ratio, cells) | lost | {
            "omega": omega, "omega_reference": mode.limit, "omega_finest": mode.omega,
            "frequency_error": omega / mode.limit - 1.0, "energy_left": left,
            "damping_ratio": -math.log(max(left, 1e-300)) / (2.0 * mode.limit * scene.end_time),
            "steps": solver.step, "wall_s": time.perf_counter() - started,
        }
    ]  # fmt: skip


def pulse(
    *, method: Mapping[str, Any], poisson_ratio: float, cells: int
) -> list[dict[str, Any]]:
    """A velocity pulse that runs along a bar held at its sides, by :data:`TRAVEL` spacings.

    In the linear limit it keeps its shape, ``v = f(X - c_p t)``.  ``energy_left`` over that at the
    start; ``width`` of ``v^2`` (root mean square about its centre) and ``lag`` of its centre, in
    spacings, and ``error``: root mean square of ``v`` less the exact one, over the exact one.
    """
    started = time.perf_counter()
    chosen, h = Method(**method), 1.0 / cells
    material = _solid(poisson_ratio)
    speed = math.sqrt((material.kappa + 4.0 / 3.0 * material.mu) / material.density)
    wave = Pulse(speed, PULSE_WIDTH * h, START * h)
    scene = Scene(
        name="pulse_in_a_bar",
        body=Box((0.0, 0.0, 0.0), (BAR * h, ACROSS * h, ACROSS * h)),
        material=material,
        end_time=TRAVEL * h / speed,
        initial_velocity=lambda X: wave.velocity(X, 0.0),
        initial_displacement=wave.displacement,
        constraints=tuple(Constraint(face, "normal") for face in ("Y-", "Y+", "Z-", "Z+")),
        provenance="Ours: d'Alembert's solution in the linear limit.",
    )
    solver = chosen.build(scene, h)
    history, lost = _followed(solver, Modal(np.ones((1, 3))), 1)
    energy, end = history["total_energy [J]"], solver.snapshot()
    v, exact = end.velocity[:, 0], wave.velocity(end.X, end.time)[:, 0]
    centre, width = _spread(end.X[:, 0], end.V * v**2)
    right, narrow = _spread(end.X[:, 0], end.V * exact**2)
    return [
        _labels("pulse", chosen, poisson_ratio, cells) | lost | {
            "energy_left": float(energy[-1] / energy[0]), "width": width / h,
            "width_reference": narrow / h, "lag": (right - centre) / h,
            "error": float(np.sqrt(np.sum(end.V * (v - exact) ** 2) / np.sum(end.V * exact**2))),
            "steps": solver.step, "wall_s": time.perf_counter() - started,
        }
    ]  # fmt: skip


@dataclass(frozen=True)
class Pulse:
    """``v_x = v_0 cos^2(pi s / 2 w)`` for ``|s| < w``, ``s = X - X_0 - c t``.

    ``w`` [m] is the width at half height.
    """

    speed: float
    width: float
    start: float

    def velocity(self, X: Array, t: float) -> Array:
        """``(n, 3)`` [m/s] at time ``t`` [s]."""
        s = np.clip(X[:, 0] - self.start - self.speed * t, -self.width, self.width)
        return self._along_x(np.cos(0.5 * np.pi * s / self.width) ** 2)

    def displacement(self, X: Array) -> Array:
        """``-1/c`` of the integral of the velocity ``(n, 3)`` [m]: all of it runs to the right."""
        s = np.clip(X[:, 0] - self.start, -self.width, self.width)
        w = self.width
        integral = 0.5 * (s + w) + 0.5 * w / np.pi * np.sin(np.pi * s / w)
        return self._along_x(-integral / self.speed)

    def _along_x(self, value: Array) -> Array:
        field = np.zeros((len(value), 3))
        field[:, 0] = PULSE_SPEED * self.speed * value
        return field


def _solid(poisson_ratio: float) -> NeoHookean:
    return NeoHookean.from_young(
        young_modulus=YOUNG, poisson_ratio=poisson_ratio, density=DENSITY
    )


def _followed(
    solver: Simulation, recorder: Recorder, records: int
) -> tuple[History, dict[str, Any]]:
    end = solver.scene.end_time
    try:
        history = solver.run(every=end / records, record=[Energy(), recorder])
    except Diverged as lost:
        return lost.history, {"survived": False, "reason": lost.reason}  # type: ignore[attr-defined]
    return history, {"survived": True, "reason": ""}


def _labels(part: str, method: Method, nu: float, cells: int) -> dict[str, Any]:
    return {"part": part, "method": method.name, "nu": nu, "cells": cells}


def _frequency(t: Array, q: Array) -> float:
    """From the first and the last passage of ``q`` through zero [rad/s]; nan with less than two."""
    at = np.flatnonzero(q[:-1] * q[1:] < 0.0)
    if len(at) < 2:
        return math.nan
    zero = t[at] - q[at] * (t[at + 1] - t[at]) / (q[at + 1] - q[at])
    return float(math.pi * (len(at) - 1) / (zero[-1] - zero[0]))


def _spread(X: Array, weight: Array) -> tuple[float, float]:
    centre = np.average(X, weights=weight)
    return float(centre), float(np.sqrt(np.average((X - centre) ** 2, weights=weight)))
