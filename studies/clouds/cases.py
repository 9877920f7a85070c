"""The swinging cube on one cloud at one level with one operator: the unit of work."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

import sphsolid as sph
from sphsolid.cloud import OperatorKind
from sphsolid.errors import Diverged
from sphsolid.record import Recovery, Snapshot, instant_errors, period_errors
from sphsolid.scenes import Scene
from sphsolid.scenes.scene import ExactSolution
from studies.clouds.choice import Cloud, Instance, cloud_of, label_of
from studies.convergence.cases import FORMULATIONS, cube_scene, instants_of
from studies.report.folding import folding

#: Variant of rows whose stress was recovered from the particles' around.
RECOVERED = "recovered stress"
OPERATORS: dict[str, OperatorKind] = {
    "Literal": sph.Literal(),
    "Consistent": sph.Consistent(),
    "SummationByParts": sph.SummationByParts(),
}


def cube_on(instance: Instance, *, scene: str, family: str) -> Scene:
    """The swinging cube with the particles of a cloud."""
    return replace(cube_scene(scene, family), body=instance.body)


STARTS: dict[str, Any] = {
    "": None, "compatible": sph.Compatible(), "given": sph.Given(),
    "equilibrated": sph.Equilibrated(),
}  # fmt: skip


def operator_of(name: str, epsilon: float = 0.0, tolerance: float = 0.0) -> OperatorKind:
    """By name; positive ``epsilon`` and ``tolerance`` are those of ``SummationByParts``."""
    changed: dict[str, Any] = {"epsilon": epsilon, "tolerance": tolerance}
    changed = {what: value for what, value in changed.items() if value > 0.0}
    return sph.SummationByParts(**changed) if changed else OPERATORS[name]


def about_the_set_up(sim: sph.Simulation) -> dict[str, Any]:
    """What a set-up gave: particles, neighbours, residuals, size of the change, effort."""
    counts = np.diff(sim.cloud.pairs.indptr)
    found = sim.consistency
    return {
        "particles": sim.cloud.size,
        "secondary": 0 if sim.secondary is None else len(sim.secondary.V),
        "neighbours": float(counts.mean()) - 1.0,
        "least_neighbours": int(counts.min()) - 1,
        "h_min_over_dx": sim.cloud.h_min / sim.cloud.spacing,
        "change": sim.cloud.change,
        "iterations": sim.cloud.iterations,
        "C0": found.C0,
        "C1": found.C1,
        "D0": found.D0,
        "SBP": found.SBP,
        "volume": found.volume,
        "setup_s": sim.setup_seconds,
    }


def errors_of(
    snapshots: list[Snapshot], exact: ExactSolution, spacing: float
) -> dict[str, dict[str, float]]:
    """Errors of one period: ``""`` of the state itself, :data:`RECOVERED` with recovered stress."""
    recovery = Recovery()
    fitted = [
        replace(snapshot, P=recovery(snapshot.field("P"), spacing=spacing).values)
        for snapshot in snapshots
    ]
    return {
        added: period_errors(instant_errors(snapshot, exact) for snapshot in chosen)
        for added, chosen in (("", snapshots), (RECOVERED, fitted))
    }


def cube(
    *,
    cloud: str,
    level: int,
    operator: str,
    runs: list[list[str]],
    epsilon: float = 0.0,
    tolerance: float = 0.0,
    h_over_dx: float = 0.0,
    start: str = "",
    variant: str = "",
) -> list[dict[str, Any]]:
    """Rows of every run ``[scene, family, formulation]``: set-up once, then twelve errors each.

    Twelve more with the stress recovered (``Recovery()``), as a variant of their own.
    Package defaults but for the operator, what is positive, and ``start`` (of the strain) if any.
    """
    chosen: Cloud = cloud_of(cloud)
    instance = chosen.at(level)
    common = {
        "cloud": label_of(cloud), "operator": operator, "variant": variant, "h": instance.h,
    }  # fmt: skip
    rows: list[dict[str, Any]] = []
    for scene, family, formulation in runs:
        sim = sph.Simulation(
            cube_on(instance, scene=scene, family=family),
            spacing=instance.spacing,
            formulation=FORMULATIONS[formulation](),
            operator=operator_of(operator, epsilon, tolerance),
            h_over_dx=h_over_dx or None,
            initial_strain=STARTS[start],
        )
        if not rows:
            # Later set-ups read the operator from the disk: the first tells what it costs.
            rows.append(common | {"kind": "set-up"} | about_the_set_up(sim))
        started = time.perf_counter()
        setting = common | {"scene": scene, "family": family, "formulation": formulation}
        try:
            snapshots = list(instants_of(sim))
        except Diverged as failure:
            rows.append(setting | {"kind": "lost", "why": failure.reason, "steps": sim.step})
            continue
        if folding(sim)["folded"]:
            since = folding(sim)["folded_at"]
            why = f"positions folded by {since:.3g} s"
            rows.append(setting | {"kind": "lost", "why": why, "steps": sim.step})
            continue
        run_s = time.perf_counter() - started
        errors = errors_of(snapshots, sim.scene.known_solution(), instance.h)
        rows += [
            setting
            | {
                "kind": "error",
                "variant": ", ".join(part for part in (variant, added) if part),
                "field": name.split("_")[0],
                "component": name.split("_")[1],
                "particles": sim.cloud.size,
                "steps": sim.step,
                "error": error,
                "step_ms": 1.0e3 * run_s / sim.step,
            }
            for added, found in errors.items()
            for name, error in found.items()
        ]
    return rows
