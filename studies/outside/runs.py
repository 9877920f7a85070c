"""One run by CalculiX, or by one of our methods: the units of work of the study."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from sphsolid.record import Snapshot
from sphsolid.scenes import Scene
from studies.engine.case import Row
from studies.measures.run import run
from studies.methods import Method
from studies.outside.calculix import read, read_frequencies, solve, version
from studies.outside.deck import Deck, Frequencies, deck
from studies.outside.problems import FREQUENCY, HERTZ, Problem, frequency_name, mesh_of
from studies.outside.states import State
from studies.stability.waves import vibrating_block, vibration

#: What tells runs of CalculiX apart, and what they cost; ours have no step and no version.
OUTSIDE = ("problem", "level", "elements", "nodes", "step_ms", "alpha", "version", "wall_s")
OURS = (
    "problem", "method", "level", "points", "survived", "folded", "steps", "wall_s",
)  # fmt: skip


@dataclass(frozen=True)
class Places:
    """A recorder that keeps the state of each record but the first, and adds no column.

    The first is the start, which CalculiX does not write.
    """

    #: Not in its repr, which every record asks for: all arrays would be printed each time.
    states: list[State] = field(default_factory=list, repr=False)

    def record(self, snapshot: Snapshot, scene: Scene) -> dict[str, float]:
        """No column."""
        if snapshot.time > 0.0:
            energy = snapshot.kinetic_energy + snapshot.strain_energy
            self.states.append(
                State(snapshot.time, snapshot.X.copy(), snapshot.x.copy(), float(energy))
            )
        return {}


def run_outside(*, problem: Problem, level: int) -> list[Row]:
    """A row a quantity of ``problem``, by CalculiX on ``level``."""
    implicit = problem.implicit
    made = deck(problem.scene(level), mesh_of(problem, level), implicit)
    text, wall_s = solve(made)
    nodes = made.elements.nodes
    answer = read(text, len(nodes))
    energy = answer.strain_energy + answer.kinetic_energy
    states = [
        State(float(t), nodes, nodes + u, float(e))
        for t, u, e in zip(answer.time, answer.u, energy, strict=True)
    ]
    named = _outside(problem.name, level, made, 1e3 * implicit.step, implicit.alpha, wall_s)
    return [named | {"quantity": q, "value": v} for q, v in problem.read(states).items()]


def frequency_outside(*, nu: float, level: int) -> list[Row]:
    """The lowest frequency of the clamped block, by CalculiX with ``level`` elements a metre."""
    scene = vibrating_block(nu)
    mesh = scene.body.mesh(1.0 / level)
    made = deck(scene, mesh, Frequencies())  # type: ignore[arg-type]
    text, wall_s = solve(made)
    value = float(read_frequencies(text)[0]) / HERTZ
    named = _outside(frequency_name(nu), level, made, np.nan, np.nan, wall_s)
    return [named | {"quantity": FREQUENCY, "value": value}]


def _outside(
    problem: str, level: int, made: Deck, step_ms: float, alpha: float, wall_s: float
) -> Row:
    return {
        "of": "calculix", "problem": problem, "level": level,
        "elements": len(made.elements.cells), "nodes": len(made.elements.nodes),
        "step_ms": step_ms, "alpha": alpha, "version": f"CalculiX {version()}", "wall_s": wall_s,
    }  # fmt: skip


def run_ours(*, problem: Problem, method: Method, level: int) -> list[Row]:
    """A row a quantity of ``problem``, by ``method`` on ``level``; nan where it diverged."""
    solver = method.simulation(problem.scene(level), spacing=problem.spacing(level))
    places, times = Places(), problem.implicit
    ran = run(solver, until=times.until, every=times.every, record=[places])
    named = {
        "of": "ours", "problem": problem.name, "method": method.name, "level": level,
        "points": len(solver.snapshot().X), "survived": ran.survived, "folded": ran.folded,
        "steps": ran.steps, "wall_s": ran.wall_s,
    }  # fmt: skip
    found = problem.read(places.states) if ran.survived else {"none": np.nan}
    return [named | {"quantity": q, "value": v} for q, v in found.items()]


def started(*, problem: Problem, method: Method, level: int) -> list[Row]:
    """No row: a thousandth of a run, which compiles what it needs."""
    solver = method.simulation(problem.scene(level), spacing=problem.spacing(level))
    solver.run(until=1.0e-3 * problem.implicit.until)
    return []


def frequency_ours(*, nu: float, method: Method, level: int) -> list[Row]:
    """The lowest frequency of the clamped block, by ``method`` with ``level`` cells a metre."""
    (found,) = vibration(method=method, nu=nu, cells=level)
    return [
        {
            "of": "ours", "problem": frequency_name(nu), "method": method.name, "level": level,
            "points": np.nan, "survived": found["survived"], "folded": found["folded"],
            "steps": found["steps"], "wall_s": found["wall_s"],
            "quantity": FREQUENCY, "value": found["omega"] / HERTZ,
        }
    ]  # fmt: skip
