"""Areas of the tags of a body in parts: a tag may lie on some of them only."""

from __future__ import annotations

import numpy as np
import pytest

import sphsolid as sph
from sphsolid.cloud.boundary_weights import quadratically_exact_areas
from sphsolid.continuum import NeoHookean
from sphsolid.geometry import Blocks, Region, Tagged
from sphsolid.geometry.body import Body
from sphsolid.geometry.integrals import area_vectors
from sphsolid.geometry.mesh import Mesh
from sphsolid.scenes.scene import Scene

CUBE = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
ALIGNED = ((0.0, 0.0, 6.0), (1.0, 1.0, 7.0))
BESIDE = ((0.1, 0.0, 6.0), (1.1, 1.0, 7.0))
FAR = ((5.0, 0.0, 0.0), (6.5, 1.0, 1.0))
#: An L and a cube: the L's inner faces have tags of their own.
ELL = (CUBE, ((1.0, 0.0, 0.0), (2.0, 1.0, 1.0)), ((0.0, 0.0, 1.0), (1.0, 1.0, 2.0)))
BODIES: dict[str, Body] = {
    "aligned": Blocks((CUBE, ALIGNED)),
    "beside one another": Blocks((CUBE, BESIDE)),
    "three": Blocks((CUBE, BESIDE, FAR)),
    "an L and a cube": Blocks((*ELL, FAR)),
}
BODIES["a region on one part"] = Tagged(
    BODIES["aligned"],
    (Region("foot", sorted(BODIES["aligned"].mesh(0.5).faces)[0], lambda X: X[:, 2] < 0.6),),
)


@pytest.fixture(params=BODIES)
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return BODIES[request.param].mesh(0.5)


def test_the_areas_of_a_tag_add_up_over_the_parts(mesh: Mesh) -> None:
    areas = quadratically_exact_areas(mesh)
    assert areas.keys() == mesh.faces.keys()
    X = mesh.vertices
    for name, facets in mesh.faces.items():
        plain = area_vectors(mesh, facets)
        np.testing.assert_allclose(areas[name].sum(axis=0), plain.sum(axis=0), atol=1e-12)
        np.testing.assert_allclose(areas[name].T @ X, plain.T @ X, atol=1e-11)
        elsewhere = np.setdiff1d(np.arange(len(X)), facets)
        assert not areas[name][elsewhere].any()


def test_each_part_has_the_areas_it_has_alone() -> None:
    half_a_cube_off = ((0.5, 0.0, 6.0), (1.5, 1.0, 7.0))
    both = Blocks((CUBE, half_a_cube_off)).mesh(0.5)
    together = np.sum(list(quadratically_exact_areas(both).values()), axis=0)
    for block in (CUBE, half_a_cube_off):
        alone = Blocks((block,)).mesh(0.5)
        expected = np.sum(list(quadratically_exact_areas(alone).values()), axis=0)
        at = [int(np.argmin(np.linalg.norm(both.vertices - x, axis=1))) for x in alone.vertices]
        np.testing.assert_allclose(together[at], expected, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("top", [ALIGNED, BESIDE])
def test_two_boxes_run_as_two_bodies(top: tuple[tuple[float, ...], tuple[float, ...]]) -> None:
    rubber = NeoHookean.from_young(young_modulus=1e6, poisson_ratio=0.3, density=1e3)
    scene = Scene(name="two", body=Blocks((CUBE, top)), material=rubber, end_time=0.01)  # type: ignore[arg-type]
    simulation = sph.Simulation(scene, spacing=0.25, operator=sph.SummationByParts())
    simulation.advance(simulation.stable_time_step())
    assert np.allclose(simulation.snapshot().x, simulation.cloud.X, atol=1e-9)
