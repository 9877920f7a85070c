"""One variant of the consistent operator on the swinging cube, or on the twisting column."""

from __future__ import annotations

import time
from typing import Any

import sphsolid as sph
from sphsolid.cloud import SmoothingFunction
from sphsolid.scenes import swinging_cube, twisting_column
from sphsolid.scheme import InitialStrain
from studies.convergence.cases import LINEAR_AMPLITUDE, period_errors_of
from studies.report.indicators import pressure_range, twist_of_top, whole_turns

SMOOTHING: dict[str, SmoothingFunction] = {
    "cubic spline": sph.CubicSpline(),
    "quintic spline": sph.QuinticSpline(),
    "Wendland C2": sph.WendlandC2(),
}
INITIAL_STRAIN: dict[str, InitialStrain] = {"compatible": sph.Compatible(), "given": sph.Given()}


def _simulation(
    scene: Any,
    spacing: float,
    *,
    use: str,
    smoothing: str,
    h_over_dx: float,
    exponent: float,
    gradient: str,
    layers: int,
    initial_strain: str,
    xi_F: float,
    formulation: Any,
    tau_p: float,
) -> sph.Simulation:
    return sph.Simulation(
        scene,
        spacing=spacing,
        formulation=formulation,
        stabilisation=sph.SUPG(xi_F=xi_F, tau_p=tau_p),
        operator=(
            sph.Literal(gradient=gradient)  # type: ignore[arg-type]
            if use == "nowhere"
            else sph.Consistent(
                use=use,  # type: ignore[arg-type]
                gradient=gradient,  # type: ignore[arg-type]
                layers=layers,
                weight_exponent=exponent,
            )
        ),
        smoothing=SMOOTHING[smoothing],
        h_over_dx=h_over_dx,
        initial_strain=INITIAL_STRAIN[initial_strain],
        integrator=sph.TVDRK2(),
    )


def cube(*, variant: str, family: str, cells: int, **options: Any) -> list[dict[str, Any]]:
    """Errors of {p,F} SUPG-SPH-H1 in the linear limit: one row per component."""
    started = time.perf_counter()
    scene = swinging_cube(family=family, amplitude=LINEAR_AMPLITUDE)  # type: ignore[arg-type]
    sim = _simulation(scene, 1.0 / cells, formulation=sph.PF(), tau_p=0.0, **options)
    errors = period_errors_of(sim)
    wall = time.perf_counter() - started
    return [
        {"scene": "cube", "variant": variant, "family": family, "component": name,
         "h": 1.0 / cells, "error": error, "wall_s": wall}
        for name, error in errors.items()
    ]  # fmt: skip


def column(*, variant: str, cells: int, **options: Any) -> list[dict[str, Any]]:
    """Twist and energy of {p,F,J} SUPG-SPH-H1 on the twisting column at 0.1 s.

    ``cells`` per metre: 3 is the paper's 4x19x4 lattice, 5 its 6x31x6.
    """
    started = time.perf_counter()
    scene = twisting_column()
    strain = {"initial_strain": "compatible"}
    sim = _simulation(
        scene, 1.0 / cells, formulation=sph.PFJ(), tau_p=0.1, **(options | strain)
    )
    start = sim.snapshot()
    energy_0 = start.kinetic_energy + start.strain_energy
    twist = 0.0
    for k in range(1, 51):
        sim.run(until=0.002 * k)
        angle = twist_of_top(sim.snapshot())
        # The top turns by less than half a turn between two instants, so the jump tells the turns.
        twist = whole_turns(angle, twist)
    end = sim.snapshot()
    low, high = pressure_range(end)
    return [
        {
            "scene": "column",
            "variant": variant,
            "cells": cells,
            "twist": abs(twist),
            "energy": (end.kinetic_energy + end.strain_energy) / energy_0,
            "pressure_1": low,
            "pressure_99": high,
            "wall_s": time.perf_counter() - started,
        }
    ]
