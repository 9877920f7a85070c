"""One motion, whatever the unit, the mirror or the place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sphsolid as sph
from sphsolid.continuum.neo_hookean import NeoHookean
from sphsolid.geometry import Box, TetBox
from sphsolid.geometry.body import Spacing
from sphsolid.geometry.integrals import vertex_volumes
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.constraint import Constraint
from sphsolid.scenes.scene import Scene
from tests.oracles import moved_meshes as moved

Array = NDArray[np.float64]
SIZE = (1.0, 0.75, 0.5)
BODIES = {
    "disordered": Box(upper=SIZE, jitter=0.4, seed=3).mesh(0.25),
    "sheared": moved.sheared(Box(upper=SIZE, jitter=0.4, seed=4).mesh(0.25)),
    "tetrahedra": TetBox(upper=SIZE).mesh(0.25),
}


@dataclass(frozen=True)
class Ready:
    """A body that is a mesh already."""

    ready: Mesh
    volume: float

    def mesh(self, spacing: Spacing) -> Mesh:
        return self.ready


def motion(
    mesh: Mesh, *, unit: float = 1.0, sign: float = 1.0, place: Array | float = 0.0
) -> tuple[Array, Array]:
    """Displacements and velocities ``(N, 3)`` at 2 ms, in units of length and not mirrored."""

    def start(X: Array) -> Array:
        x = (X - place) / unit * [sign, 1.0, 1.0]
        v = np.stack([np.sin(np.pi * x[:, 1]), 0.0 * x[:, 0], x[:, 0]], axis=1)
        return np.asarray(20.0 * unit * v * [sign, 1.0, 1.0])

    volume = float(np.sum(vertex_volumes(mesh)))
    scene = Scene(
        name="block",
        body=Ready(mesh, volume),
        end_time=2e-3,
        initial_velocity=start,
        material=NeoHookean.from_young(
            young_modulus=17e6 / unit, poisson_ratio=0.3, density=1100.0 / unit**3
        ),
        constraints=(Constraint("X-", "all"),),
    )
    sim = sph.Simulation(scene, spacing=0.25 * unit)
    sim.run()
    now = sim.snapshot()
    back = np.array([sign, 1.0, 1.0]) / unit
    return (now.x - now.X) * back, now.velocity * back


@pytest.fixture(scope="module", params=BODIES)
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return BODIES[request.param]


@pytest.fixture(scope="module")
def known(mesh: Mesh) -> tuple[Array, Array]:
    return motion(mesh)


def same(found: tuple[Array, Array], known: tuple[Array, Array], tolerance: float) -> None:
    for a, b in zip(found, known, strict=True):
        assert np.max(np.abs(a - b)) < tolerance * np.max(np.abs(b))


@pytest.mark.parametrize("unit", [1e-3, 0.3048, 1e3])
def test_in_any_unit(mesh: Mesh, known: tuple[Array, Array], unit: float) -> None:
    same(motion(moved.scaled(mesh, unit), unit=unit), known, 1e-8)


def test_in_a_mirror(mesh: Mesh, known: tuple[Array, Array]) -> None:
    same(motion(moved.mirrored(mesh), sign=-1.0), known, 1e-8)


@pytest.mark.parametrize(("far", "tolerance"), [(1e4, 1e-9), (1e6, 1e-7)])
def test_at_any_place(mesh: Mesh, far: float, tolerance: float) -> None:
    """Positions of 1e6 m are rounded to 1e-10 m at every step: no more than that is lost."""
    place = np.array([far, -far, far])
    there = moved.elsewhere(mesh, (far, -far, far))
    back = moved.elsewhere(there, (-far, far, -far))
    same(motion(there, place=place), motion(back), tolerance)


def test_two_parts_move_as_if_alone(mesh: Mesh) -> None:
    alone: Any = motion(mesh)
    n = len(mesh.vertices)
    both = motion(moved.twice(mesh, (0.0, 4.0, 0.0)))
    same((both[0][:n], both[1][:n]), alone, 1e-8)


@pytest.mark.parametrize("operator", [sph.Consistent(), sph.SummationByParts()], ids=str)
def test_pairs_on_a_lattice_in_any_unit_and_place(operator: Any) -> None:
    """A motion that keeps volumes stands where the stiffness of pressed pairs begins."""

    def moved_by(unit: float, place: float) -> Array:
        def start(X: Array) -> Array:
            x = (X - place) / unit
            v = np.stack([5.0 * x[:, 2] ** 2, 3.0 * x[:, 0], 0.0 * x[:, 0]], axis=1)
            return np.asarray(unit * v)

        body = Box((place,) * 3, (place + unit, place + unit, place + 1.5 * unit))
        law = NeoHookean.from_young(
            young_modulus=1e6 / unit, poisson_ratio=0.45, density=1e3 / unit**3
        )
        scene = Scene(
            name="block", body=body, material=law, end_time=4e-3, initial_velocity=start,
            constraints=(Constraint("Z-", "all"),),
        )  # fmt: skip
        sim = sph.Simulation(
            scene, spacing=0.25 * unit, formulation=sph.Displacement(), operator=operator,
            stabilisation=sph.Restraint(),
        )  # fmt: skip
        sim.run()
        return np.asarray(sim.snapshot().displacement / unit)

    known = moved_by(1.0, 0.0)
    for unit, place in ((1e-3, 0.0), (1.0, 31.7)):
        assert np.max(np.abs(moved_by(unit, place) - known)) < 1e-10 * np.max(np.abs(known))
