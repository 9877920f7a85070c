"""The timings: whole steps, single passes, the machine, the start of a process, the column."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import set_threads
from sphsolid.defaults import default_stabilisation
from sphsolid.scenes import swinging_cube, twisting_column
from studies.convergence.cases import FORMULATIONS, SECONDARY
from studies.speed import machine
from studies.speed.passes import passes, update_bytes
from studies.speed.plain_step import PlainStepper

#: Fastest of this many timings; the machine is shared, the minimum is what it can do.
REPEATS = 5
INTEGRATORS: dict[str, Any] = {
    each.name: each for each in (sph.TVDRK2(), sph.SSPRK3(), sph.PositionVerlet())
}
_START = """
import time
started = time.perf_counter()
import sphsolid as sph
from sphsolid.scenes import twisting_column
sim = sph.Simulation(twisting_column(), spacing=0.5)
sim.advance(sim.stable_time_step())
print(time.perf_counter() - started)
"""


def _fastest(run: Callable[[], object], repeats: int = REPEATS) -> float:
    best = float("inf")
    for _ in range(repeats):
        started = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - started)
    return best


def _steps(sim: Any, size: int, threads: int, work: float) -> float:
    """Seconds of a step, timed over many."""
    steps = min(100, max(2, int(work * threads / size)))

    def several() -> None:
        for _ in range(steps):
            sim.advance(sim.stable_time_step())

    sim.advance(sim.stable_time_step())
    return _fastest(several) / steps


def particles(
    *,
    formulation: str,
    secondary: str,
    weighting: str,
    tau_p: float,
    projects: bool,
    integrator: str,
    jitter: float,
    cells: int,
    threads: int,
) -> sph.Simulation:
    """The simulation that is timed."""
    set_threads(threads)
    stabilisation: Any = sph.NoStabilisation()
    if secondary != "-":
        weigh = sph.SelfAdjoint() if weighting == "self-adjoint" else sph.AsPrinted()
        stabilisation = sph.SUPG(
            tau_F=0.7, xi_F=0.0, tau_p=tau_p, secondary=SECONDARY[secondary], weighting=weigh
        )
    return sph.Simulation(
        swinging_cube(amplitude=1.0e-7, jitter=jitter),
        spacing=1.0 / cells,
        formulation=FORMULATIONS[formulation](),
        stabilisation=stabilisation,
        integrator=INTEGRATORS[integrator],
        angular_momentum=sph.LocalProjection() if projects else sph.NoProjection(),
    )


def sph_step(*, repeats_work: float = 3.0e5, **options: Any) -> list[dict[str, Any]]:
    """One row of ``table``, and one of ``passes`` for each pass."""
    started = time.perf_counter()
    sim = particles(**options)
    setup = time.perf_counter() - started
    size, threads = sim.cloud.size, options["threads"]
    seconds = _steps(sim, size, threads, repeats_work)
    share = sim.cloud.kinematic.stencil_share
    cfl = sim._time_step.cfl
    common = {
        "solver": "SUPG-SPH" if options["secondary"] != "-" else "SPH",
        "cloud": f"jitter {options['jitter']:g}" if options["jitter"] else "lattice",
        "storage": f"{share:.0%} in runs" if share else "CSR",
        **{k: options[k] for k in ("formulation", "secondary", "weighting", "tau_p", "projects")},
        "integrator": sim.integrator.name,
        "neighbours": sim.cloud.kinematic.mean_neighbours,
        "particles": size,
        "threads": threads,
    }
    rows = []
    evaluation_flops = evaluation_bytes = 0.0
    for each in passes(sim):
        each.run()
        once = _fastest(each.run, 2 * REPEATS)
        times = 1 if each.name == "time step" else sim.integrator.stages
        evaluation_flops += times * each.flops
        evaluation_bytes += times * each.bytes
        rows.append(
            common
            | {
                "kind": "pass",
                "pass": each.name,
                "ns_per_particle": 1.0e9 * once / size,
                "flops_per_particle": each.flops / size,
                "traffic_per_particle": each.bytes / size,
            }
        )
    rows.append(
        common
        | {
            "kind": "step",
            "cfl": cfl,
            "ns_per_particle_step": 1.0e9 * seconds / size,
            "ns_per_particle_crossing": 1.0e9 * seconds / size / cfl,
            "bytes_per_particle": sim.memory_bytes() / size,
            "flops_per_particle": evaluation_flops / size,
            "traffic_per_particle": (evaluation_bytes + update_bytes(sim)) / size,
            "setup_s": setup,
        }
    )
    return rows


def fem_step(*, element: str, cells: int, threads: int) -> list[dict[str, Any]]:
    """One row of ``table`` for a finite element."""
    set_threads(threads)
    started = time.perf_counter()
    sim = fem.Simulation(
        swinging_cube(amplitude=1.0e-7), spacing=1.0 / cells, element=ELEMENTS[element]()
    )
    setup = time.perf_counter() - started
    seconds = _steps(sim, cells**3, threads, 3.0e5)
    return [
        {
            "kind": "step",
            "solver": element,
            "cloud": "lattice",
            "storage": "elements",
            "formulation": "-",
            "secondary": "-",
            "weighting": "-",
            "integrator": "central differences",
            "particles": cells**3,
            "threads": threads,
            "ns_per_particle_step": 1.0e9 * seconds / cells**3,
            "setup_s": setup,
        }
    ]


ELEMENTS: dict[str, Any] = {"B-bar FEM": fem.BBarHex}


def machine_speed(*, threads: int) -> list[dict[str, Any]]:
    """Bandwidth and arithmetic of the machine, in the same run."""
    set_threads(threads)
    found = machine.measure(threads)
    return [
        {
            "kind": "machine",
            "threads": threads,
            "bandwidth": found.bandwidth,
            "flops": found.flops,
        }
    ]


def plain(*, cells: int) -> list[dict[str, Any]]:
    """The same step written with numpy and scipy's sparse matrices, on one thread."""
    options = {
        "formulation": "{p,F}", "secondary": "H1", "weighting": "as printed", "tau_p": 0.0,
        "projects": True, "integrator": "TVD-RK2", "jitter": 0.0, "threads": 1,
    }  # fmt: skip
    sim = particles(**options, cells=cells)  # type: ignore[arg-type]
    plain_step = PlainStepper(sim)
    dt = sim.stable_time_step()
    slow = _fastest(lambda: plain_step.advance(dt), 3)
    fast = _steps(sim, sim.cloud.size, 1, 3.0e5)
    return [
        {
            "kind": "plain",
            "particles": sim.cloud.size,
            "ns_plain": 1.0e9 * slow / sim.cloud.size,
            "ns_compiled": 1.0e9 * fast / sim.cloud.size,
            "ratio": slow / fast,
        }
    ]


def start_up() -> list[dict[str, Any]]:
    """Seconds from the start of a process to the end of its first step, cold and warm."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {
            "SPHSOLID_CACHE": folder,
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        took = [
            float(
                subprocess.run(
                    [sys.executable, "-c", _START],
                    env=environment,
                    capture_output=True,
                    text=True,
                    check=True,
                ).stdout
            )
            for _ in range(3)
        ]
    return [{"kind": "start", "cold_s": took[0], "warm_s": min(took[1:])}]


def column(*, integrator: str, cells: int) -> list[dict[str, Any]]:
    """CPU time and energy kept of 0.1 s of the twisting column, on one thread."""
    set_threads(1)
    chosen = INTEGRATORS[integrator]
    scene = twisting_column()
    paper = integrator == "TVD-RK2"
    sim = sph.Simulation(
        scene,
        spacing=1.0 / cells,
        formulation=sph.PFJ(),
        integrator=chosen,
        stabilisation=sph.SUPG(tau_p=0.1)
        if paper
        else default_stabilisation(sph.PFJ(), scene.material),
    )
    start = sim.snapshot()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    history = sim.run(until=0.1)
    cpu = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
    del history
    end = sim.snapshot()
    energy = [s.kinetic_energy + s.strain_energy for s in (start, end)]
    return [
        {
            "kind": "column",
            "integrator": integrator,
            "settings": "paper" if paper else "default",
            "particles": sim.cloud.size,
            "steps": sim.step,
            "evaluations": sim.step * chosen.stages,
            "cpu_s": cpu,
            "cpu_ms_per_particle": 1.0e3 * cpu / sim.cloud.size,
            "energy_kept": energy[1] / energy[0],
        }
    ]
