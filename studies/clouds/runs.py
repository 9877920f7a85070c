"""What is run on a cloud: the swinging cube, free bodies, the energy budget, the spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.continuum import reference_p_wave_speed
from sphsolid.defaults import default_cfl, default_integrator
from sphsolid.errors import InputError
from sphsolid.geometry import Blocks, MeshFile
from sphsolid.geometry.body import AS_MESHED, Body
from sphsolid.record import (
    EnergyBudget,
    MomentumDrift,
    Recovery,
    Snapshot,
    instant_errors,
    judge_positions,
    period_errors,
)
from sphsolid.scenes import Scene
from sphsolid.scheme.formulation import Formulation
from studies.clouds.choice import Instance, cloud_of, label_of
from studies.engine.study import Row
from studies.measures.run import attempt
from studies.measures.swinging_cube import cube_scene, instants_of
from studies.meshes import MESHES
from studies.methods import Method
from studies.stability.spectrum import Linearisation
from studies.stability.spectrum_growth import decades, largest_modulus, limits, scan

Array = NDArray[np.float64]
#: Scene, family of solutions and formulation.
Setting = tuple[str, str, Formulation]
#: Variant of rows whose stress was recovered from that of the particles around.
RECOVERED = "recovered stress"
#: Material of the free bodies: rubber-like and compressible.
SOLID = sph.NeoHookean.from_young(young_modulus=17.0e6, poisson_ratio=0.3, density=1100.0)
#: Steps of a free body.
STEPS = 60
_L = (((0.0, 0.0, 0.0), (3.0, 10.0, 3.0)), ((3.0, 0.0, 0.0), (6.0, 3.0, 3.0)))
#: Free bodies: shape -> its clouds.  A text is a cloud of the cube.
SHAPES: dict[str, dict[str, Body | str]] = {
    "cube": {
        "lattice": "lattice", "jitter 0.4": "jitter:0.4", "tet": "tet",
        "hex file": "hex:studies/meshes/cube_hex_8.msh",
        "tet file": "tet:studies/meshes/cube_tet_8.msh",
    },
    "cylinder": {
        f"{kind} file": MeshFile(MESHES / f"cylinder_{kind}.msh") for kind in ("hex", "tet")
    },
    "plate with a hole": {
        f"{kind} file": MeshFile(MESHES / f"plate_with_hole_{kind}.msh") for kind in ("hex", "tet")
    },
    "L-block": {
        "lattice": Blocks(_L, jitter=0.0), "jitter 0.2": Blocks(_L, jitter=0.2),
        "jitter 0.4": Blocks(_L, jitter=0.4),
    },
}  # fmt: skip
#: Energy budget: share of a period that is run, instants at which it is read, steps of the
#: coarsest run, within the limit of both integrators on every cloud of 9^3.
SHARE, INSTANTS, COARSEST = 0.25, 24, 96
#: CFL numbers from which the limits are bracketed.
CFL = (0.35, 0.7, 0.9, 1.1, 1.3, 1.6)


def cube_on(instance: Instance, *, scene: str, family: str, poisson_ratio: float = 0.3) -> Scene:
    """The swinging cube with the particles of a cloud."""
    return replace(cube_scene(scene, family, poisson_ratio=poisson_ratio), body=instance.body)


def about_the_set_up(sim: sph.Simulation) -> Row:
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
        **{name: getattr(found, name) for name in ("C0", "C1", "D0", "SBP", "volume")},
        "setup_s": sim.setup_seconds,
    }


def cube(
    *, cloud: str, level: int, method: Method, settings: Sequence[Setting], variant: str = "",
    label: str = "", poisson_ratio: float = 0.3, moving: bool = False,
) -> list[Row]:  # fmt: skip
    """Rows of every setting: the set-up once, then twelve errors each.

    ``label`` stands in the column ``operator`` where that of the operator does not say the method.
    ``moving``: the wave begins moving, not displaced.

    Twelve more with the stress recovered (``Recovery()``), as a variant of their own.  A run that
    diverged or folded has one row that says so.
    """
    instance = cloud_of(cloud).at(level)
    rows: list[Row] = []
    for scene, family, formulation in settings:
        sim = method.but(formulation=formulation).simulation(
            cube_on(
                instance, scene=f"{scene}, moving start" if moving else scene, family=family,
                poisson_ratio=poisson_ratio,
            ),
            spacing=instance.spacing,
        )
        common = {
            "cloud": label_of(cloud), "operator": label or sim.operator.name, "variant": variant,
            "h": instance.h,
        }  # fmt: skip
        if not rows:
            # Later set-ups read the operator from the disk: the first tells what it costs.
            rows.append(common | {"kind": "set-up"} | about_the_set_up(sim))
        setting = {"scene": scene, "family": family, "formulation": formulation.name}
        rows += _errors(sim, instance.h, common | setting)
    return rows


def _errors(sim: sph.Simulation, h: float, common: Row) -> list[Row]:
    snapshots: list[Snapshot] = []
    ran = attempt(sim, lambda: snapshots.extend(instants_of(sim)))
    common |= {"particles": sim.cloud.size, "steps": ran.steps}
    if ran.diverged is not None or ran.folded:
        folded = f"positions folded by {ran.folded_at:.3g} s"
        why = folded if ran.diverged is None else ran.diverged.reason
        return [common | {"kind": "unsound", "why": why}]
    recovery, exact = Recovery(), sim.scene.known_solution()
    fitted = [
        replace(shot, P=recovery(shot.field("P"), spacing=h).values) for shot in snapshots
    ]
    return [
        common
        | {
            "kind": "error", "variant": ", ".join(filter(None, (common["variant"], added))),
            "field": name.split("_")[0], "component": name.split("_")[1], "error": error,
            "step_ms": 1.0e3 * ran.wall_s / ran.steps,
        }
        for added, shots in (("", snapshots), (RECOVERED, fitted))
        for name, error in period_errors(instant_errors(shot, exact) for shot in shots).items()
    ]  # fmt: skip


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


def conservation(*, shape: str, cloud: str, method: Method, operator: str) -> list[Row]:
    """One row: the set-up, and the drift of both momenta in :data:`STEPS` steps."""
    row: Row = {"kind": "conservation", "shape": shape, "cloud": cloud, "operator": operator}
    body = SHAPES[shape][cloud]
    if isinstance(body, str):
        chosen = cloud_of(body)
        instance = chosen.at(chosen.levels(8)[-1])
    else:
        instance = Instance(body, 0.6 if shape == "L-block" else AS_MESHED, 0.0)
    X = instance.body.mesh(instance.spacing).vertices
    scene = free_body(instance.body, X.mean(axis=0), float(np.max(np.ptp(X, axis=0))))
    try:
        sim = method.simulation(scene, spacing=instance.spacing)
    except InputError as refusal:
        return [row | {"outcome": "refused", "why": str(refusal)}]
    row |= about_the_set_up(sim)
    sim.track_budget()

    def steps() -> None:
        for _ in range(STEPS):
            sim.advance(sim.stable_time_step())

    ran = attempt(sim, steps)
    row |= {"steps": ran.steps, "why": ""}
    if ran.diverged is not None:
        return [row | {"outcome": "diverged", "why": ran.diverged.reason}]
    end = sim.snapshot()
    positions = judge_positions(end)
    if positions.folded:
        return [row | {"outcome": "folded", "why": str(positions)}]
    drift = MomentumDrift().record(end, scene)
    return [
        row
        | {
            "outcome": "kept",
            "step_ms": 1.0e3 * ran.wall_s / ran.steps,
            "linear_drift": drift["linear_drift [kg m/s]"] / drift["linear_scale [kg m/s]"],
            "angular_drift": (
                drift["angular_drift [kg m^2/s]"] / drift["angular_scale [kg m^2/s]"]
            ),
        }
    ]


def energy(*, cloud: str, level: int, method: Method) -> list[Row]:
    """Three rows, ``dt``, ``dt / 2`` and ``dt / 4``: the largest residual of the energy budget.

    The manufactured cube, loaded and at large strain, without stabilisation or projection: the
    works of tractions, body force and constraints are accounted for, and the residual is the
    integrator's, and the operator's if it is not adjoint.
    """
    instance = cloud_of(cloud).at(level)
    scene = cube_on(instance, scene="manufactured", family="A+B+C=0")
    period = scene.known_solution().period
    rows = []
    for halving in range(3):
        sim = method.simulation(scene, spacing=instance.spacing)
        sim.track_budget()
        steps = COARSEST * 2**halving
        dt = SHARE * period / steps
        found, most = [], 0.0
        for step in range(1, steps + 1):
            sim.advance(dt)
            if step % (steps // INSTANTS) == 0:
                row = EnergyBudget().record(sim.snapshot(), scene)
                found.append(abs(row["energy_rest [J]"]))
                most = max(most, row["total_energy [J]"])
        rows.append(
            {
                "kind": "energy", "cloud": label_of(cloud), "operator": sim.operator.name,
                "integrator": sim.integrator.name, "h": instance.h, "particles": sim.cloud.size,
                "steps": steps, "dt": dt, "dt_over_stable": dt / sim.stable_time_step(),
                "residual": float(np.max(found)) / most,
            }
        )  # fmt: skip
    return rows


def spectrum(*, cloud: str, level: int, method: Method, operator: str) -> list[Row]:
    """A row: limits of the CFL number of a free cube at rest, and growth at the default one.

    Limits are those of ``studies.stability``: no growth (``strict``), tenfold in 1000 steps
    (``slow``) and in 50 (``fast``), in units of the least distance of two neighbours.
    """
    instance = cloud_of(cloud).at(level)
    scene = Scene(name="free_cube", body=instance.body, material=SOLID, end_time=1.0)
    row: dict[str, Any] = {
        "kind": "spectrum", "cloud": label_of(cloud), "operator": operator, "h": instance.h,
    }  # fmt: skip
    try:
        usual = method.simulation(scene, spacing=instance.spacing)
    except InputError as refusal:
        return [row | {"refused": str(refusal)}]
    linear = Linearisation(usual)

    def modulus(number: float) -> float:
        return largest_modulus(linear.eigenvalues(number))

    known = scan(modulus, CFL)
    return [
        row
        | {
            "particles": usual.cloud.size,
            "h_min_over_dx": usual.cloud.h_min / usual.cloud.spacing,
            "decades_at_default": decades(known[default_cfl(default_integrator())]),
            **limits(modulus, known),
        }
    ]
