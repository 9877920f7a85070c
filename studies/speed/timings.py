"""The timings: whole steps, single passes, the machine, the start of a process, the column."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.compiled import set_threads
from sphsolid.defaults import is_restraint
from sphsolid.scenes import swinging_cube, twisting_column
from studies.engine.case import Row
from studies.measures.rhythm import cycle
from studies.measures.run import run
from studies.measures.turns import take_turns
from studies.methods import PAPER, Method
from studies.speed import machine
from studies.speed.passes import lean_needs, passes, update_bytes
from studies.speed.plain_step import PlainStepper

#: Fastest of this many timings; the machine is shared, the minimum is what it can do.
REPEATS = 5
#: Turns of what is timed side by side, and seconds of each.
ROUNDS, WINDOW = 9, 0.1
#: End of the column's run [s].
END = 0.1
_START = """
import time
started = time.perf_counter()
import sphsolid as sph
from sphsolid.scenes import twisting_column
sim = sph.Simulation(twisting_column(), spacing=0.5)
sim.advance(sim.stable_time_step())
print(time.perf_counter() - started)
"""


def _fastest(timed: Callable[[], object], repeats: int = REPEATS) -> float:
    best = float("inf")
    for _ in range(repeats):
        started = time.perf_counter()
        timed()
        best = min(best, time.perf_counter() - started)
    return best


def _of_step(sim: Any, size: int, threads: int, work: float) -> float:
    """Seconds of a step, timed over many."""
    steps = min(100, max(2, int(work * threads / size)))
    steps = cycle(sim) * -(-steps // cycle(sim))

    def several() -> None:
        for _ in range(steps):
            sim.advance(sim.stable_time_step())

    sim.advance(sim.stable_time_step())
    return _fastest(several) / steps


def step(
    *, method: Method, jitter: float, cells: int, threads: int, work: float = 3.0e5
) -> list[Row]:
    """One row of ``table``, and for particles one of ``passes`` for each pass."""
    set_threads(threads)
    started = time.perf_counter()
    scene = swinging_cube(amplitude=1.0e-7, jitter=jitter)
    sim = method.simulation(scene, spacing=1.0 / cells)
    setup = time.perf_counter() - started
    cloud = f"jitter {jitter:g}" if jitter else "lattice"
    common = {"method": method.name, "cloud": cloud, "cells": cells, "threads": threads}
    size = cells**3 if isinstance(sim, fem.Simulation) else sim.cloud.size
    common["particles"] = size
    seconds = _of_step(sim, size, threads, work)
    whole = {"kind": "step", "ns_per_particle_step": 1.0e9 * seconds / size, "setup_s": setup}
    if isinstance(sim, fem.Simulation):
        return [common | whole | {"storage": "elements", "integrator": "central differences"}]
    cfl = sim._time_step.cfl
    of_particles = {
        "integrator": sim.integrator.name, "cfl": cfl,
        "ns_per_particle_crossing": 1.0e9 * seconds / size / cfl,
        "bytes_per_particle": sim.memory_bytes() / size,
    }  # fmt: skip
    if is_restraint(sim.stabilisation):
        # Its passes are fused: a step is timed and counted as a whole.
        needs, lines = lean_needs(sim), isinstance(sim.operator, sph.LatticeDifference)
        of_particles |= {
            "storage": "lattice lines" if lines else _storage(sim),
            "flops_per_particle": needs.flops / size, "traffic_per_particle": needs.bytes / size,
        }  # fmt: skip
        return [common | whole | of_particles]
    stages = sim.integrator.stages
    rows, flops, moved = [], 0.0, 0.0
    for each in passes(sim):
        each.run()
        once = _fastest(each.run, 2 * REPEATS)
        times = 1 if each.name == "time step" else stages
        flops += times * each.flops
        moved += times * each.bytes
        of_pass = {
            "kind": "pass", "pass": each.name, "ns_per_particle": 1.0e9 * once / size,
            "flops_per_particle": each.flops / size, "traffic_per_particle": each.bytes / size,
        }  # fmt: skip
        rows.append(common | of_pass)
    of_particles |= {
        "storage": _storage(sim),
        "neighbours": sim.cloud.mean_neighbours,
        "flops_per_particle": flops / size,
        "traffic_per_particle": (moved + update_bytes(sim)) / size,
    }
    return [*rows, common | whole | of_particles]


@dataclass(frozen=True)
class OnThreads:
    """``sim`` with so many kernel ``threads``."""

    sim: Any
    threads: int

    @property
    def stabilisation(self) -> Any:
        """That of ``sim``, which says what a cycle is."""
        return getattr(self.sim, "stabilisation", None)

    def stable_time_step(self) -> float:
        """The step [s], from which on the threads are these."""
        set_threads(self.threads)
        return float(self.sim.stable_time_step())

    def advance(self, dt: float) -> None:
        """One step of ``sim``."""
        self.sim.advance(dt)


def in_turns(*, methods: Sequence[Method], cells: int, threads: Sequence[int]) -> list[Row]:
    """One row of ``turns`` for each method and number of threads, timed side by side."""
    scene, rows = swinging_cube(amplitude=1.0e-7), []
    sims = [method.simulation(scene, spacing=1.0 / cells) for method in methods]
    timed = take_turns(
        [OnThreads(sim, count) for sim in sims for count in threads],
        rounds=ROUNDS, window_s=WINDOW, clock=time.perf_counter,
    )  # fmt: skip
    for (method, count), each in zip(itertools.product(methods, threads), timed, strict=True):
        sim = each.sim.sim
        size = cells**3 if isinstance(sim, fem.Simulation) else sim.cloud.size
        rows.append(
            {
                "kind": "turn", "method": method.name, "cells": cells, "particles": size,
                "threads": count, "ns_per_particle_step": 1.0e9 * each.least / size,
                "spread": each.spread,
            }
        )  # fmt: skip
    return rows


def _storage(sim: sph.Simulation) -> str:
    """How the pairs are kept: one pattern for runs of particles, or rows of their own."""
    share = sim.cloud.kinematic.stencil_share
    return f"{share:.0%} in runs" if share else "CSR"


def machine_speed(*, threads: int) -> list[Row]:
    """Bandwidth [byte/s] and arithmetic [1/s] of the machine, in the same run."""
    set_threads(threads)
    found = machine.measure(threads)
    speed = {"bandwidth": found.bandwidth, "flops": found.flops}
    return [{"kind": "machine", "threads": threads} | speed]


def plain(*, cells: int) -> list[Row]:
    """The paper's step with numpy and scipy's sparse matrices, on one thread."""
    set_threads(1)
    scene = swinging_cube(amplitude=1.0e-7)
    sim = PAPER.but(formulation=sph.PF()).simulation(scene, spacing=1.0 / cells)
    size, dt, other = sim.cloud.size, sim.stable_time_step(), PlainStepper(sim)
    slow = _fastest(lambda: other.advance(dt), 3)
    fast = _of_step(sim, size, 1, 3.0e5)
    times = {"ns_plain": 1.0e9 * slow / size, "ns_compiled": 1.0e9 * fast / size}
    return [{"kind": "plain", "particles": size, "ratio": slow / fast} | times]


def start_up() -> list[Row]:
    """Seconds from the start of a process to the end of its first step, cold and warm."""
    with tempfile.TemporaryDirectory() as folder:
        paths = {"SPHSOLID_CACHE": folder, "PYTHONPATH": os.pathsep.join(sys.path)}
        took = [
            float(
                subprocess.run(
                    [sys.executable, "-c", _START],
                    env=os.environ | paths, capture_output=True, text=True, check=True,
                ).stdout
            )
            for _ in range(3)
        ]  # fmt: skip
    return [{"kind": "start", "cold_s": took[0], "warm_s": min(took[1:])}]


def column(*, method: Method, cells: int) -> list[Row]:
    """CPU time and energy kept of the twisting column until :data:`END`, on one thread."""
    set_threads(1)
    sim = method.simulation(twisting_column(), spacing=1.0 / cells)
    start = sim.snapshot()
    ran = run(sim, until=END)
    end, size = sim.snapshot(), sim.cloud.size
    energy = [s.kinetic_energy + s.strain_energy for s in (start, end)]
    return [
        {
            "kind": "column", "method": method.name, "integrator": sim.integrator.name,
            "particles": size, "steps": sim.step, "evaluations": sim.step * sim.integrator.stages,
            "cpu_s": ran.cpu_s, "cpu_ms_per_particle": 1.0e3 * ran.cpu_s / size,
            "energy_kept": energy[1] / energy[0], "survived": ran.survived, "folded": ran.folded,
        }
    ]  # fmt: skip
