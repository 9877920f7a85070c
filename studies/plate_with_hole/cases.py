"""One slow pull of the plate, by either solver: concentration, ligament, ring, picture."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fem_reference as fem
import sphsolid as sph
from sphsolid.cloud import OperatorKind
from sphsolid.geometry import Body, Mesh, MeshFile
from sphsolid.geometry.cell_shape import HEXAHEDRON
from sphsolid.scenes import plate_with_hole
from studies.pictures.face import save_face
from studies.plate_with_hole.recovery import at_cells, fitted, hoop
from studies.report.folding import folding

Array = NDArray[np.float64]
Row = dict[str, Any]
FEM, SPH = "B-bar FEM", "SUPG-SPH {p,F}"
MESHES = Path(__file__).parents[1] / "meshes"
OPERATORS: dict[str, OperatorKind] = {
    "SummationByParts": sph.SummationByParts(),
    "Consistent": sph.Consistent(),
}
STRESS, RADIUS, HALF_WIDTH = 2.1e7, 0.1, 0.5
#: Instants of the hold whose stresses are averaged.
INSTANTS = 16
#: Angles [deg] from the X axis at which the edge of the hole is asked for its hoop stress.
ANGLES = np.linspace(0.0, 90.0, 19)


@dataclass(frozen=True)
class Held:
    """Mean of ``P / S (n, 3, 3)`` over the hold where the law is evaluated, and of what run."""

    stress: Array
    X: Array
    mesh: Mesh
    at_particles: bool
    facts: Row


def run_case(
    *,
    key: str,
    method: str,
    operator: str,
    mesh: str,
    thickness: str,
    rise: float,
    hold: float,
    shots: str,
) -> list[Row]:
    """A row ``kind = value``, one ``ligament`` per place on it, one ``ring`` per cell at the hole.

    What a picture needs of the plate's front goes to the folder ``shots``.
    """
    body = MeshFile(MESHES / f"plate_with_hole_{mesh}.msh")
    held = pull(
        body, method=method, operator=operator, thickness=thickness, rise=rise, hold=hold
    )
    save_front(held, Path(shots) / f"{key}.npz")
    common = {
        "key": key, "method": method, "operator": operator, "mesh": mesh, "thickness": thickness,
    }  # fmt: skip
    return [common | row for row in measured(held)]


def pull(
    body: Body, *, method: str, operator: str, thickness: str, rise: float, hold: float
) -> Held:
    """The run itself, with everything but the operator at its default."""
    scene = plate_with_hole(
        body=body,
        thickness=thickness,  # type: ignore[arg-type]
        stress=STRESS,
        radius=RADIUS,
        half_width=HALF_WIDTH,
        rise=rise,
        hold=hold,
    )
    started = time.perf_counter()
    sim: Any = (
        fem.Simulation(scene)
        if method == FEM
        else sph.Simulation(scene, formulation=sph.PF(), operator=OPERATORS[operator])
    )
    ready = time.perf_counter()
    length = scene.end_time * hold / (rise + hold)
    instants = []
    for n in range(INSTANTS):
        sim.run(until=scene.end_time - length * (1.0 - (n + 1) / INSTANTS))
        instants.append(sim.snapshot().P / STRESS)
    last = sim.snapshot()
    peaks = [float(stress[:, 1, 1].max()) for stress in instants]
    return Held(
        stress=np.mean(instants, axis=0),
        X=last.stress_X,
        mesh=last.mesh,
        at_particles=method != FEM,
        facts={
            "particles": len(last.X),
            "steps": sim.step,
            "setup_s": ready - started,
            "wall_s": time.perf_counter() - ready,
            "kinetic_share": last.kinetic_energy / last.strain_energy,
            **folding(sim),
            "unrest": (max(peaks) - min(peaks)) / float(np.mean(peaks)),
        },
    )


def measured(held: Held) -> list[Row]:
    """The concentration in every way, the ligament and the ring of cells at the hole."""
    cells = held.mesh.cells
    centre = held.mesh.vertices[cells].mean(axis=1)
    in_cells = at_cells(held.stress, cells) if held.at_particles else held.stress
    angle = np.radians(ANGLES)
    edge = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    around = hoop(edge, fitted(centre, in_cells, edge))
    value: Row = {
        "kind": "value", "edge_fit": float(around[0]), "highest_fit": float(around.max()),
        "edge_particles": np.nan, "edge_spread": np.nan, "highest_particles": np.nan,
    }  # fmt: skip
    if held.at_particles:
        on_hole = held.mesh.face_particles("hole")
        values = hoop(held.X[on_hole], held.stress[on_hole])
        at_side = values[np.isclose(held.X[on_hole, 1], 0.0, atol=1e-9)]
        value |= {
            "edge_particles": float(at_side.mean()), "edge_spread": float(np.ptp(at_side)),
            "highest_particles": float(values.max()),
        }  # fmt: skip
    rows = [value | held.facts, *_ligament(held, centre, in_cells)]
    if held.mesh.shape is HEXAHEDRON:
        rows += _ring(held.mesh, centre, in_cells)
    return rows


def _ligament(held: Held, centre: Array, in_cells: Array) -> list[Row]:
    """Means over the thickness of what particles have, fitted for the finite elements."""
    vertices = held.mesh.vertices
    on_line = held.mesh.face_particles("symmetry_y")
    place, number = np.unique(np.round(vertices[on_line, 0], 9), return_inverse=True)
    if held.at_particles:
        count = np.bincount(number)
        stress = np.bincount(number, weights=held.stress[on_line, 1, 1]) / count
    else:
        at = np.stack([place, np.zeros_like(place)], axis=1)
        stress = fitted(centre, in_cells, at)[:, 1, 1]
    return [
        {"kind": "ligament", "X": float(x), "stress": float(s)}
        for x, s in zip(place, stress, strict=True)
    ]


def _ring(mesh: Mesh, centre: Array, in_cells: Array) -> list[Row]:
    """Hoop stress in the middle of the cells at the hole, a mean over the layers."""
    beside = np.flatnonzero(np.isin(mesh.cells, mesh.face_particles("hole")).any(axis=1))
    values = hoop(centre[beside], in_cells[beside])
    angle = np.degrees(np.arctan2(centre[beside, 1], centre[beside, 0]))
    place, number = np.unique(np.round(angle, 6), return_inverse=True)
    mean = np.bincount(number, weights=values) / np.bincount(number)
    return [
        {"kind": "ring", "angle": float(a), "stress": float(s)}
        for a, s in zip(place, mean, strict=True)
    ]


def save_front(held: Held, path: Path) -> None:
    """The front with the hoop stress at its vertices, fitted for finite elements."""
    X, front = held.mesh.vertices, held.mesh.face_particles("front")
    stress = held.stress if held.at_particles else np.zeros((len(X), 3, 3))
    if not held.at_particles:
        stress[front] = fitted(held.X, held.stress, X[front, :2])
    save_face(path, held.mesh, "front", X, hoop(X, stress))
