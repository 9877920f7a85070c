"""One timing: a solver on the swinging cube at one size and one number of threads."""

from __future__ import annotations

import time
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import set_threads
from sphsolid.scenes import swinging_cube
from studies.convergence.cases import FORMULATIONS, SECONDARY

#: Fastest of this many timings; the machine is shared, the minimum is what it can do.
REPEATS = 5


def run_case(
    *,
    solver: str,
    formulation: str,
    secondary: str,
    tau_p: float,
    jitter: float,
    cells: int,
    threads: int,
) -> list[dict[str, Any]]:
    """One row: nanoseconds per particle-step (element-step for FEM), memory, set-up seconds."""
    set_threads(threads)
    scene = swinging_cube(amplitude=1.0e-7, jitter=jitter)
    started = time.perf_counter()
    sim: Any
    if solver == "B-bar FEM":
        sim = fem.Simulation(scene, spacing=1.0 / cells)
        size, memory = cells**3, float("nan")
    else:
        stabilisation = (
            sph.NoStabilisation()
            if secondary == "-"
            else sph.SUPG(tau_p=tau_p, secondary=SECONDARY[secondary])
        )
        sim = sph.Simulation(
            scene,
            spacing=1.0 / cells,
            formulation=FORMULATIONS[formulation](),
            stabilisation=stabilisation,
            integrator=sph.TVDRK2(),
        )
        size = sim.cloud.size
        memory = sim.memory_bytes() / size
    setup = time.perf_counter() - started
    # About a third of a second a timing, so that the clock and the launches do not matter.
    steps = max(2, int(3.0e5 * threads / size))
    sim.advance(sim.stable_time_step())
    best = float("inf")
    for _ in range(REPEATS):
        started = time.perf_counter()
        for _ in range(steps):
            sim.advance(sim.stable_time_step())
        best = min(best, (time.perf_counter() - started) / steps)
    return [
        {
            "solver": solver,
            "cloud": f"jitter {jitter:g}" if jitter else "lattice",
            "storage": "one element" if solver == "B-bar FEM" else "CSR",
            "formulation": formulation,
            "secondary": secondary,
            "tau_p": tau_p,
            "particles": size,
            "threads": threads,
            "ns_per_particle_step": 1.0e9 * best / size,
            "bytes_per_particle": memory,
            "setup_s": setup,
        }
    ]
