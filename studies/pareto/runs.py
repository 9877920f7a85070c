"""One run of a problem: its errors and the work that is counted.

*Counted work* of one evaluation, from the data structures and the equations, whatever the storage:
values gathered through an index list and the multiply-adds done with them,

    particles:  gradient of v, force, geometry for the projection; at the secondary particles the
                fine-scale stress and back; with tau_p the residual of momentum and back;
    restraint:  F and force; positions and velocities of the near pairs, or of the lines of a
                lattice, with F and its rate of the pairs, and back, where its viscosity acts;
    elements:   positions of the nodes, deformation and force at the Gauss points, and back;

and the fields that are streamed through, whose number a formulation decides: value, rate and start
of a step of each evolved one, and the stress.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import fem_reference as fem
import sphsolid as sph
from sphsolid.geometry.edges import edges_of
from studies.engine.case import Row
from studies.methods import Elements, Method
from studies.pareto.problems import PROBLEMS

# --- what it costs --------------------------------------------------------------------------------

#: Bytes of a number.
REAL = 8
#: Nodes and Gauss points of an element, by its name.
ELEMENTS = {"b_bar_hex": (8, 8), "taylor_hood_hex": (27, 27)}


def evaluations_per_step(sim: Any) -> int:
    """Force evaluations of a step."""
    return 1 if isinstance(sim, fem.Simulation) else int(sim.integrator.stages)


@dataclass(frozen=True)
class Work:
    """Work of one evaluation: ``pairs`` visited, ``gathered`` and ``streamed`` bytes,
    ``multiply_adds`` at the pairs.
    """

    pairs: float
    gathered: float
    multiply_adds: float
    streamed: float = 0.0

    def __add__(self, other: Work) -> Work:
        return Work(
            self.pairs + other.pairs,
            self.gathered + other.gathered,
            self.multiply_adds + other.multiply_adds,
            self.streamed + other.streamed,
        )

    @classmethod
    def of(cls, pairs: float, values: int, multiply_adds: int) -> Work:
        """``values`` numbers gathered and so many multiply-adds at each of ``pairs`` visits."""
        return cls(pairs, REAL * values * pairs, multiply_adds * pairs)


def counted_work(sim: Any) -> Work:
    """Work of one evaluation of the right-hand side of ``sim``."""
    if isinstance(sim, fem.Simulation):
        return _of_elements(sim)
    cloud, fields = sim.cloud, sim.formulation
    pairs = cloud.size * cloud.mean_neighbours
    if isinstance(sim.stabilisation, sph.Restraint):
        return _of_restraint(sim, pairs)
    # grad v, div P; F_x for the projection, and F itself where it is not evolved.
    work = Work.of(pairs, 3, 9) + Work.of(pairs, 9, 9)
    projects = isinstance(sim.angular_momentum, sph.LocalProjection)
    for _ in range(int(projects) + int(not fields.evolves_F)):
        work += Work.of(pairs, 3, 9)
    if isinstance(sim.stabilisation, sph.SUPG):
        work += _of_stabilisation(sim)
    evolved = 6 + 9 * fields.evolves_F + 9 * fields.evolves_H + fields.evolves_J
    return work + Work(0.0, 0.0, 0.0, REAL * (3.0 * evolved + 9.0) * cloud.size)


def _of_restraint(sim: sph.Simulation, pairs: float) -> Work:
    size = sim.cloud.size
    fields = Work(0.0, 0.0, 0.0, REAL * (3.0 * 6.0 + 9.0) * size)
    if isinstance(sim.cloud.kind, sph.LatticeDifference):
        # Along its line a neighbour gives one column of F and takes one of P; five of them a line.
        return fields + Work.of(pairs, 6, 6) + Work.of(3.0 * 5.0 * size, 9, 9)
    near = 2.0 * len(edges_of(sim.cloud.mesh).a)
    return fields + Work.of(pairs, 12, 18) + Work.of(near, 3 + 3 + 9 + 9 + 12, 45)


def _of_stabilisation(sim: sph.Simulation) -> Work:
    supg, secondary = sim.stabilisation, sim.secondary
    assert isinstance(supg, sph.SUPG)
    assert secondary is not None
    pairs = len(secondary.X) * secondary.sampling.mean_neighbours
    # Velocity, the tensor that is interpolated, and the positions; then D(p).
    work = Work.of(pairs, 3 + 9 + 3, 27) + Work.of(pairs, 9, 9)
    if supg.is_self_adjoint:
        # The fine stress back to the particles, and F_x there to project it.
        primary = sim.cloud.size * sim.cloud.mean_neighbours
        work += Work.of(pairs, 9, 9) + Work.of(primary, 3, 9)
    if supg.damps_J:
        work += Work.of(pairs, 9 + 3, 12) + Work.of(pairs, 3, 3)
    return work


def _of_elements(sim: fem.Simulation) -> Work:
    nodes, points = ELEMENTS[sim.element.name]
    visits = sim.elements * nodes
    # Positions in, F and force at every point, element forces out and gathered at the nodes.
    # Position, velocity and acceleration of the nodes.
    streamed = REAL * 9.0 * len(sim.snapshot().X)
    return Work(visits, REAL * 9.0 * visits, 18.0 * points * visits, streamed)


# --- a run ----------------------------------------------------------------------------------------


def run_case(
    *, scene: str, nu: float, method: Method, cells: int, until: float, compared: bool
) -> list[Row]:
    """Rows of two kinds: one ``run``, and for the column an ``instant`` a record.

    What only serves as reference is not ``compared`` and has no cost.

    Bits do not depend on the number of threads, so the error comes from a run on all of them.
    """
    problem, elements = PROBLEMS[scene], isinstance(method.recipe, Elements)
    sim = method.simulation(problem.stated(nu, cells, elements=elements), spacing=1.0 / cells)
    started = time.process_time()
    found, instants = problem.errors(sim, nu, cells, until)
    found |= {
        "particles": len(sim.snapshot().X), "end_time": sim.time,
        "error_run_cpu_s": time.process_time() - started,
    }  # fmt: skip
    named = {"scene": scene, "nu": nu, "method": method.name, "cells": cells}
    work = _counted(sim) if compared else {}
    rows = [{"kind": "run"} | named | setting(sim) | found | work]
    return rows + [{"kind": "instant"} | named | row for row in instants]


def setting(sim: Any) -> Row:
    """Columns ``solver, formulation, stabilisation, operator, projection, integrator``."""
    if isinstance(sim, fem.Simulation):
        return {"solver": "FEM"}
    return {
        "solver": "SPH",
        "formulation": sim.formulation.name,
        "stabilisation": _stabilisation(sim.stabilisation),
        "operator": sim.operator.name,
        "projection": "none" if sim.angular_momentum == sph.NoProjection() else "local",
        "integrator": sim.integrator.name,
    }


def _stabilisation(option: Any) -> str:
    if isinstance(option, sph.SUPG):
        return f"SUPG-{option.secondary.name}"
    return "restraint" if isinstance(option, sph.Restraint) else "none"


def _counted(sim: Any) -> Row:
    work = counted_work(sim)
    return {
        "evaluations_per_step": evaluations_per_step(sim), "pairs": work.pairs,
        "gathered_bytes": work.gathered, "streamed_bytes": work.streamed,
        "multiply_adds": work.multiply_adds,
    }  # fmt: skip
