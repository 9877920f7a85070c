"""One hard case with one method: whether it lasts, and where its energy went."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fem_reference as fem
from sphsolid.record import History, Snapshot
from sphsolid.scenes import HeldVelocity, InitialVelocity, punch, twisting_column
from studies.report.indicators import whole_turns
from studies.stability.hard_case_methods import Method, Simulation
from studies.stability.hard_case_scenes import SEED, alternating, block, pulled_block, seeded_block
from studies.stability.hard_case_watch import Kept, Share, TopTwist, run_to_end

Array = NDArray[np.float64]


def energy_balance(history: History) -> dict[str, float]:
    """Shares of the largest energy put in so far: what is kept, dissipated, made, and by whom.

    Put in: what was there and the works of loads and prescribed motion.  ``kept`` at the end;
    ``gain`` the largest excess over what was put in, at any record; ``projection``, ``defect``
    and ``rest`` (the time integrator) at the end, positive where energy was made; dissipated by
    ``D(p)`` and by ``D(J)``, negative where the stabilisation made energy.
    """
    total = history["total_energy [J]"]
    work = sum(history[f"work_{name} [J]"] for name in ("traction", "body_force", "constraint"))
    put_in = total[0] + work
    scale = np.maximum.accumulate(np.maximum(put_in, np.finfo(float).tiny))
    return {
        "energy_kept": float(total[-1] / scale[-1]),
        "energy_gain": float(np.max((total - put_in) / scale)),
        "dissipated_p": float(-history["dissipation_p [J]"][-1] / scale[-1]),
        "dissipated_J": float(-history["dissipation_J [J]"][-1] / scale[-1]),
        "energy_projection": float(history["work_projection [J]"][-1] / scale[-1]),
        "energy_defect": float(history["work_adjoint_defect [J]"][-1] / scale[-1]),
        "energy_rest": float(history["energy_rest [J]"][-1] / scale[-1]),
    }


def _row(history: History, lost: dict[str, Any], solver: Simulation) -> dict[str, Any]:
    noise = history["noise"]
    return lost | energy_balance(history) | {
        "particles": len(solver.snapshot().X),
        "operator": "-" if isinstance(solver, fem.Simulation) else solver.operator.name,
        "J_min": float(np.min(history["J_min"])),
        "J_max": float(np.max(history["J_max"])),
        "unseen_rms": float(np.max(history["unseen_rms [-]"])),
        "unseen_max": float(np.max(history["unseen_max [-]"])),
        "inside_out": float(np.max(history["inside_out_share [-]"])),
        "smallest_det": float(np.min(history["smallest_det [-]"])),
        "noise_end": float(noise[-1]),
        # Early on hardly any pressure is there, and its noise says nothing.
        "noise_max": float(np.max(noise[len(noise) // 2 :])),
    }


def run(
    *, case: str, method: Mapping[str, Any], kind: str, cells: int,
    arguments: Mapping[str, Any],
) -> list[dict[str, Any]]:  # fmt: skip
    """One row; ``kind`` names a function of :data:`KINDS`, which gets ``arguments``."""
    started = time.perf_counter()
    chosen = Method(**method)
    row = KINDS[kind](chosen, cells, **arguments)
    wall = time.perf_counter() - started
    settings = {key: value for key, value in method.items() if key != "name"}
    return [
        {"part": "hard", "case": case, "method": chosen.name, "cells": cells}
        | settings | row | {"wall_s": wall}
    ]  # fmt: skip


def column(method: Method, cells: int, *, jitter: float = 0.0, **scene: float) -> dict[str, Any]:
    """The twisting column; answer: the largest twist of its top [rad]."""
    problem = twisting_column(**scene)
    problem = replace(problem, body=replace(problem.body, jitter=jitter))  # type: ignore[type-var]
    solver = method.build(problem, 1.0 / cells)
    history, lost = run_to_end(solver, TopTwist())
    twist = [0.0]
    for angle in history["angle"]:
        twist.append(whole_turns(angle, twist[-1]))
    row = _row(history, lost, solver)
    return row | {"answer": float(np.max(np.abs(twist))), "answer_is": "largest twist [rad]"}


def pressed(method: Method, cells: int, *, held: bool, end_time: float) -> dict[str, Any]:
    """The punch; answer: how high its top stands at the end over the undeformed one [m]."""
    press = HeldVelocity() if held else InitialVelocity()
    solver = method.build(punch(press=press, end_time=end_time), 1.0 / cells)
    history, lost = run_to_end(solver)
    end = solver.snapshot()
    row = _row(history, lost, solver)
    height = float(np.max(end.x[:, 2]) - np.max(end.X[:, 2]))
    return row | {"answer": height, "answer_is": "bulge of the top [m]"}


def seeded(method: Method, cells: int, *, pattern: str) -> dict[str, Any]:
    """A seed in the velocity; answer: its share in the last quarter over that at the start.

    For ``noise``, which is no one mode, the root of the energy at the end over that at the start.
    """
    problem = seeded_block(pattern=pattern, spacing=1.0 / cells)  # type: ignore[arg-type]
    solver = method.build(problem, 1.0 / cells)
    X = solver.snapshot().X
    axes = {"sawtooth": "x", "hourglass": "xyz"}.get(pattern, "xyz")
    history, lost = run_to_end(solver, Share(alternating(X, 1.0 / cells, axes)))
    measure = history["share"]
    if pattern == "noise":
        measure = np.sqrt(np.abs(history["total_energy [J]"]))
    return _row(history, lost, solver) | _ratio(measure)


def checkerboard(method: Method, cells: int) -> dict[str, Any]:
    """``J = 1 +- 1e-4`` in a checkerboard; answer: its share in the last quarter over the first.

    Seeded in ``F`` (and its cofactor) where ``J`` is ``det F``; a method whose ``J`` follows from
    the positions has nothing to seed, its row says so.
    """
    solver = method.build(block(), 1.0 / cells)
    if isinstance(solver, fem.Simulation) or not solver.formulation.evolves_F:
        nothing = {"survived": True, "applicable": False, "reason": "J follows from positions"}
        return nothing | {"particles": len(solver.snapshot().X), "steps": 0}
    pattern = alternating(solver.cloud.X, 1.0 / cells)
    state = solver.state
    if len(state.J):
        state.J *= 1.0 + SEED * pattern
    else:
        state.F *= np.cbrt(1.0 + SEED * pattern)[:, None, None]
    history, lost = run_to_end(solver, Share(pattern, "J"))
    return _row(history, lost, solver) | _ratio(history["share"])


def _ratio(measure: Array) -> dict[str, Any]:
    last = np.max(np.abs(measure[-max(1, len(measure) // 4) :]))
    return {"answer": float(last / np.abs(measure[0])), "answer_is": "seed left [-]"}


def pulled(method: Method, cells: int) -> dict[str, Any]:
    """Uniform tension to stretch 2, with and without noise; answer: growth of the noise.

    The difference of the two runs' velocities, root mean square at its largest over that at the
    start; ``clumping`` is the largest change of a cell edge by the noise, over the edge.
    """
    solvers = [method.build(pulled_block(noisy=noisy), 1.0 / cells) for noisy in (False, True)]
    start = _difference(solvers)
    kept = [Kept(), Kept()]
    found = [run_to_end(*pair) for pair in zip(solvers, kept, strict=True)]
    history, lost = found[1] if found[0][1]["survived"] else found[0]
    row = _row(history, lost, solvers[0])
    both = list(zip(kept[0].shots, kept[1].shots, strict=False))
    growth = [_rms(a.velocity - b.velocity) / start for a, b in both]
    return row | {
        "answer": float(max(growth)),
        "answer_is": "noise growth [-]",
        "noise_left": float(growth[-1]),
        "clumping": _clumping(*both[-1]),
    }


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _difference(solvers: list[Simulation]) -> float:
    clean, noisy = (solver.snapshot().velocity for solver in solvers)
    return _rms(clean - noisy)


def _clumping(clean: Snapshot, noisy: Snapshot) -> float:
    cells = clean.mesh.cells
    change = 0.0
    for a, b in ((0, 1), (1, 2), (3, 2), (0, 3), (4, 5), (5, 6), (7, 6), (4, 7), (0, 4), (1, 5),
                 (2, 6), (3, 7)):  # fmt: skip
        before, after = (
            np.linalg.norm(shot.x[cells[:, b]] - shot.x[cells[:, a]], axis=1)
            for shot in (clean, noisy)
        )
        change = max(change, float(np.max(np.abs(after / before - 1.0))))
    return change


KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "column": column, "pressed": pressed, "seeded": seeded, "checkerboard": checkerboard,
    "pulled": pulled,
}  # fmt: skip
