"""Judges of a run: each returns a number that is round-off when the scheme is right.

They are used by the verification tests and again, with a bug planted, by the tests of the tests.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.errors import Diverged
from sphsolid.record import Snapshot, angular_momentum, linear_momentum
from sphsolid.scenes import Box, Scene, swinging_cube
from sphsolid.scheme.formulation import Formulation
from sphsolid.scheme.intrinsic_time import Units
from sphsolid.scheme.state import State
from studies.measures.order import last_order
from studies.measures.swinging_cube import period_errors_of
from tests.oracles.blocks import AFFINE, MOONEY, stress_of, stretched_block

Array = NDArray[np.float64]


def rates_at(sim: sph.Simulation, *, step: float, t: float = 0.0) -> State:
    """Rates of the state now where the CFL rule allows ``step`` [s]."""
    sim._rhs.begin_step(Units(sim._time_step.crossing, step))
    return sim._rhs.evaluate(sim.state, sim.state.x, t)


# ------------------------------------------------------------- equilibrium
def accelerations(scene: Scene, **options: Any) -> tuple[sph.Simulation, Array]:
    """``dp/dt (N, 3)`` at the start, without stabilisation."""
    options = {"spacing": 0.2, "stabilisation": sph.NoStabilisation(), **options}
    sim = sph.Simulation(scene, **options)
    rates = rates_at(sim, step=sim.stable_time_step())
    return sim, rates.p.copy()


def patch_imbalance(*, jitter: float = 0.0, material: Any = MOONEY, **options: Any) -> float:
    """Largest ``|dp/dt| dx / |P|`` of an affine stretch held by the tractions ``t = P N``."""
    scene = stretched_block(jitter=jitter, material=material)
    sim, rate = accelerations(scene, **options)
    size = np.max(np.abs(stress_of(material, AFFINE)))
    return float(np.max(np.abs(rate)) * sim.cloud.spacing / size)


# ------------------------------------------------------------- momentum
def disturbed_block(
    formulation: Formulation, stabilisation: Any, *, jitter: float = 0.3, **options: Any
) -> sph.Simulation:
    """A free block whose fields fit neither its positions nor each other."""
    body = Box(upper=(1.0, 0.8, 1.2), jitter=jitter, seed=5)
    sim = sph.Simulation(
        Scene("disturbed", body, MOONEY, 1.0),
        spacing=0.2,
        formulation=formulation,
        stabilisation=stabilisation,
        **options,
    )
    random = np.random.default_rng(17)
    s = sim.state
    s.x += 0.02 * random.uniform(-1.0, 1.0, s.x.shape)
    s.p += 2.0e4 * random.uniform(-1.0, 1.0, s.p.shape)
    for field in (s.F, s.H, s.J):
        field += 0.1 * random.uniform(-1.0, 1.0, field.shape)
    return sim


def total_share(V: Array, density: Array) -> float:
    """``|sum V f| / sum V |f|``, the larger over components."""
    weight = V.reshape(-1, *([1] * (density.ndim - 1)))
    total = np.abs(np.sum(weight * density, axis=0))
    return float(np.max(total) / np.sum(weight * np.abs(density)))


def force_totals(formulation: Formulation, supg: sph.SUPG, **options: Any) -> dict[str, float]:
    """Shares of ``T``, ``D_p`` and (with ``tau_p``) ``D_J`` that do not sum to zero."""
    rates = []
    for stabilisation in (sph.NoStabilisation(), supg):
        sim = disturbed_block(formulation, stabilisation, **options)
        rates.append(rates_at(sim, step=1.0e-4))
    V = sim.cloud.V
    found = {
        "T": total_share(V, rates[0].p),
        "D_p": total_share(V, rates[1].p - rates[0].p),
    }
    if supg.damps_J:
        found["D_J"] = total_share(V, rates[1].J - rates[0].J)
    return found


def momentum_drift(sim: sph.Simulation, steps: int = 100) -> tuple[float, float]:
    """Largest change of linear and of angular momentum over their natural scales."""

    def totals(s: Snapshot) -> tuple[Array, Array]:
        return linear_momentum(s), angular_momentum(s)

    s = sim.snapshot()
    start = totals(s)
    size = s.V * np.linalg.norm(s.momentum, axis=1)
    scales = np.sum(size), np.sum(size * np.linalg.norm(s.x, axis=1))
    worst = [0.0, 0.0]
    for _ in range(steps):
        sim.advance(sim.stable_time_step())
        for k, now in enumerate(totals(sim.snapshot())):
            worst[k] = max(worst[k], float(np.max(np.abs(now - start[k])) / scales[k]))
    return worst[0], worst[1]


# ------------------------------------------------------------- energy
def total_energy(s: Snapshot) -> float:
    """Kinetic and strain energy [J]."""
    return s.kinetic_energy + s.strain_energy


def energy_change(sim: sph.Simulation, *, span: float, steps: int) -> float:
    """``E(span) / E(0) - 1`` after equal steps; infinite when the solution is lost."""
    start = total_energy(sim.snapshot())
    for _ in range(steps):
        sim.advance(span / steps)
    try:
        sim.stable_time_step()
    except Diverged:
        return float("inf")
    return total_energy(sim.snapshot()) / start - 1.0


# ------------------------------------------------------------- accuracy
def quadrature_moments(V: Array, X: Array, lower: Array, upper: Array) -> float:
    """Largest relative error of ``sum V`` and ``sum V X`` in a box: exact for true volumes."""
    size = float(np.prod(upper - lower))
    moment = np.abs(V @ X - size * 0.5 * (lower + upper)) / (size * (upper - lower))
    return float(max(abs(np.sum(V) / size - 1.0), np.max(moment)))


def cube_slope(*, jitter: float = 0.0, **options: Any) -> float:
    """Smallest slope of any momentum component on the swinging cube from h = 1/4 to 1/8."""
    errors = [
        period_errors_of(
            sph.Simulation(
                swinging_cube(amplitude=1e-7, jitter=jitter),
                spacing=spacing,
                **({"formulation": sph.PF()} | options),
            )
        )
        for spacing in (0.25, 0.125)
    ]
    return min(
        last_order([0.25, 0.125], [error[name] for error in errors])
        for name in ("p_x", "p_y", "p_z")
    )
