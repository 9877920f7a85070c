"""Free bodies of every shape and cloud: what is conserved when nothing acts on them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.errors import Diverged, InputError
from sphsolid.geometry import Blocks, MeshFile
from sphsolid.geometry.body import AS_MESHED, Body
from sphsolid.record import MomentumDrift, judge_positions
from sphsolid.scenes import Scene
from studies.clouds.cases import about_the_set_up, operator_of
from studies.clouds.choice import Instance, cloud_of
from studies.convergence.cases import FORMULATIONS
from studies.harness.cases import ROOT

Array = NDArray[np.float64]
MESHES = ROOT / "studies" / "meshes"
#: Rubber-like and compressible: the cube's material.
SOLID = sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.3, density=1100.0)
STEPS = 60
_L = (((0.0, 0.0, 0.0), (3.0, 10.0, 3.0)), ((3.0, 0.0, 0.0), (6.0, 3.0, 3.0)))

#: Shape -> clouds of it: a file, the jitter of an L-block, or a cloud of the cube.
SHAPES: dict[str, dict[str, str]] = {
    "cube": {
        "lattice": "lattice", "jitter 0.4": "jitter:0.4", "tet": "tet",
        "hex file": "hex:studies/meshes/cube_hex_8.msh",
        "tet file": "tet:studies/meshes/cube_tet_8.msh",
    },
    "cylinder": {"hex file": "cylinder_hex.msh", "tet file": "cylinder_tet.msh"},
    "plate with a hole": {
        "hex file": "plate_with_hole_hex.msh", "tet file": "plate_with_hole_tet.msh",
    },
    "L-block": {"lattice": "0.0", "jitter 0.2": "0.2", "jitter 0.4": "0.4"},
}  # fmt: skip


def instance_of(shape: str, cloud: str) -> Instance:
    """The body of a shape with particles of a cloud."""
    what = SHAPES[shape][cloud]
    if shape == "cube":
        chosen = cloud_of(what)
        return chosen.at(chosen.levels(8)[-1])
    if shape == "L-block":
        return Instance(Blocks(_L, jitter=float(what)), 0.6, 0.6)
    body: Body = MeshFile(MESHES / what)
    return Instance(body, AS_MESHED, body.mesh(AS_MESHED).spacing)


def free_body(body: Body, centre: Array, size: float) -> Scene:
    """Spinning, shearing and breathing, with nothing symmetric about it; strains of some 5 %."""
    speed = 0.05 * reference_p_wave_speed(SOLID)

    def velocity(X: Array) -> Array:
        x, y, z = ((X - centre) / size).T
        spin = np.stack([0.3 * z - y, x, -0.3 * x], axis=1)
        strain = np.stack([x * y + 0.2, z**2 - x, y * z + 0.5 * x], axis=1)
        return speed * (spin + 0.4 * strain)

    return Scene(
        name="free_body", body=body, material=SOLID, end_time=1.0, initial_velocity=velocity
    )


def conservation(
    *, shape: str, cloud: str, operator: str, formulation: str
) -> list[dict[str, Any]]:
    """One row: the set-up, and the drift of both momenta in :data:`STEPS` steps."""
    row: dict[str, Any] = {
        "kind": "conservation", "shape": shape, "cloud": cloud, "operator": operator,
        "formulation": formulation,
    }  # fmt: skip
    instance = instance_of(shape, cloud)
    X = instance.body.mesh(instance.spacing).vertices
    scene = free_body(instance.body, X.mean(axis=0), float(np.max(np.ptp(X, axis=0))))
    try:
        sim = sph.Simulation(
            scene,
            spacing=instance.spacing,
            formulation=FORMULATIONS[formulation](),
            operator=operator_of(operator),
        )
    except InputError as refusal:
        return [row | {"outcome": "refused", "why": str(refusal)}]
    row |= about_the_set_up(sim)
    sim.track_budget()
    started = time.perf_counter()
    try:
        for _ in range(STEPS):
            sim.advance(sim.stable_time_step())
    except Diverged as failure:
        return [row | {"outcome": "lost", "why": failure.reason, "steps": sim.step}]
    end = sim.snapshot()
    positions = judge_positions(end)
    if positions.folded:
        return [row | {"outcome": "folded", "why": str(positions), "steps": sim.step}]
    drift = MomentumDrift().record(end, scene)
    return [
        row
        | {
            "outcome": "kept",
            "why": "",
            "steps": sim.step,
            "step_ms": 1.0e3 * (time.perf_counter() - started) / sim.step,
            "linear_drift": drift["linear_drift [kg m/s]"] / drift["linear_scale [kg m/s]"],
            "angular_drift": (
                drift["angular_drift [kg m^2/s]"] / drift["angular_scale [kg m^2/s]"]
            ),
        }
    ]
