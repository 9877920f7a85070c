"""One run of the swinging cube: the unit of work of the convergence study."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.cloud import OperatorKind, SecondaryPoints
from sphsolid.record import Snapshot, Solver, instant_errors, march, period_errors
from sphsolid.scenes import Scene, amplitude_of_gradient, swinging_cube
from sphsolid.scheme.intrinsic_time import as_time
from sphsolid.scheme.projection import AngularMomentumTreatment

#: Instants of one period at which errors are taken: ``t_k = (k + 1/2) T / 12``.  Neither sine nor
#: cosine vanishes at any of them, so no instant hides the phase error or is nothing but it.
INSTANTS = 12
#: Amplitude [m] of the linear limit: nonlinear terms are 1e-7 of the linear ones.
LINEAR_AMPLITUDE = 1.0e-7
#: Largest principal value of the displacement gradient in the manufactured scene.
LARGEST_GRADIENT = 0.2

FORMULATIONS = {
    "{p,F}": sph.PF,
    "{p,F,J}": sph.PFJ,
    "{p,F,H,J}": sph.PFHJ,
    "displacement": sph.Displacement,
}
OPERATORS: dict[str, OperatorKind] = {
    "Literal": sph.Literal(),
    "Literal(linear kernel)": sph.Literal(gradient="linear_kernel"),
    "Consistent": sph.Consistent(),
    "Consistent(force)": sph.Consistent(use="force"),
}
SECONDARY: dict[str, SecondaryPoints] = {"H1": sph.H1(), "H6": sph.H6()}
#: Intrinsic times by what their number is one of.
TIMES: dict[str, type[sph.OfMesh] | type[sph.OfStep]] = {"dt": sph.OfStep, "h/c_p": sph.OfMesh}
PROJECTIONS: dict[str, AngularMomentumTreatment] = {
    "local": sph.LocalProjection(),
    "none": sph.NoProjection(),
}


def said(time: sph.OfMesh | sph.OfStep | float) -> str:
    """``0.5 h/c_p``, ``0.1 dt``."""
    known = as_time(time)
    return f"{known.c:.3g} {known.unit}"


def instants_of(sim: Solver) -> Iterator[Snapshot]:
    """Run one period of a scene with an exact solution: what it is at the instants."""
    exact = sim.scene.known_solution()
    for k in range(INSTANTS):
        march(sim, until=(k + 0.5) * exact.period / INSTANTS)
        yield sim.snapshot()


def period_errors_of(sim: Solver) -> dict[str, float]:
    """Run one period of a scene with an exact solution; errors as :func:`period_errors` gives."""
    exact = sim.scene.known_solution()
    return period_errors(instant_errors(snapshot, exact) for snapshot in instants_of(sim))


def cube_scene(scene: str, family: str, **options: float) -> Scene:
    """The cube in the ``"linear"`` limit, or ``"manufactured"`` at the amplitude of the study."""
    manufactured = scene == "manufactured"
    amplitude = (
        amplitude_of_gradient(family, LARGEST_GRADIENT)  # type: ignore[arg-type]
        if manufactured
        else LINEAR_AMPLITUDE
    )
    return swinging_cube(
        family=family,  # type: ignore[arg-type]
        amplitude=amplitude,
        manufactured=manufactured,
        **options,  # type: ignore[arg-type]
    )


def run_case(
    *,
    scene: str,
    family: str,
    poisson_ratio: float,
    method: str,
    formulation: str,
    secondary: str,
    operator: str,
    projection: str,
    xi_F: float,
    tau_p: float,
    cells: int,
) -> list[dict[str, Any]]:
    """Twelve rows, one per component of momentum and stress."""
    started = time.perf_counter()
    problem = cube_scene(scene, family, poisson_ratio=poisson_ratio)
    sim: Any
    if method == "B-bar FEM":
        sim = fem.Simulation(problem, spacing=1.0 / cells, element=fem.BBarHex())
        particles = (cells + 1) ** 3
    else:
        stabilisation = (
            sph.SUPG(tau_F=1.0, xi_F=xi_F, tau_p=tau_p, secondary=SECONDARY[secondary])
            if method == "SUPG-SPH"
            else sph.NoStabilisation()
        )
        sim = sph.Simulation(
            problem,
            spacing=1.0 / cells,
            formulation=FORMULATIONS[formulation](),
            stabilisation=stabilisation,
            operator=OPERATORS[operator],
            angular_momentum=PROJECTIONS[projection],
            # The paper's integrator and CFL number, so that the orders are those of its scheme.
            integrator=sph.TVDRK2(),
            cfl=0.3,
        )
        particles = sim.cloud.size
    errors = period_errors_of(sim)
    wall = time.perf_counter() - started
    common = {
        "scene": scene,
        "nu": poisson_ratio,
        "family": family,
        "method": method,
        "formulation": formulation,
        "secondary": secondary,
        "operator": operator,
        "projection": projection,
        "xi_F": xi_F,
        "tau_p": tau_p,
    }
    return [
        common
        | {
            "field": name.split("_")[0],
            "component": name.split("_")[1],
            "h": 1.0 / cells,
            "particles": particles,
            "steps": sim.step,
            "error": error,
            "wall_s": wall,
        }
        for name, error in errors.items()
    ]
